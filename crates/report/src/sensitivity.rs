//! What every assumption moves: the frame rate, the energy of a frame and the area of the chip,
//! with its knob varied down and up. What every key moves is in [`keys`], and how keys act together
//! in [`interactions`].

mod chart;
pub mod interactions;
pub mod keys;
mod outcome;
mod page;

pub use chart::charts;
pub use page::document;

use serde_json::{Value, json};

use super::document::Table;
use outcome::{outcome_json, traces_json};
use powergs_study::findings::cost::Cost;
use powergs_study::findings::sensitivity::{Fixed, KnobEffect, KnobSetting, Sensitivity};

/// One line a knob, side and trace, exact numbers.
pub fn csv(all: &Sensitivity) -> Vec<u8> {
    let mut table = Table::record(
        "assumption file keys with machine side value trace frames frame_time_ms fps \
         energy_pj area_mm2 fps_change energy_change area_change refused",
    );
    for row in &all.rows {
        for (name, side) in sides(row) {
            for (t, trace) in all.traces.iter().enumerate() {
                let outcome = side.outcomes.as_ref().ok().and_then(|o| o.get(t));
                let change = outcome.zip(row.base.get(t)).map(|(o, base)| o.change(base));
                let area = outcome.and_then(|o| o.area_mm2);
                table.row([
                    row.number.as_str().into(),
                    row.file.into(),
                    row.keys.join(" ").into(),
                    row.with.join(" ").into(),
                    row.on.as_deref().unwrap_or(&all.machine).into(),
                    name.into(),
                    side.value.as_str().into(),
                    trace.name.as_str().into(),
                    trace.frames.into(),
                    outcome.map(|o| o.frame_time_ms).into(),
                    outcome.map(Cost::fps).into(),
                    outcome.map(|o| o.energy_pj).into(),
                    area.into(),
                    change.map(|c| c.fps).into(),
                    change.map(|c| c.energy).into(),
                    area.and(change.map(|c| c.area)).into(),
                    side.outcomes.as_ref().err().cloned().into(),
                ]);
            }
        }
    }
    table.csv()
}

/// Base, low and high of a row, those that it has.
fn sides(row: &KnobEffect) -> Vec<(&'static str, KnobSetting)> {
    let base = KnobSetting { value: row.value.clone(), outcomes: Ok(row.base.clone()) };
    let all = [("base", Some(base)), ("low", row.low.clone()), ("high", row.high.clone())];
    all.into_iter().filter_map(|(name, side)| Some((name, side?))).collect()
}

/// The experiment as JSON.
pub fn json(all: &Sensitivity) -> Value {
    let outcome = outcome_json;
    let side = |side: &KnobSetting| match &side.outcomes {
        Ok(outcomes) => {
            let outcomes: Vec<Value> = outcomes.iter().map(outcome).collect();
            json!({ "value": side.value, "outcomes": outcomes })
        }
        Err(reason) => json!({ "value": side.value, "refused": reason }),
    };
    let row = |row: &KnobEffect| {
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
