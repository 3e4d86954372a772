//! What every assumption moves: the frame rate, the energy of a frame and the area of the chip,
//! with its knob set lower and higher. What every key moves is in [`keys`], and how keys act
//! together in [`interactions`].

pub mod interactions;
pub mod keys;
mod measure;

use super::cost::Cost;
pub use measure::{Change, Measure, Traced};

use measure::incomplete_note;

/// A knob at another value.
#[derive(Debug, Clone, PartialEq)]
pub struct KnobSetting {
    /// Value of the keys, as in a file.
    pub value: String,
    /// What it costs, by trace; or why that is no machine.
    pub outcomes: Result<Vec<Cost>, String>,
}

/// One knob of one assumption.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct KnobEffect {
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
    /// The machine that is perturbed, where it is not the one of the experiment.
    pub on: Option<String>,
    /// The machine with those, by trace.
    pub base: Vec<Cost>,
    /// At a lower value; `None` for a knob that has names, not numbers.
    pub low: Option<KnobSetting>,
    /// At a higher value, or another name.
    pub high: Option<KnobSetting>,
}

impl KnobEffect {
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

/// An assumption without a knob on this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fixed {
    /// `A14`.
    pub number: String,
    /// What is assumed.
    pub text: String,
    /// Why it has none.
    pub why: String,
}

/// The whole experiment.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Sensitivity {
    /// Name of the machine.
    pub machine: String,
    /// The traces.
    pub traces: Vec<Traced>,
    /// The knobs; after [`Sensitivity::sorted`] by effect, the largest first.
    pub rows: Vec<KnobEffect>,
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
