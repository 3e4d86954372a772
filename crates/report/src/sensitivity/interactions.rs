//! How keys of a machine act together: elementary effects after Morris, or Sobol indices.

mod bars;
mod formats;
mod scatter;
mod text;

pub use formats::{csv, designs_csv, json};
pub use text::{markdown, terminal};

use super::outcome::{Measure, Outcome, Traced, incomplete_note};
use powergs_chart::Chart;
use powergs_study::analysis::indices::Indices;
use powergs_study::analysis::morris::Effect;

/// A key that is turned with others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Factor {
    /// Kind of file that has it.
    pub file: &'static str,
    /// The key.
    pub key: String,
    /// What the machine has, as in a file.
    pub value: String,
    /// The values that it takes, each equally likely, as in a file.
    pub levels: Vec<String>,
}

impl Factor {
    /// `2..8` of numbers, all of names.
    pub fn range(&self) -> String {
        let is_number = self.levels.iter().all(|l| l.starts_with(|c: char| c.is_ascii_digit()));
        let (Some(first), Some(last)) = (self.levels.first(), self.levels.last()) else {
            return String::new();
        };
        match (first.split_once(' '), last.split_once(' ')) {
            _ if !is_number => self.levels.join(", "),
            (Some((low, unit)), Some((_, same))) if unit == same => format!("{low}..{last}"),
            _ => format!("{first}..{last}"),
        }
    }
}

/// What came out, by measure: one for each factor.
#[derive(Debug, Clone, PartialEq)]
pub enum Results {
    /// Elementary effects over the whole range of a key, percent of the machine as it is.
    Morris(Vec<(Measure, Vec<Effect>)>),
    /// Shares of the variance.
    Sobol(Vec<(Measure, Indices)>),
}

impl Results {
    /// The name of the method in every output.
    pub const fn name(&self) -> &'static str {
        match self {
            Results::Morris(_) => "morris",
            Results::Sobol(_) => "sobol",
        }
    }
}

/// A machine of the experiment: the level of every factor, and what it costs, means over the
/// traces.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Indices into the levels of the factors.
    pub levels: Vec<usize>,
    /// What it costs.
    pub outcome: Outcome,
}

/// The whole experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Interactions {
    /// Name of the machine.
    pub machine: String,
    /// Display rate of the powers, frames per second.
    pub display_fps: f64,
    /// The traces.
    pub traces: Vec<Traced>,
    /// The keys.
    pub factors: Vec<Factor>,
    /// Trajectories or rows that were asked for.
    pub asked: usize,
    /// Those that came out.
    pub samples: usize,
    /// Those that were drawn again because a point of them is no machine.
    pub redrawn: usize,
    /// Seed of the sample.
    pub seed: u64,
    /// The distinct machines.
    pub points: Vec<Point>,
    /// What came out.
    pub results: Results,
}

impl Interactions {
    /// What is missing because it was interrupted, if so.
    pub fn incomplete_note(&self) -> Option<String> {
        incomplete_note(&self.traces)
    }

    /// `20 trajectories, 241 machines, 4 trajectories drawn again (no machine), seed 1`.
    pub fn sample(&self) -> String {
        let what = match &self.results {
            Results::Morris(_) => "trajectories",
            Results::Sobol(_) => "rows",
        };
        let of = match self.samples == self.asked {
            true => String::new(),
            false => format!(" of {}", self.asked),
        };
        let (samples, machines) = (self.samples, self.points.len());
        let again = match self.redrawn {
            0 => String::new(),
            n => format!(", {n} drawn again (no machine)"),
        };
        format!("{samples}{of} {what}, {machines} machines{again}, seed {}", self.seed)
    }

    /// Places of the factors by what they do on any measure, the largest first.
    pub fn order(&self) -> Vec<usize> {
        let size = |i: usize| match &self.results {
            Results::Morris(all) => all.iter().map(|(_, e)| e[i].mu_star).fold(0.0, f64::max),
            Results::Sobol(all) => {
                all.iter().map(|(_, e)| e.each[i].total.value).fold(0.0, f64::max)
            }
        };
        let mut order: Vec<usize> = (0..self.factors.len()).collect();
        order.sort_by(|&a, &b| size(b).total_cmp(&size(a)));
        order
    }
}

/// The charts: a scatter for each measure after Morris, bars for Sobol indices.
pub fn charts(all: &Interactions) -> Vec<Chart> {
    match &all.results {
        Results::Morris(found) => scatter::charts(all, found),
        Results::Sobol(found) => bars::chart(all, found).into_iter().collect(),
    }
}

/// The line under a title.
fn subtitle(all: &Interactions) -> String {
    let note = all.incomplete_note().map_or(String::new(), |note| format!("{note}. "));
    let names: Vec<&str> = all.traces.iter().map(|t| t.name.as_str()).collect();
    let (names, machine) = (
        crate::format::shortened(&names.join(", "), 34),
        crate::format::shortened(&all.machine, 20),
    );
    format!("{note}{names} on {machine}: {}", all.sample())
}
