//! What every assumption moves: the frame rate, the energy of a frame and the area of the chip,
//! with its knob turned down and up. What every key moves is in [`keys`], and how keys act together
//! in [`interactions`].

mod chart;
pub mod interactions;
pub mod keys;
mod outcome;
mod text;

pub use chart::charts;
pub use outcome::{Change, Measure, Outcome, Traced, incomplete_note, traces_json};
pub use text::{markdown, terminal};

use serde_json::{Value, json};

use super::ReportError;

/// A knob turned one way.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// Value of the keys, as in a file.
    pub value: String,
    /// What it costs, by trace; or why that is no machine.
    pub outcomes: Result<Vec<Outcome>, String>,
}

/// One knob of one assumption.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// `A4`.
    pub number: String,
    /// What is assumed.
    pub text: String,
    /// Kind of file that has the keys.
    pub file: &'static str,
    /// The keys.
    pub keys: Vec<String>,
    /// What the machine has, as in a file.
    pub value: String,
    /// `--set` values of the machine that the knob needs.
    pub with: Vec<String>,
    /// The machine that is turned, where it is not the one of the experiment.
    pub on: Option<String>,
    /// The machine with those, by trace.
    pub base: Vec<Outcome>,
    /// Turned down; `None` for a knob that has names, not numbers.
    pub low: Option<Side>,
    /// Turned up, or to another name.
    pub high: Option<Side>,
}

impl Row {
    /// The changes on one trace, down and up.
    pub fn changes(&self, trace: usize) -> [Option<Change>; 2] {
        [&self.low, &self.high].map(|side| {
            let outcomes = side.as_ref()?.outcomes.as_ref().ok()?;
            Some(outcomes.get(trace)?.change(self.base.get(trace)?))
        })
    }

    /// The largest change on any trace.
    pub fn effect(&self) -> f64 {
        let all = (0..self.base.len()).flat_map(|t| self.changes(t));
        all.flatten().map(|c| c.largest()).fold(0.0, f64::max)
    }

    /// The keys in a few words; a name that is tried, and another machine, are said too.
    pub fn knob(&self) -> String {
        let first = self.keys.first().map_or("", String::as_str);
        let more = if self.keys.len() > 1 { ", ..." } else { "" };
        let on = self.on.as_ref().map_or(String::new(), |on| format!("{on}: "));
        match (&self.low, &self.high) {
            (None, Some(other)) => format!("{on}{first}={}", other.value),
            _ => format!("{on}{first}{more}"),
        }
    }
}

/// An assumption that no knob turns.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fixed {
    /// `A14`.
    pub number: String,
    /// What is assumed.
    pub text: String,
    /// Why nothing turns it on this machine.
    pub why: String,
}

/// The whole experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// Name of the machine.
    pub machine: String,
    /// The traces.
    pub traces: Vec<Traced>,
    /// The knobs; after [`Sensitivity::sorted`] by effect, the largest first.
    pub rows: Vec<Row>,
    /// Assumptions without a knob.
    pub fixed: Vec<Fixed>,
}

impl Sensitivity {
    /// Rows by effect; equal ones stay in the order of their numbers.
    #[must_use]
    pub fn sorted(mut self) -> Sensitivity {
        self.rows.sort_by(|a, b| b.effect().total_cmp(&a.effect()));
        self
    }

    /// What is missing because it was interrupted, if so.
    pub fn incomplete_note(&self) -> Option<String> {
        incomplete_note(&self.traces)
    }
}

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
    let outcome = Outcome::json;
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
