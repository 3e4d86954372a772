//! The catalogue of statistics: every number that a report shows, its name, unit and definition.
//!
//! Names are dotted and snake_case and end in their unit. They are the same in JSON (nested by the
//! dots), CSV headers, charts, `explain` and `docs/results.md`, because all of them are written
//! from this list. A statistic that a model does not measure is `None`: null in JSON, an empty cell
//! in CSV, never zero.

mod aggregate;
mod entries;
mod key;
mod record;

pub use crate::stage::Value;
pub use aggregate::Aggregate;
pub use key::Key;
pub use record::{Record, UnitPart};

use std::sync::LazyLock;

use super::FrameReport;
use crate::flow;

/// Whether a statistic is a count or a measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Integers: [`Value::Count`].
    Count,
    /// Floating point: [`Value::Real`].
    Real,
}

/// How much a frame counts in the mean over the frames of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// As much as every other.
    Frame,
    /// The time for which it is shown: the longer of its own time and the period of the display.
    /// A mean power is then energy over time.
    Displayed,
    /// Its own time.
    Running,
}

impl Weight {
    /// The weight of `frame` on a display at `fps` frames per second: positive, 1 for all frames
    /// that meet the display rate unless the weight is `Running`.
    pub fn of(self, frame: &FrameReport, fps: f64) -> f64 {
        match self {
            Weight::Frame => 1.0,
            Weight::Displayed => fps / frame.displayed_fps(fps),
            Weight::Running => frame.frame_time_s().filter(|&s| s > 0.0).unwrap_or(1.0),
        }
    }
}

type Read = Box<dyn Fn(&FrameReport, f64) -> Option<Value> + Send + Sync>;

/// One statistic of one frame.
pub struct Statistic {
    /// Dotted path, as in JSON and CSV: `power_w.total`.
    pub name: String,
    /// Unit, `1` for plain counts and ratios.
    pub unit: &'static str,
    /// What it says, in one or two sentences.
    pub definition: String,
    /// Count or measure.
    pub kind: Kind,
    /// How frames count in its mean.
    pub weight: Weight,
    /// The dataflows whose machines may have it; empty where all may.
    pub flows: Vec<&'static str>,
    read: Read,
}

impl Statistic {
    /// The value for `frame`, with power at `display_fps` frames per second; `None` where the model
    /// or the trace does not have it.
    pub fn of(&self, frame: &FrameReport, display_fps: f64) -> Option<Value> {
        (self.read)(frame, display_fps)
    }
}

impl std::fmt::Debug for Statistic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} [{}]", self.name, self.unit)
    }
}

/// All statistics, in report order.
pub fn catalogue() -> &'static [Statistic] {
    static CATALOGUE: LazyLock<Vec<Statistic>> = LazyLock::new(entries::all);
    &CATALOGUE
}

/// The places in [`catalogue`] of what machines may have that have values of these: what is of
/// every dataflow, and of theirs. Without any values of units they are of the default dataflow.
pub fn shown(has: impl Fn(usize) -> bool) -> Vec<usize> {
    let with_units = catalogue().iter().enumerate();
    let with_units = with_units.filter(|(i, s)| s.name.starts_with("units.") && has(*i));
    let mut flows: Vec<&str> = with_units.flat_map(|(_, s)| s.flows.iter().copied()).collect();
    if flows.is_empty() {
        flows.push(flow::DEFAULT);
    }
    let is_shown = |s: &Statistic| s.flows.is_empty() || s.flows.iter().any(|f| flows.contains(f));
    (0..catalogue().len()).filter(|&i| is_shown(&catalogue()[i])).collect()
}

/// The statistic called `name`.
pub fn find(name: &str) -> Option<&'static Statistic> {
    catalogue().iter().find(|s| s.name == name)
}

/// The name inside a path of `--json`: `aggregate.power_w.total.p99` and `frames[3].power_w.total`
/// are `power_w.total`. Anything else is returned as it is.
pub fn name_in(path: &str) -> &str {
    if let Some(name) = path.strip_prefix("aggregate.") {
        let whole = name.rsplit_once('.').filter(|(_, part)| Aggregate::PARTS.contains(part));
        return whole.map_or(name, |(name, _)| name);
    }
    let frame = path.strip_prefix("frames[").and_then(|rest| rest.split_once("]."));
    frame.map_or(path, |(_, name)| name)
}

/// The values of all statistics of one frame, in the order of [`catalogue`].
pub fn values(frame: &FrameReport, display_fps: f64) -> Vec<Option<Value>> {
    catalogue().iter().map(|s| s.of(frame, display_fps)).collect()
}
