//! The controller of λ, the weight of display power in the loss.
//!
//! Every `interval` iterations the quality is checked. With quality to spare λ grows by a factor,
//! else it shrinks; the largest factor S falls from 2 to 1 along a cosine while the controller
//! works, so that λ comes to rest. Then λ stays at the last value that passed (`powergs`, 4.4).
//!
//! The published code has three defects, mended here (`powergs`, 10): λ has a floor, so that one
//! failed fine-tune does not leave 0, which no factor can raise; a fine-tune that follows a failed
//! one begins at λ0 again; and it stops when the quality has settled just above the target, as the
//! paper says. [`Rule::Damped`] is ours: the published factor is S or 1/S whatever the distance,
//! and the quality follows λ with a delay of tens of iterations, so λ overshoots by a decade in a
//! short fine-tune. The damped rule looks ahead along the trend of the quality and takes a power
//! of S that shrinks with the distance from the target.

use serde::{Deserialize, Serialize};

use super::target::{Quality, Target};

/// λ never falls below this, 1/W.
pub const FLOOR: f64 = 1e-6;
/// λ never rises above this, 1/W: far below it all colours are black.
const CEILING: f64 = 1e6;
/// The largest factor.
const STEP: f64 = 2.0;
/// Checks in a row that must be settled.
const SETTLED_CHECKS: u32 = 3;
/// The damped rule takes a full step from this distance on, decibels.
const FULL_STEP_DB: f64 = 4.0;
/// The damped rule aims so far above the target, as a share of epsilon: a λ that came to the target
/// itself from below would never have passed.
const AIM: f64 = 0.5;
/// How many checks the damped rule looks ahead.
const AHEAD: f64 = 2.0;

/// How large a step is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Rule {
    /// S or 1/S.
    Published,
    /// Less near the target, with an eye on the trend.
    Damped,
}

/// What the controller is told once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// How large a step is.
    pub rule: Rule,
    /// λ at the first check, 1/W.
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
    /// The quality has been just above the target for some checks in a row.
    Settled,
}

/// Where a controller is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ControllerState {
    /// λ for the next iteration, 1/W.
    pub lambda: f64,
    /// λ at the last check that passed.
    pub passing: Option<f64>,
    /// Distance from the target at the last check, decibels.
    pub margin_db: Option<f64>,
    /// Settled checks in a row.
    pub settled_checks: u32,
}

/// The controller of one fine-tune.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    control: Control,
    state: ControllerState,
}

/// The factor S at an iteration: 2 at 0, 1 at `adjust`, a half cosine between.
pub fn factor(iteration: u32, adjust: u32) -> f64 {
    let share = f64::from(iteration) / f64::from(adjust.max(1));
    1.0 + (STEP - 1.0) * ((std::f64::consts::PI * share).cos() + 1.0) / 2.0
}

impl Controller {
    /// A controller at its first λ.
    pub fn new(control: Control) -> Controller {
        let lambda = control.start.clamp(FLOOR, CEILING);
        let state = ControllerState { lambda, passing: None, margin_db: None, settled_checks: 0 };
        Controller { control, state }
    }

    /// A controller that goes on.
    pub(crate) fn restored(control: Control, state: ControllerState) -> Controller {
        Controller { control, state }
    }

    /// Where it is, for checkpoints.
    pub fn state(&self) -> ControllerState {
        self.state
    }

    /// λ now, 1/W.
    pub fn lambda(&self) -> f64 {
        self.state.lambda
    }

    /// λ at the last check that passed.
    pub fn passing(&self) -> Option<f64> {
        self.state.passing
    }

    /// Whether the quality is to be checked after this iteration, counted from 0.
    pub fn is_due(&self, iteration: u32) -> bool {
        iteration.is_multiple_of(self.control.interval.max(1))
    }

    /// Takes in the quality after `iteration` and sets the next λ.
    pub fn observe(&mut self, iteration: u32, quality: Quality, target: &Target) -> Verdict {
        let state = &mut self.state;
        if iteration >= self.control.adjust {
            // Nothing passed: with almost no weight the quality may still reach the target.
            state.lambda = state.passing.unwrap_or(FLOOR);
            return Verdict::Continue;
        }
        let margin = target.margin_db(quality);
        let full = factor(iteration, self.control.adjust);
        let passes = target.passes(quality);
        if passes {
            state.passing = Some(state.lambda);
        }
        let power = match self.control.rule {
            Rule::Published if passes => 1.0,
            Rule::Published => -1.0,
            Rule::Damped => {
                let trend = state.margin_db.map_or(0.0, |last| margin - last);
                let aim = AIM * self.control.epsilon_db;
                let ahead = margin - aim + AHEAD * trend;
                if ahead.is_nan() { 1.0 } else { (ahead / FULL_STEP_DB).clamp(-1.0, 1.0) }
            }
        };
        state.lambda = (state.lambda * full.powf(power)).clamp(FLOOR, CEILING);
        state.margin_db = Some(margin);
        let settled = target.is_settled(quality, self.control.epsilon_db);
        state.settled_checks = if settled { state.settled_checks + 1 } else { 0 };
        if state.settled_checks >= SETTLED_CHECKS { Verdict::Settled } else { Verdict::Continue }
    }
}
