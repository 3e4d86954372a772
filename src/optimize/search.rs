//! What the samples of an iso-quality curve say: fits, the optimum, which model is the best.

use super::plan::{Outcome, Role};
use super::target::{Quality, Target};

/// A sample that missed the target.
#[derive(Debug, Clone, PartialEq)]
pub struct Missed {
    /// Its job.
    pub name: String,
    /// Its ratio.
    pub rho: f64,
    /// By how much: decibels and SSIM.
    pub by: Quality,
}

/// What the samples say.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Conclusion {
    /// Samples that ended on the target.
    pub passed: usize,
    /// Those that did not.
    pub missed: Vec<Missed>,
    /// The ratio to realise.
    pub rho: Option<f64>,
    /// The job with the least total power of the samples and the final model that pass.
    pub best: Option<String>,
}

impl Conclusion {
    /// The ratio to realise; `None` if no sample passed.
    pub fn optimum(&self) -> Option<f64> {
        self.rho
    }
}

/// Draws the conclusion.
pub fn conclude(done: &[Outcome], target: Option<Target>) -> Conclusion {
    let Some(target) = target else { return Conclusion::default() };
    let samples: Vec<&Outcome> = done.iter().filter(|o| o.role == Role::Sample).collect();
    let missed = samples
        .iter()
        .filter(|o| !o.passed)
        .map(|o| Missed { name: o.name.clone(), rho: o.rho, by: target.shortfall(o.gate.quality) })
        .collect();
    let ours = |o: &&Outcome| matches!(o.role, Role::Sample | Role::Final) && o.passed;
    let least = |a: &&Outcome, b: &&Outcome| a.watts.total_w().total_cmp(&b.watts.total_w());
    let best = done.iter().filter(ours).min_by(least).map(|o| o.name.clone());
    let passing = samples.iter().copied().filter(|o| o.passed);
    let rho = passing.clone().min_by(|a, b| least(a, b)).map(|o| o.rho);
    Conclusion { passed: passing.count(), missed, rho, best }
}
