//! The controller of λ, the weight of display power in the loss.
//!
//! Every `interval` iterations the quality is checked. With quality to spare λ grows by a factor S,
//! else it shrinks by S; S falls from 2 to 1 along a cosine while the controller works, so that λ
//! comes to rest. Then λ stays at the last value that passed. Published rule with three mends
//! (`powergs`, sections 4.4 and 10): λ has a floor, so that one failed fine-tune does not leave 0,
//! which no factor can raise; a fine-tune that follows a failed one begins at λ0 again; and it
//! stops when the quality has settled just above the target, as the paper says.

use super::target::{Quality, Target};

/// λ never falls below this.
pub const FLOOR: f64 = 1e-6;
/// λ never rises above this: colours are black long before.
pub const CEILING: f64 = 1e6;
/// The largest factor.
const STEP: f64 = 2.0;
/// Checks in a row that must be settled.
const CALM: u32 = 3;

/// What the controller is told once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// λ at the first check.
    pub start: f64,
    /// Iterations between checks.
    pub interval: u32,
    /// Iterations in which λ is adjusted; then it stays.
    pub adjust: u32,
    /// The quality has settled when it is less than this above the target, decibels.
    pub epsilon_db: f64,
}

/// What a check decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Go on.
    Continue,
    /// The quality has been just above the target for some checks in a row, and λ moves little.
    Settled,
}

/// The controller of one fine-tune.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    control: Control,
    /// λ for the next iteration.
    lambda: f64,
    /// λ at the last check that passed.
    passing: Option<f64>,
    /// Settled checks in a row.
    calm: u32,
}

/// The factor at an iteration: 2 at 0, 1 at `adjust`, a half cosine between.
pub fn factor(iteration: u32, adjust: u32) -> f64 {
    let share = f64::from(iteration) / f64::from(adjust.max(1));
    1.0 + (STEP - 1.0) * ((std::f64::consts::PI * share).cos() + 1.0) / 2.0
}

impl Controller {
    /// A controller at its first λ.
    pub fn new(control: Control) -> Controller {
        let lambda = control.start.clamp(FLOOR, CEILING);
        Controller { control, lambda, passing: None, calm: 0 }
    }

    /// λ now.
    pub fn lambda(&self) -> f64 {
        self.lambda
    }

    /// λ at the last check that passed.
    pub fn passing(&self) -> Option<f64> {
        self.passing
    }

    /// Whether the quality is to be checked after this iteration, counted from 0.
    pub fn is_due(&self, iteration: u32) -> bool {
        iteration.is_multiple_of(self.control.interval.max(1))
    }

    /// Hears the quality after `iteration`.
    pub fn hear(&mut self, iteration: u32, quality: Quality, target: &Target) -> Verdict {
        if iteration >= self.control.adjust {
            self.rest();
            return Verdict::Continue;
        }
        let factor = factor(iteration, self.control.adjust);
        if target.passes(quality) {
            self.passing = Some(self.lambda);
            self.lambda *= factor;
        } else {
            self.lambda /= factor;
        }
        self.lambda = self.lambda.clamp(FLOOR, CEILING);
        let settled = target.is_settled(quality, self.control.epsilon_db);
        self.calm = if settled { self.calm + 1 } else { 0 };
        if self.calm >= CALM { Verdict::Settled } else { Verdict::Continue }
    }

    /// Ends the adjusting: λ becomes the last that passed, or the floor if none did.
    pub fn rest(&mut self) {
        self.lambda = self.passing.unwrap_or(FLOOR);
    }

    /// Where the next fine-tune of a chain begins: at the last λ that passed, else at `restart`.
    pub fn hand_on(&self, restart: f64) -> f64 {
        self.passing.unwrap_or(restart).max(FLOOR)
    }

    /// The state, for checkpoints: λ, the last that passed, settled checks.
    pub fn state(&self) -> (f64, Option<f64>, u32) {
        (self.lambda, self.passing, self.calm)
    }

    /// A controller in a state that [`Controller::state`] gave.
    pub fn restored(
        control: Control,
        (lambda, passing, calm): (f64, Option<f64>, u32),
    ) -> Controller {
        Controller { control, lambda, passing, calm }
    }
}
