//! Learning rates by the damage that pruning did.
//!
//! A model that has lost a decibel needs steps several times as long as one that is intact, which
//! they would only shake. So the factor on the rates follows what a prune took of the quality, and
//! cools down while the quality no longer rises. What falls below the target without a prune is
//! lost by the steps themselves: then they get shorter.

use serde::{Deserialize, Serialize};

use super::Pace;

/// This much lost, in decibels, and the rates are at their highest.
const FULL_DB: f64 = 0.3;
/// A quality that rises by less from check to check is flat, decibels.
const FLAT_DB: f64 = 0.02;
/// What a check at which the quality is flat leaves of the heat.
const COOLING: f64 = 0.85;
/// A quality that falls by more from two checks to the next two, though nothing was pruned, is
/// shaken by the steps themselves, decibels. From check to check that much is the noise of looking
/// at a few views.
const SHAKEN_DB: f64 = 0.05;
/// So is one that falls by more from one check to the next, decibels.
const FALLEN_DB: f64 = 0.15;
/// What that leaves of the heat, now and after later prunes.
const SHAKEN: f64 = 0.5;
/// What a model bears more at a check at which it rose towards the target.
const BETTER: f64 = std::f64::consts::SQRT_2;
/// With so little of it left what shakes are the rates without heat: they are halved, too.
const LITTLE: f64 = 0.3;
/// What is left of the rates at least, where they shake.
const CALMEST: f64 = 0.125;

/// The heat of a fine-tune.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Heat {
    /// The distance from the target before Gaussians went, decibels: when it last was reached, or 0
    /// where it never was.
    before_db: f64,
    /// What of it the first check after that found lost, decibels.
    lost_db: f64,
    /// The distance at the last check, decibels.
    last_db: f64,
    /// The distances since Gaussians went or the heat was halved, the newest first, decibels.
    found_db: [f64; 4],
    /// How many checks these are, or more.
    found: u32,
    /// What is left of the heat.
    left: f64,
    /// The heat that the model bears: what is left of it after a prune.
    bearable: f64,
    /// What is left of the rates without heat.
    calm: f64,
    /// Whether Gaussians went since the last check.
    is_fresh: bool,
    /// The factor on the learning rates now.
    pub factor: f64,
}

impl Heat {
    /// None before the first check. `margin_db` is the distance from the target, decibels.
    pub fn begin(margin_db: f64, pace: Pace) -> Heat {
        Heat {
            before_db: margin_db.max(0.0),
            lost_db: 0.0,
            last_db: margin_db,
            found_db: [0.0; 4],
            found: 0,
            left: pace.rest.sqrt(),
            bearable: pace.rest.sqrt(),
            calm: 1.0,
            is_fresh: false,
            factor: pace.rest,
        }
    }

    /// Gaussians went: what the next check finds lost is to be recovered.
    pub fn pruned(&mut self) {
        if self.last_db >= 0.0 {
            self.before_db = self.last_db;
        }
        (self.left, self.is_fresh) = (self.bearable, true);
    }

    /// Its parameters are those of a model again that had recovered, at this distance from the
    /// target, decibels: no heat before the next prune.
    pub fn recovered(&mut self, margin_db: f64, pace: Pace) {
        (self.last_db, self.left, self.factor) = (margin_db, 0.0, self.calm * pace.rest);
        self.found = 0;
    }

    /// A check found this distance from the target, decibels. `is_dimming`: what is missing was
    /// spent on the display.
    pub fn observe(&mut self, margin_db: f64, pace: Pace, is_dimming: bool) {
        let rise_db = margin_db - self.last_db;
        let is_recovering = !is_dimming && !self.is_fresh && margin_db < 0.0;
        self.found = if self.is_fresh { 1 } else { self.found.saturating_add(1) };
        self.found_db.rotate_right(1);
        self.found_db[0] = margin_db;
        if is_recovering && rise_db >= FLAT_DB {
            self.calm = (self.calm * BETTER).min(1.0 / pace.rest);
            self.bearable = (self.bearable * BETTER).min(1.0);
            self.left = (self.left * BETTER).min(self.bearable);
        }
        if is_recovering && self.is_shaken(rise_db) {
            // The same checks are not held against the steps twice.
            self.found = 1;
            self.left *= SHAKEN;
            self.bearable *= SHAKEN;
            if self.left < LITTLE {
                self.calm = (self.calm * SHAKEN).max(CALMEST);
            }
        } else if is_dimming || rise_db < FLAT_DB {
            self.left *= COOLING;
        }
        // What steps lose is not to be met by longer ones.
        if self.is_fresh {
            self.lost_db = self.before_db - margin_db;
        }
        (self.last_db, self.is_fresh) = (margin_db, false);
        // Not a number where there is no target to be distant from.
        let lost = (self.lost_db / FULL_DB).clamp(0.0, 1.0);
        let lost = if lost.is_nan() { 0.0 } else { lost };
        if pace.heat <= 1.0 {
            return;
        }
        let rest = self.calm * pace.rest;
        self.factor = rest + (pace.heat - rest) * lost * self.left;
    }

    /// Whether the quality falls by more than checks differ that look at a few views each.
    fn is_shaken(&self, rise_db: f64) -> bool {
        let [a, b, c, d] = self.found_db;
        let falls = self.found >= 4 && 0.5 * (c + d) - 0.5 * (a + b) > SHAKEN_DB;
        falls || -rise_db > FALLEN_DB
    }
}
