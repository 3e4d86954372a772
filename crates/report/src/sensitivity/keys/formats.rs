//! The experiment for programs: CSV and JSON.

use serde_json::{Map, Value, json};

use crate::document::{Cell, Column, Table};
use crate::sensitivity::outcome::{outcome_json, traces_json};
use powergs_study::findings::cost::Cost;
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::keys::{KeyRow, Keys, NotTried, Perturbation, Reach};

/// One line a key, value and trace, exact numbers.
pub fn csv(all: &Keys) -> Vec<u8> {
    let mut table = Table::record(
        "file key reach value ratio trace frames frame_time_ms fps energy_pj \
         power_display_rate_w area_mm2 fps_change energy_change power_change area_change \
         refused",
    );
    for row in &all.rows {
        let base = Perturbation {
            reach: Reach::Near,
            value: row.value.clone(),
            ratio: None,
            outcomes: Ok(row.base.clone()),
        };
        let perturbed = row.perturbations.iter().map(|t| (t.reach.name(), t));
        for (reach, perturbed) in [("base", &base)].into_iter().chain(perturbed) {
            for (t, trace) in all.traces.iter().enumerate() {
                let outcome = perturbed.outcomes.as_ref().ok().and_then(|o| o.get(t));
                let of = |f: fn(&Cost) -> Option<f64>| Cell::from(outcome.and_then(f));
                let mut cells: Vec<Cell> = vec![
                    row.file.into(),
                    row.key.as_str().into(),
                    reach.into(),
                    perturbed.value.as_str().into(),
                    perturbed.ratio.into(),
                    trace.name.as_str().into(),
                    trace.frames.into(),
                    of(|o| Some(o.frame_time_ms)),
                    of(|o| Some(o.fps())),
                    of(|o| Some(o.energy_pj)),
                    of(|o| Some(o.power_w)),
                    of(|o| o.area_mm2),
                ];
                let pair = outcome.zip(row.base.get(t));
                let change = |m: Measure| pair.and_then(|(new, base)| m.change(new, base));
                cells.extend(Measure::ALL.map(|m| Cell::from(change(m))));
                cells.push(perturbed.outcomes.as_ref().err().cloned().into());
                table.row(cells);
            }
        }
    }
    table.csv()
}

/// One line a key: its elasticities, what half and double do, its status.
pub fn elasticities_csv(all: &Keys) -> Vec<u8> {
    let mut head: Vec<String> = ["file", "key", "value", "status"].map(str::to_owned).to_vec();
    head.extend(Measure::ALL.map(|m| format!("elasticity_{}", m.name())));
    head.push("elasticity_sides".to_owned());
    head.push("elasticity_shape".to_owned());
    for m in Measure::ALL {
        let name = m.name();
        head.extend([format!("{name}_change_low"), format!("{name}_change_high")]);
    }
    head.extend(["far_change", "largest_change", "reason"].map(str::to_owned));
    let mut table = Table::new(head.into_iter().map(Column::text));
    for row in &all.rows {
        let words = [row.file, &row.key, &row.value, row.status().name()];
        let mut cells: Vec<Cell> = words.map(Cell::from).to_vec();
        cells.extend(Measure::ALL.map(|m| Cell::from(row.elasticity(m).map(|e| e.value))));
        cells.push(sides(row).into());
        cells.push(sides(row).map(|_| row.shape(Measure::Fps).name()).into());
        cells.extend(Measure::ALL.into_iter().flat_map(|m| row.far(m).map(Cell::from)));
        cells.push(row.far_effect().into());
        cells.push(row.largest().into());
        cells.push(row.reason.clone().into());
        table.row(cells);
    }
    table.csv()
}

fn sides(row: &KeyRow) -> Option<&'static str> {
    row.elasticity(Measure::Fps).map(|e| e.sides)
}

/// The experiment as JSON.
pub fn json(all: &Keys) -> Value {
    let varied = |t: &Perturbation| {
        let mut value = json!({ "reach": t.reach.name(), "value": t.value, "ratio": t.ratio });
        match &t.outcomes {
            Ok(outcomes) => value["outcomes"] = outcomes.iter().map(outcome_json).collect(),
            Err(reason) => value["refused"] = reason.clone().into(),
        }
        value
    };
    let row = |row: &KeyRow| {
        let elasticity: Map<String, Value> = Measure::ALL
            .into_iter()
            .map(|m| (m.name().to_owned(), json!(row.elasticity(m).map(|e| e.value))))
            .collect();
        json!({
            "file": row.file,
            "key": row.key,
            "value": row.value,
            "status": row.status().name(),
            "elasticity": elasticity,
            "elasticity_sides": sides(row),
            "elasticity_shape": sides(row).map(|_| row.shape(Measure::Fps).name()),
            "far_change": row.far_effect(),
            "largest_change": row.largest(),
            "reason": row.reason,
            "varied": row.perturbations.iter().map(varied).collect::<Vec<_>>(),
        })
    };
    let not_tried = |n: &NotTried| json!({ "file": n.file, "keys": n.keys, "why": n.why });
    json!({
        "machine": all.machine,
        "incomplete": all.incomplete_note().is_some(),
        "display_fps": all.display_fps,
        "step": all.step,
        "traces": traces_json(&all.traces),
        "keys": all.rows.iter().map(row).collect::<Vec<_>>(),
        "not_tried": all.not_tried.iter().map(not_tried).collect::<Vec<_>>(),
    })
}
