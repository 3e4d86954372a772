//! The experiment for programs: CSV and JSON.

use serde_json::{Map, Value, json};

use crate::document::{Cell, Column, Table};
use crate::sensitivity::outcome::traces_json;
use powergs_study::analysis::indices::{Estimate, Index};
use powergs_study::analysis::morris::Effect;
use powergs_study::findings::sensitivity::interactions::{Factor, Interactions, Results};

/// One line a key and measure. Effects are percent of the machine as it is, indices shares of the
/// variance with their 95 % intervals; the columns of the other method are empty.
pub fn csv(all: &Interactions) -> Vec<u8> {
    let mut table = Table::record(
        "method file key value levels measure mu_percent mu_star_percent sigma_percent \
         first first_low first_high total total_low total_high",
    );
    let mut write =
        |measure: &str, i: usize, effects: [Option<f64>; 3], indices: [Option<f64>; 6]| {
            let factor = &all.factors[i];
            let words: [Cell; 6] = [
                all.results.name().into(),
                factor.file.into(),
                factor.key.as_str().into(),
                factor.value.as_str().into(),
                factor.levels.join(" | ").into(),
                measure.into(),
            ];
            let numbers = effects.into_iter().chain(indices).map(Cell::from);
            table.row(words.into_iter().chain(numbers));
        };
    for i in all.order() {
        match &all.results {
            Results::Morris(found) => {
                for (m, effects) in found {
                    let Effect { mu, mu_star, sigma } = effects[i];
                    write(m.name(), i, [mu, mu_star, sigma].map(Some), [None; 6]);
                }
            }
            Results::Sobol(found) => {
                for (m, indices) in found {
                    let Index { first, total } = indices.each[i];
                    let numbers =
                        [first.value, first.low, first.high, total.value, total.low, total.high];
                    write(m.name(), i, [None; 3], numbers.map(Some));
                }
            }
        }
    }
    table.csv()
}

/// One line a distinct machine: the value of every key, and what it costs.
pub fn designs_csv(all: &Interactions) -> Vec<u8> {
    const COSTS: [&str; 5] =
        ["frame_time_ms", "fps", "energy_pj", "power_display_rate_w", "area_mm2"];
    let keys = all.factors.iter().map(|f| f.key.as_str());
    let mut table = Table::new(keys.chain(COSTS).map(Column::text));
    for point in &all.points {
        let values = all.factors.iter().zip(&point.levels).map(|(f, &l)| f.levels[l].as_str());
        let o = &point.outcome;
        let costs = [o.frame_time_ms, o.fps(), o.energy_pj, o.power_w].map(Cell::Real);
        let costs = costs.into_iter().chain([Cell::from(o.area_mm2)]);
        table.row(values.map(Cell::from).chain(costs));
    }
    table.csv()
}

/// The experiment as JSON.
pub fn json(all: &Interactions) -> Value {
    let factor = |i: usize| {
        let Factor { file, key, value, levels } = &all.factors[i];
        let measures: Map<String, Value> = match &all.results {
            Results::Morris(found) => {
                found.iter().map(|(m, e)| (m.name().to_owned(), effect(&e[i]))).collect()
            }
            Results::Sobol(found) => {
                found.iter().map(|(m, e)| (m.name().to_owned(), index(&e.each[i]))).collect()
            }
        };
        json!({ "file": file, "key": key, "value": value, "levels": levels, "measures": measures })
    };
    let alone: Map<String, Value> = match &all.results {
        Results::Morris(_) => Map::new(),
        Results::Sobol(found) => {
            found.iter().map(|(m, i)| (m.name().to_owned(), estimate(&i.alone))).collect()
        }
    };
    json!({
        "method": all.results.name(),
        "machine": all.machine,
        "incomplete": all.incomplete_note().is_some(),
        "display_fps": all.display_fps,
        "traces": traces_json(&all.traces),
        "samples": all.samples,
        "samples_asked_for": all.asked,
        "samples_drawn_again": all.redrawn,
        "machines": all.points.len(),
        "seed": all.seed,
        "explained_alone": alone,
        "factors": all.order().into_iter().map(factor).collect::<Vec<_>>(),
    })
}

fn effect(e: &Effect) -> Value {
    json!({ "mu_percent": e.mu, "mu_star_percent": e.mu_star, "sigma_percent": e.sigma })
}

fn index(i: &Index) -> Value {
    json!({ "first": estimate(&i.first), "total": estimate(&i.total) })
}

fn estimate(e: &Estimate) -> Value {
    json!({ "value": e.value, "low": e.low, "high": e.high })
}
