//! The numbers of a run, and the ranges that they must lie in.

use serde::Serialize;

use super::invalid::{Invalid, in_range};
use super::lambda::Rule;
use super::schedule::Schedule;

/// Largest weight of the display term, without unit.
const WEIGHT_MOST: f64 = 1e6;
/// Least weight of the display term.
const WEIGHT_LEAST: f64 = 1e-6;
/// Most iterations of one fine-tune.
const MOST_ITERATIONS: u32 = 10_000_000;

/// Which views decide whether a model passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Gate {
    /// Views held out of training for this.
    Validation,
    /// The test views, as the published code does: what it reports it has also selected on.
    Test,
}

/// How what there is above the target is spent on the display.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Dimming {
    /// By gains of the colour channels, when a model is trained.
    Gains,
    /// By a display term in the loss, whose λ follows this rule.
    Term(Rule),
}

impl Dimming {
    /// The rule of λ of a fine-tune that has a display term whatever this says.
    pub fn rule(self) -> Rule {
        match self {
            Dimming::Gains => Rule::Damped,
            Dimming::Term(rule) => rule,
        }
    }
}

/// The numbers of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settings {
    /// Iterations of a sample, at least 1.
    pub iterations: u32,
    /// Iterations of the first sample, relative to the others.
    pub first_effort: f64,
    /// Iterations of the dense model that is trained further without the gate views. Targets that
    /// are shares are shares of what it has then, so they do not follow
    /// [`Settings::iterations`]: the same share is the same quality, however long a search is.
    pub held_out_iterations: u32,
    /// Iterations of the final model, and of comparisons that are not given those of a search.
    pub final_iterations: u32,
    /// Iterations of the fine-tunes in the periphery, relative to those of the first level.
    pub level_effort: f64,
    /// Iterations between checks of the quality.
    pub interval: u32,
    /// The share of a fine-tune in which λ is adjusted; after it λ is fixed.
    pub adjust_share: f64,
    /// Weight of the display term at the start, without unit: the term of an image that needs the
    /// display power of the dense model. λ, in 1/W, is this over that power. The damped rule begins
    /// there with 3 dB to spare or more, and with less in proportion to the shift of colours that
    /// it pays for.
    pub display_weight: f64,
    /// The same for the levels of the periphery; HVSQ is a smaller number than L1.
    pub level_display_weight: f64,
    /// How what there is above the target is spent on the display.
    pub dimming: Dimming,
    /// The quality has settled when it is less than this above the target, decibels.
    pub epsilon_db: f64,
    /// Opacities are limited to this when Gaussians are pruned; 1 for no limit.
    pub opacity_cap: f32,
    /// Factor on all learning rates.
    pub rate_scale: f64,
    /// The learning rates at the end of a fine-tune, relative to its beginning; a cosine between.
    pub rate_end: f64,
    /// Seed of the order of views.
    pub seed: u64,
    /// Iterations between checkpoints. It changes no number.
    pub checkpoint_every: u32,
    /// Which views decide.
    pub gate: Gate,
}

impl Settings {
    /// What the program takes where it is not told otherwise.
    pub const DEFAULT: Settings = Settings {
        iterations: 1000,
        first_effort: 1.0,
        held_out_iterations: 1000,
        final_iterations: 2000,
        level_effort: 0.5,
        interval: 10,
        adjust_share: 0.9,
        display_weight: 0.05,
        level_display_weight: 0.005,
        dimming: Dimming::Gains,
        epsilon_db: 0.05,
        opacity_cap: 1.0,
        rate_scale: 1.0,
        rate_end: 0.1,
        seed: 1,
        checkpoint_every: 250,
        gate: Gate::Validation,
    };

    /// Checks every number.
    ///
    /// # Errors
    /// [`Invalid::Range`]: the first that is out of its range.
    pub fn check(&self) -> Result<(), Invalid> {
        let counts = [
            ("iterations", self.iterations),
            ("final_iterations", self.final_iterations),
            ("held_out_iterations", self.held_out_iterations),
            ("interval", self.interval),
            ("checkpoint_every", self.checkpoint_every),
        ];
        for (key, n) in counts {
            in_range(key, f64::from(n), 1.0, f64::from(MOST_ITERATIONS))?;
        }
        in_range("first_effort", self.first_effort, 0.1, 100.0)?;
        in_range("adjust_share", self.adjust_share, 0.01, 1.0)?;
        in_range("display_weight", self.display_weight, WEIGHT_LEAST, WEIGHT_MOST)?;
        in_range("rate_scale", self.rate_scale, 1e-6, 1e3)?;
        in_range("rate_end", self.rate_end, 0.0, 1.0)?;
        in_range("opacity_cap", f64::from(self.opacity_cap), 0.01, 1.0)?;
        in_range("epsilon_db", self.epsilon_db, 0.0, 100.0)?;
        in_range("level_effort", self.level_effort, 0.01, 100.0)?;
        in_range("level_display_weight", self.level_display_weight, WEIGHT_LEAST, WEIGHT_MOST)
    }

    /// How the samples of a level (0 for level 1) are chosen, and the iterations of one.
    pub fn budget(&self, schedule: &Schedule, level: u8) -> (Schedule, u32) {
        if level == 0 {
            return (schedule.clone(), self.iterations);
        }
        let (plan, share) = schedule.upper(self.level_effort);
        (plan, share_of(self.iterations, share))
    }

    /// Iterations of the final model of a level.
    pub(crate) fn final_budget(&self, level: u8) -> u32 {
        let share = if level == 0 { 1.0 } else { self.level_effort };
        share_of(self.final_iterations, share)
    }
}

/// A share of a number of iterations, at least 1.
pub(crate) fn share_of(iterations: u32, share: f64) -> u32 {
    ((f64::from(iterations) * share).round() as u32).max(1)
}
