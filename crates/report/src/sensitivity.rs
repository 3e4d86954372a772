//! What every assumption moves: the frame rate, the energy of a frame and the area of the chip,
//! with its knob turned down and up. What every key moves is in [`keys`], and how keys act together
//! in [`interactions`].

mod chart;
pub mod interactions;
pub mod keys;
mod outcome;
mod text;

pub use chart::charts;
pub use text::{markdown, terminal};

use serde_json::{Value, json};

use super::ReportError;
use outcome::{outcome_json, traces_json};
use powergs_study::findings::sensitivity::{Fixed, Outcome, Row, Sensitivity, Side};

/// One line a knob, side and trace, exact numbers.
///
/// # Errors
/// [`ReportError::Csv`], which would be a mistake of ours.
pub fn csv(all: &Sensitivity) -> Result<Vec<u8>, ReportError> {
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "assumption",
        "file",
        "keys",
        "with",
        "machine",
        "side",
        "value",
        "trace",
        "frames",
        "frame_time_ms",
        "fps",
        "energy_pj",
        "area_mm2",
        "fps_change",
        "energy_change",
        "area_change",
        "refused",
    ])?;
    for row in &all.rows {
        for (name, side) in sides(row) {
            for (t, trace) in all.traces.iter().enumerate() {
                let outcome = side.outcomes.as_ref().ok().and_then(|o| o.get(t));
                let change = outcome.zip(row.base.get(t)).map(|(o, base)| o.change(base));
                let area = outcome.and_then(|o| o.area_mm2);
                let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
                writer.write_record([
                    row.number.clone(),
                    row.file.to_owned(),
                    row.keys.join(" "),
                    row.with.join(" "),
                    row.on.clone().unwrap_or_else(|| all.machine.clone()),
                    name.to_owned(),
                    side.value.clone(),
                    trace.name.clone(),
                    trace.frames.to_string(),
                    number(outcome.map(|o| o.frame_time_ms)),
                    number(outcome.map(Outcome::fps)),
                    number(outcome.map(|o| o.energy_pj)),
                    number(area),
                    number(change.map(|c| c.fps)),
                    number(change.map(|c| c.energy)),
                    number(area.and(change.map(|c| c.area))),
                    side.outcomes.as_ref().err().cloned().unwrap_or_default(),
                ])?;
            }
        }
    }
    Ok(writer.into_inner().expect("writing to memory cannot fail"))
}

/// Base, low and high of a row, those that it has.
fn sides(row: &Row) -> Vec<(&'static str, Side)> {
    let base = Side { value: row.value.clone(), outcomes: Ok(row.base.clone()) };
    let all = [("base", Some(base)), ("low", row.low.clone()), ("high", row.high.clone())];
    all.into_iter().filter_map(|(name, side)| Some((name, side?))).collect()
}

/// The experiment as JSON.
pub fn json(all: &Sensitivity) -> Value {
    let outcome = outcome_json;
    let side = |side: &Side| match &side.outcomes {
        Ok(outcomes) => {
            let outcomes: Vec<Value> = outcomes.iter().map(outcome).collect();
            json!({ "value": side.value, "outcomes": outcomes })
        }
        Err(reason) => json!({ "value": side.value, "refused": reason }),
    };
    let row = |row: &Row| {
        json!({
            "assumption": row.number,
            "text": row.text,
            "file": row.file,
            "keys": row.keys,
            "with": row.with,
            "machine": row.on.as_deref().unwrap_or(&all.machine),
            "value": row.value,
            "effect": row.effect(),
            "base": row.base.iter().map(outcome).collect::<Vec<_>>(),
            "low": row.low.as_ref().map(side),
            "high": row.high.as_ref().map(side),
        })
    };
    let fixed = |f: &Fixed| json!({ "assumption": f.number, "text": f.text, "why": f.why });
    json!({
        "machine": all.machine,
        "incomplete": all.incomplete_note().is_some(),
        "traces": traces_json(&all.traces),
        "rows": all.rows.iter().map(row).collect::<Vec<_>>(),
        "without_knob": all.fixed.iter().map(fixed).collect::<Vec<_>>(),
    })
}
