//! What the samples of a search say: the fits, the optimum, the best model, and the power that is
//! predicted at the optimum. Fitted display power is that of a model which has spent its slack.

use super::fit::{Fit, FitError, Optimum, OptimumPlace, Sample, fit, optimum};
use super::outcome::Outcome;
use super::role::Role;
use super::schedule::APART;
use super::slack::{SlackPrice, Spending, spent_w};
use super::target::{Quality, Target};

/// Less is nothing pruned.
const UNPRUNED: f64 = 0.01;
/// A sample that takes so much more than the best one is no place for the minimum, whatever the fit
/// says.
const CONTRADICTED: f64 = 0.02;

/// A sample that missed the target.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
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
#[non_exhaustive]
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

/// A sample that the curves are fitted to.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FittedSample {
    /// Its job.
    pub name: String,
    /// Its powers; that of the display as it would be with its slack spent, where that is known.
    pub sample: Sample,
}

/// What the samples say.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Conclusion {
    /// Samples that ended on the target.
    pub passed: usize,
    /// Those that did not.
    pub missed: Vec<Missed>,
    /// What the curves are fitted to: samples that passed, or missed by little.
    pub fitted: Vec<FittedSample>,
    /// The curves, or why there are none.
    pub fit: Result<Fit, FitError>,
    /// Their minimum.
    pub optimum: Option<Optimum>,
    /// The ratio to realise; `None` if no sample passed.
    pub rho: Option<f64>,
    /// The job with the least total power of the samples and the realised optimum that pass: what
    /// the search itself found.
    pub best: Option<String>,
}

/// The price of slack at a place, by its least pruned sample that passed and has a display term:
/// where nothing is pruned, that is `intact`, the model that the search began with, with its slack
/// spent.
pub(crate) fn slack_price(
    done: &[Outcome],
    target: Target,
    intact: Option<Spending>,
) -> Option<SlackPrice> {
    let is_spent = |o: &&Outcome| {
        let is_dimmed = o.lambda.is_some() || o.gains.is_some();
        o.role == Role::Sample && o.passed && is_dimmed && o.rho < UNPRUNED
    };
    // The last one, because a retry takes the place of what it retries.
    let spent = done.iter().rfind(is_spent)?;
    SlackPrice::between(intact?, Spending::of(spent, target))
}

/// Evaluates the samples. Without a target there are none. `intact`: the model that the search
/// began with, where it was measured against this target.
pub fn conclude(done: &[Outcome], target: Option<Target>, intact: Option<Spending>) -> Conclusion {
    let samples: Vec<&Outcome> = done.iter().filter(|o| o.role == Role::Sample).collect();
    let by =
        |o: &Outcome| target.map_or(Quality::likeness(0.0, 0.0), |t| t.shortfall(o.gate.quality));
    let missed: Vec<Missed> = samples
        .iter()
        .filter(|o| !o.passed)
        .map(|o| Missed { name: o.name.clone(), rho: o.rho, by: by(o) })
        .collect();
    let price = target.and_then(|t| slack_price(done, t, intact));
    let fitted = fitted_samples(&samples, target, price);
    let fit = fit(&fitted.iter().map(|f| f.sample).collect::<Vec<Sample>>());
    let optimum = fit.as_ref().ok().map(optimum);
    let passing = || samples.iter().copied().filter(|o| o.passed);
    let least = |a: &&Outcome, b: &&Outcome| a.watts.total_w().total_cmp(&b.watts.total_w());
    let best_sample = passing().min_by(least);
    // A fit that used near misses may end beyond the highest ratio that passed. Its minimum is
    // tried there only if it lies between samples.
    let reach = passing().map(|o| o.rho).reduce(f64::max);
    let rho = best_sample.map(|best| {
        let chosen = optimum.map_or(best.rho, |o| o.chosen_rho());
        let is_inside = optimum.is_some_and(|o| o.place == OptimumPlace::Interior);
        let chosen = if is_inside { chosen } else { chosen.min(reach.unwrap_or(chosen)) };
        // Where a sample already says that it is no minimum, that lies between it and the best.
        let contradicts = |s: &&Sample| {
            (s.rho - chosen).abs() < APART
                && (s.rho - best.rho).abs() >= APART
                && s.display_w + s.render_w > (1.0 + CONTRADICTED) * best.watts.total_w()
        };
        let known = fitted.iter().map(|f| &f.sample).find(contradicts);
        known.map_or(chosen, |s| (best.rho + s.rho) / 2.0)
    });
    let ours = |o: &&Outcome| matches!(o.role, Role::Sample | Role::Optimum) && o.passed;
    let best = done.iter().filter(ours).min_by(least).map(|o| o.name.clone());
    let passed = samples.len() - missed.len();
    Conclusion { passed, missed, fitted, fit, optimum, rho, best }
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
fn fitted_samples(
    samples: &[&Outcome],
    target: Option<Target>,
    price: Option<SlackPrice>,
) -> Vec<FittedSample> {
    let near = |o: &Outcome| target.is_some_and(|t| t.is_near(o.gate.quality));
    let usable = samples.iter().filter(|o| o.passed || near(o));
    let of = |o: &&Outcome| FittedSample {
        name: o.name.clone(),
        sample: Sample {
            rho: o.rho,
            display_w: spent_w(o, price.zip(target)),
            render_w: o.watts.render_w,
        },
    };
    usable.map(of).collect()
}
