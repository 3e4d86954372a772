//! What the samples of an iso-quality curve say: the fits, the optimum, the best model, and the
//! power that is predicted at the optimum.

use super::fit::{Fit, FitError, Optimum, OptimumPlace, Sample, fit, optimum};
use super::outcome::Outcome;
use super::role::Role;
use super::target::{Quality, Target};

/// A sample that missed the target.
#[derive(Debug, Clone, PartialEq)]
pub struct Missed {
    /// Its job.
    pub name: String,
    /// Its ratio.
    pub rho: f64,
    /// By how much: decibels and SSIM, in the periphery HVSQ.
    pub by: Quality,
}

/// Power that the fit predicts at the ratio that is realised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// The ratio.
    pub rho: f64,
    /// Display power, watts.
    pub display_w: f64,
    /// Rendering power, watts.
    pub render_w: f64,
}

impl Predicted {
    /// Display and rendering power, watts.
    pub fn total_w(&self) -> f64 {
        self.display_w + self.render_w
    }
}

/// What the samples say.
#[derive(Debug, Clone, PartialEq)]
pub struct Conclusion {
    /// Samples that ended on the target.
    pub passed: usize,
    /// Those that did not.
    pub missed: Vec<Missed>,
    /// The curves, or why there are none.
    pub fit: Result<Fit, FitError>,
    /// Their minimum.
    pub optimum: Option<Optimum>,
    /// The ratio to realise; `None` if no sample passed.
    pub rho: Option<f64>,
    /// The job with the least total power of the samples and the final model that pass.
    pub best: Option<String>,
}

/// Evaluates the samples. Without a target there are none.
pub fn conclude(done: &[Outcome], target: Option<Target>) -> Conclusion {
    let samples: Vec<&Outcome> = done.iter().filter(|o| o.role == Role::Sample).collect();
    let by =
        |o: &Outcome| target.map_or(Quality::likeness(0.0, 0.0), |t| t.shortfall(o.gate.quality));
    let missed: Vec<Missed> = samples
        .iter()
        .filter(|o| !o.passed)
        .map(|o| Missed { name: o.name.clone(), rho: o.rho, by: by(o) })
        .collect();
    let fit = fit(&fitted_samples(&samples, target));
    let optimum = fit.as_ref().ok().map(optimum);
    let passing = || samples.iter().copied().filter(|o| o.passed);
    let least = |a: &&Outcome, b: &&Outcome| a.watts.total_w().total_cmp(&b.watts.total_w());
    let best_sample = passing().min_by(least).map(|o| o.rho);
    // A fit that used near misses may end beyond the highest ratio that passed. Its minimum is
    // tried there only if it lies between samples.
    let reach = passing().map(|o| o.rho).reduce(f64::max);
    let rho = best_sample.map(|best| {
        let chosen = optimum.map_or(best, |o| o.chosen_rho());
        let is_inside = optimum.is_some_and(|o| o.place == OptimumPlace::Interior);
        if is_inside { chosen } else { chosen.min(reach.unwrap_or(chosen)) }
    });
    let ours = |o: &&Outcome| matches!(o.role, Role::Sample | Role::Optimum) && o.passed;
    let best = done.iter().filter(ours).min_by(least).map(|o| o.name.clone());
    Conclusion { passed: samples.len() - missed.len(), missed, fit, optimum, rho, best }
}

impl Conclusion {
    /// Power that the fit predicts at the ratio that is realised.
    pub fn predicted(&self) -> Option<Predicted> {
        let (rho, fit) = (self.rho?, self.fit.as_ref().ok()?);
        let (display_w, render_w) = (fit.display_w(rho), fit.render_w(rho));
        Some(Predicted { rho, display_w, render_w })
    }
}

/// The samples that passed, and those that missed the target by less than 1 %.
fn fitted_samples(samples: &[&Outcome], target: Option<Target>) -> Vec<Sample> {
    let near = |o: &Outcome| target.is_some_and(|t| t.is_near(o.gate.quality));
    let usable = samples.iter().filter(|o| o.passed || near(o));
    let sample = |o: &&&Outcome| Sample {
        rho: o.rho,
        display_w: o.watts.display_w,
        render_w: o.watts.render_w,
    };
    let usable: Vec<&&Outcome> = usable.collect();
    usable.iter().map(sample).collect()
}
