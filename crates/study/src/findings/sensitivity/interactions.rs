//! How keys of a machine act together: elementary effects after Morris, or Sobol indices.

use super::measure::{Measure, Traced, incomplete_note};
use crate::analysis::indices::Indices;
use crate::analysis::morris::Effect;
use crate::findings::cost::Cost;

/// A key that is perturbed together with others.
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
pub struct InteractionPoint {
    /// Indices into the levels of the factors.
    pub levels: Vec<usize>,
    /// What it costs.
    pub outcome: Cost,
}

/// The whole experiment.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
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
    pub points: Vec<InteractionPoint>,
    /// What came out.
    pub results: Results,
}

impl Interactions {
    /// What is missing because it was interrupted, if so.
    pub fn incomplete_note(&self) -> Option<String> {
        incomplete_note(&self.traces)
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
