//! The controller of λ, the weight of display power in the loss.
//!
//! Every `interval` iterations the quality is checked. With quality to spare λ grows by a factor,
//! else it shrinks; the largest factor S falls from 2 to 1 along a cosine while the controller
//! works, so that λ comes to rest. Then λ stays at the last value that passed (`powergs`, 4.4).
//!
//! The published code has three defects, mended here (`powergs`, 10): λ has a floor, so that one
//! failed fine-tune does not leave 0, which no factor can raise; a fine-tune that follows a failed
//! one begins at λ0 again; and it stops when the quality has settled just above the target, as the
//! paper says. [`LambdaRule::Damped`] is ours: the published factor is S or 1/S whatever the
//! distance, and the quality follows λ with a delay of tens of iterations, so λ overshoots by a
//! decade in a short fine-tune.
//!
//! The damped rule is a secant in log λ on a model of the slack. A colour shift in proportion to λ
//! adds to the error by its square, so a model at rest has `10 log10(1 + c λ²)` dB less than
//! without the term: whatever slack there is, 0.3 dB or 10, the quality at two λ gives the slope
//! there. The first check of a fine-tune has no λ behind it and gives the slack itself, from which
//! the first λ is estimated. Every step looks ahead along the trend, takes half of the
//! distance, and is never longer than a factor that falls from 1.6 up or 2.5 down to a few
//! per cent.

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
/// The damped rule aims so far above the target, as a share of epsilon: a λ that came to the target
/// itself from below would never have passed.
pub(crate) const AIM: f64 = 0.5;
/// How many checks the damped rule looks ahead.
const AHEAD: f64 = 2.0;
/// The share of the distance in log λ that a step of the damped rule covers.
const GAIN: f64 = 0.5;
/// The longest steps of the damped rule, up and down, at the beginning: what is spent too much is
/// slow to come back.
const LONGEST: (f64, f64) = (1.6, 2.5);
/// What is left of their logarithms at the end.
const SHORTEST: f64 = 0.05;
/// Slack that the damped rule counts with at least and at most, decibels: less is noise, and more
/// is that of a model that is compared with itself.
const SLACK_DB: (f64, f64) = (0.1, 12.0);
/// Weight of a new value in the mean of the trend.
const TREND: f64 = 0.5;

/// λ is at rest if its logarithm moves by less than this while the quality is settled.
const STILL: f64 = 0.05;

/// How large a step is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum LambdaRule {
    /// S or 1/S.
    Published,
    /// By the slack that there is, with an eye on the trend.
    Damped,
}

/// What the controller is told once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Control {
    /// How large a step is.
    pub rule: LambdaRule,
    /// λ at the first check, 1/W.
    pub start: f64,
    /// Whether `start` is only a scale, λ at a slack of 3 dB, from which the damped rule estimates
    /// the first λ; no if a fine-tune before it ended there.
    pub is_estimated: bool,
    /// Iterations between checks.
    pub interval: u32,
    /// Iterations in which λ is adjusted; then it stays.
    pub adjust: u32,
    /// The quality has settled when it is less than this above the target, decibels.
    pub epsilon_db: f64,
}

/// What a check decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LambdaVerdict {
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
    /// How the distance changes from check to check, decibels.
    pub trend_db: f64,
    /// The largest distance so far: the slack that there was, decibels.
    pub slack_db: f64,
    /// Settled checks in a row.
    pub settled_checks: u32,
    /// λ and the distance when the settled checks began.
    pub settled_at: (f64, f64),
}

/// The controller of one fine-tune.
#[derive(Debug, Clone, PartialEq)]
pub struct LambdaController {
    control: Control,
    state: ControllerState,
}

/// The factor S at an iteration: 2 at 0, 1 at `adjust`, a half cosine between.
pub fn factor(iteration: u32, adjust: u32) -> f64 {
    let share = f64::from(iteration) / f64::from(adjust.max(1));
    1.0 + (STEP - 1.0) * ((std::f64::consts::PI * share).cos() + 1.0) / 2.0
}

impl LambdaController {
    /// A controller at its first λ.
    pub fn new(control: Control) -> LambdaController {
        let lambda = control.start.clamp(FLOOR, CEILING);
        let state = ControllerState {
            lambda,
            passing: None,
            margin_db: None,
            trend_db: 0.0,
            slack_db: f64::NEG_INFINITY,
            settled_checks: 0,
            settled_at: (0.0, 0.0),
        };
        LambdaController { control, state }
    }

    /// A controller that goes on.
    pub(crate) fn restored(control: Control, state: ControllerState) -> LambdaController {
        LambdaController { control, state }
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
    pub fn observe(&mut self, iteration: u32, quality: Quality, target: &Target) -> LambdaVerdict {
        let state = &mut self.state;
        if iteration >= self.control.adjust {
            // Nothing passed: with almost no weight the quality may still reach the target.
            state.lambda = state.passing.unwrap_or(FLOOR);
            return LambdaVerdict::Continue;
        }
        let margin = target.margin_db(quality);
        let passes = target.passes(quality);
        if passes {
            state.passing = Some(state.lambda);
        }
        let full = factor(iteration, self.control.adjust);
        let by = match self.control.rule {
            LambdaRule::Published if passes => full,
            LambdaRule::Published => full.recip(),
            LambdaRule::Damped => self.damped(margin, (full - 1.0) / (STEP - 1.0)),
        };
        let state = &mut self.state;
        state.lambda = (state.lambda * by).clamp(FLOOR, CEILING);
        state.margin_db = Some(margin);
        if self.is_settled(quality, margin, target) {
            LambdaVerdict::Settled
        } else {
            LambdaVerdict::Continue
        }
    }

    /// Takes λ back by what a model that was chosen with it misses the target by, decibels, and
    /// rests there unless there is time left to adjust it.
    pub(crate) fn retreat(&mut self, short_db: f64) {
        let aim = AIM * self.control.epsilon_db;
        let state = &mut self.state;
        let used = 10f64.powf(state.slack_db.clamp(SLACK_DB.0, SLACK_DB.1) / 10.0) - 1.0;
        // The slope of 10 log10(1 + c λ²) along ln λ, where `used` is c λ².
        let slope = 20.0 * std::f64::consts::LOG10_E * used / (1.0 + used);
        let by = ((short_db + aim) / slope).min(LONGEST.1.ln());
        state.lambda = (state.passing.unwrap_or(state.lambda) * (-by).exp()).max(FLOOR);
        state.passing = Some(state.lambda);
        state.settled_checks = 0;
    }

    /// The factor on λ; `left` falls from 1 to 0 while the controller works.
    fn damped(&mut self, margin: f64, left: f64) -> f64 {
        let state = &mut self.state;
        let (least, most) = SLACK_DB;
        // The square of the shift that a slack pays for, in units of the error.
        let shift = |slack: f64| 10f64.powf(slack.clamp(least, most) / 10.0) - 1.0;
        // A look that has no number says nothing about λ.
        if margin.is_nan() {
            return 1.0;
        }
        let Some(last) = state.margin_db else {
            state.slack_db = margin;
            // With more to spare than 3 dB the model is too good for the square law to hold.
            return if self.control.is_estimated { shift(margin).sqrt().min(1.0) } else { 1.0 };
        };
        state.trend_db += TREND * (margin - last - state.trend_db);
        state.slack_db = state.slack_db.max(margin);
        let aim = AIM * self.control.epsilon_db;
        let off = margin + AHEAD * state.trend_db - aim;
        // Decibels that a factor of e on λ costs: at the target, or where too much is spent, there.
        let slack = state.slack_db.max(0.0);
        let used = shift(slack.max(slack - margin));
        let slope = 20.0 * std::f64::consts::LOG10_E * used / (1.0 + used);
        let left = SHORTEST + (1.0 - SHORTEST) * left;
        let (up, down) = (LONGEST.0.ln() * left, LONGEST.1.ln() * left);
        (GAIN * off / slope).clamp(-down, up).exp()
    }

    /// Whether the quality has been just above the target for some checks, and neither it nor λ
    /// went anywhere meanwhile.
    fn is_settled(&mut self, quality: Quality, margin: f64, target: &Target) -> bool {
        let (state, epsilon) = (&mut self.state, self.control.epsilon_db);
        if !target.is_settled(quality, epsilon) {
            state.settled_checks = 0;
            return false;
        }
        if state.settled_checks == 0 {
            state.settled_at = (state.lambda, margin);
        }
        state.settled_checks += 1;
        if state.settled_checks < SETTLED_CHECKS {
            return false;
        }
        let (lambda, first) = state.settled_at;
        let is_moving = match self.control.rule {
            // As published: three checks.
            LambdaRule::Published => false,
            LambdaRule::Damped => {
                (state.lambda / lambda).ln().abs() > STILL || (margin - first).abs() > epsilon / 2.0
            }
        };
        if is_moving {
            state.settled_checks = 1;
            state.settled_at = (state.lambda, margin);
        }
        !is_moving
    }
}
