//! The experiment for programs: CSV and JSON.

use serde_json::{Map, Value, json};

use crate::ReportError;
use crate::sensitivity::outcome::traces_json;
use powergs_study::analysis::indices::{Estimate, Index};
use powergs_study::analysis::morris::Effect;
use powergs_study::findings::sensitivity::interactions::{Factor, Interactions, Results};

/// One line a key and measure. Effects are percent of the machine as it is, indices shares of the
/// variance with their 95 % intervals; the columns of the other method are empty.
///
/// # Errors
/// [`ReportError::Csv`], which would be a mistake of ours.
pub fn csv(all: &Interactions) -> Result<Vec<u8>, ReportError> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "method",
        "file",
        "key",
        "value",
        "levels",
        "measure",
        "mu_percent",
        "mu_star_percent",
        "sigma_percent",
        "first",
        "first_low",
        "first_high",
        "total",
        "total_low",
        "total_high",
    ])?;
    let mut write = |measure: &str, i: usize, numbers: [Vec<f64>; 2]| {
        let factor = &all.factors[i];
        let mut record: Vec<String> = vec![
            all.results.name().into(),
            factor.file.into(),
            factor.key.clone(),
            factor.value.clone(),
            factor.levels.join(" | "),
            measure.into(),
        ];
        for (numbers, width) in numbers.iter().zip([3, 6]) {
            let text = numbers.iter().map(f64::to_string);
            record.extend(text.chain(std::iter::repeat(String::new())).take(width));
        }
        writer.write_record(record)
    };
    for i in all.order() {
        match &all.results {
            Results::Morris(found) => {
                for (m, effects) in found {
                    let Effect { mu, mu_star, sigma } = effects[i];
                    write(m.name(), i, [vec![mu, mu_star, sigma], vec![]])?;
                }
            }
            Results::Sobol(found) => {
                for (m, indices) in found {
                    let Index { first, total } = indices.each[i];
                    let numbers =
                        [first.value, first.low, first.high, total.value, total.low, total.high];
                    write(m.name(), i, [vec![], numbers.to_vec()])?;
                }
            }
        }
    }
    Ok(writer.into_inner().expect("writing to memory cannot fail"))
}

/// One line a distinct machine: the value of every key, and what it costs.
///
/// # Errors
/// As [`csv()`].
pub fn designs_csv(all: &Interactions) -> Result<Vec<u8>, ReportError> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let mut head: Vec<&str> = all.factors.iter().map(|f| f.key.as_str()).collect();
    head.extend(["frame_time_ms", "fps", "energy_pj", "power_display_rate_w", "area_mm2"]);
    writer.write_record(head)?;
    for point in &all.points {
        let values = all.factors.iter().zip(&point.levels).map(|(f, &l)| f.levels[l].clone());
        let mut record: Vec<String> = values.collect();
        let o = &point.outcome;
        record.extend([o.frame_time_ms, o.fps(), o.energy_pj, o.power_w].map(|x| x.to_string()));
        record.push(o.area_mm2.map_or(String::new(), |a| a.to_string()));
        writer.write_record(record)?;
    }
    Ok(writer.into_inner().expect("writing to memory cannot fail"))
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
