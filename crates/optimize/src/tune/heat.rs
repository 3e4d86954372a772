//! Learning rates by the damage that pruning did.
//!
//! A model that has lost a decibel needs steps several times as long as one that is intact, which
//! they would only shake. So the factor on the rates follows what is missing of the quality before
//! the damage, and cools down while the quality no longer rises.

use serde::{Deserialize, Serialize};

/// This much lost, in decibels, and the rates are at their highest.
const FULL_DB: f64 = 0.7;
/// A quality that rises by less from check to check is flat, decibels.
const FLAT_DB: f64 = 0.02;
/// What a check at which the quality is flat leaves of the heat.
const COOLING: f64 = 0.85;

/// The heat of a fine-tune.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Heat {
    /// The distance from the target that the intact model had, decibels.
    intact_db: f64,
    /// The distance at the last check, decibels.
    last_db: f64,
    /// What is left of the heat.
    left: f64,
    /// The factor on the learning rates now.
    pub factor: f64,
}

impl Heat {
    /// None before the first check. `intact_db` is the distance from the target, decibels, of the
    /// model that was not pruned yet, `margin_db` that of the model at hand.
    pub fn begin(intact_db: f64, margin_db: f64) -> Heat {
        Heat { intact_db, last_db: margin_db, left: 1.0, factor: 1.0 }
    }

    /// Gaussians went: what the next check finds lost is to be recovered.
    pub fn pruned(&mut self) {
        self.left = 1.0;
    }

    /// Its parameters are those of a model again that had recovered, at this distance from the
    /// target, decibels: no heat before the next prune.
    pub fn recovered(&mut self, margin_db: f64) {
        (self.last_db, self.left, self.factor) = (margin_db, 0.0, 1.0);
    }

    /// A check found this distance from the target, decibels. `is_dimming`: what is missing was
    /// spent on the display.
    pub fn observe(&mut self, margin_db: f64, most: f64, is_dimming: bool) {
        if is_dimming || margin_db - self.last_db < FLAT_DB {
            self.left *= COOLING;
        }
        self.last_db = margin_db;
        // Not a number where there is no target to be distant from.
        let lost = ((self.intact_db - margin_db) / FULL_DB).clamp(0.0, 1.0);
        let lost = if lost.is_nan() { 0.0 } else { lost };
        self.factor = 1.0 + (most - 1.0) * lost * self.left;
    }
}
