//! The experiment for programs: CSV and JSON.

use serde_json::{Map, Value, json};

use crate::ReportError;
use crate::sensitivity::outcome::{outcome_json, traces_json};
use powergs_study::findings::sensitivity::keys::{KeyRow, Keys, NotTried, Reach, Turned};
use powergs_study::findings::sensitivity::{Measure, Outcome};

fn number(x: Option<f64>) -> String {
    x.map_or(String::new(), |x| x.to_string())
}

/// One line a key, value and trace, exact numbers.
///
/// # Errors
/// [`ReportError::Csv`], which would be a mistake of ours.
pub fn csv(all: &Keys) -> Result<Vec<u8>, ReportError> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "file",
        "key",
        "reach",
        "value",
        "ratio",
        "trace",
        "frames",
        "frame_time_ms",
        "fps",
        "energy_pj",
        "power_display_rate_w",
        "area_mm2",
        "fps_change",
        "energy_change",
        "power_change",
        "area_change",
        "refused",
    ])?;
    for row in &all.rows {
        let base = Turned {
            reach: Reach::Near,
            value: row.value.clone(),
            ratio: None,
            outcomes: Ok(row.base.clone()),
        };
        let turns = row.turns.iter().map(|t| (t.reach.name(), t));
        for (reach, turned) in [("base", &base)].into_iter().chain(turns) {
            for (t, trace) in all.traces.iter().enumerate() {
                let outcome = turned.outcomes.as_ref().ok().and_then(|o| o.get(t));
                let of = |f: fn(&Outcome) -> Option<f64>| number(outcome.and_then(f));
                let mut record = vec![
                    row.file.to_owned(),
                    row.key.clone(),
                    reach.to_owned(),
                    turned.value.clone(),
                    number(turned.ratio),
                    trace.name.clone(),
                    trace.frames.to_string(),
                    of(|o| Some(o.frame_time_ms)),
                    of(|o| Some(o.fps())),
                    of(|o| Some(o.energy_pj)),
                    of(|o| Some(o.power_w)),
                    of(|o| o.area_mm2),
                ];
                let pair = outcome.zip(row.base.get(t));
                let change = |m: Measure| pair.and_then(|(new, base)| m.change(new, base));
                record.extend(Measure::ALL.map(|m| number(change(m))));
                record.push(turned.outcomes.as_ref().err().cloned().unwrap_or_default());
                writer.write_record(record)?;
            }
        }
    }
    Ok(writer.into_inner().expect("writing to memory cannot fail"))
}

/// One line a key: its elasticities, what half and double do, its status.
///
/// # Errors
/// As [`csv()`].
pub fn elasticities_csv(all: &Keys) -> Result<Vec<u8>, ReportError> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let mut head: Vec<String> = ["file", "key", "value", "status"].map(str::to_owned).to_vec();
    head.extend(Measure::ALL.map(|m| format!("elasticity_{}", m.name())));
    head.push("elasticity_sides".to_owned());
    for m in Measure::ALL {
        let name = m.name();
        head.extend([format!("{name}_change_low"), format!("{name}_change_high")]);
    }
    head.extend(["largest_change", "reason"].map(str::to_owned));
    writer.write_record(head)?;
    for row in &all.rows {
        let mut record: Vec<String> =
            vec![row.file.into(), row.key.clone(), row.value.clone(), row.status().name().into()];
        record.extend(Measure::ALL.map(|m| number(row.elasticity(m).map(|e| e.value))));
        record.push(sides(row).unwrap_or_default().to_owned());
        for m in Measure::ALL {
            record.extend(row.far(m).map(number));
        }
        record.push(row.largest().to_string());
        record.push(row.reason.clone().unwrap_or_default());
        writer.write_record(record)?;
    }
    Ok(writer.into_inner().expect("writing to memory cannot fail"))
}

fn sides(row: &KeyRow) -> Option<&'static str> {
    row.elasticity(Measure::Fps).map(|e| e.sides)
}

/// The experiment as JSON.
pub fn json(all: &Keys) -> Value {
    let turned = |t: &Turned| {
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
            "largest_change": row.largest(),
            "reason": row.reason,
            "turned": row.turns.iter().map(turned).collect::<Vec<_>>(),
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
