//! What quality that a model has to spare would buy of the display.
//!
//! Samples reach the target, but some are above it: those of the rendering end have no display
//! term, and short fine-tunes do not spend all. A shift of colours in proportion to λ saves
//! display power in proportion to it and adds to the error by its square. With the error as a
//! share of the one that the target allows, `e = 10^(-margin / 10)`, a model that had the error
//! `e0` without the shift has saved `k √(e − e0)` of its display power, and saves `k √(1 − e0)`
//! when all is spent. The unpruned sample gives k: it is the model that the search began with,
//! with its slack spent. Without a display term `e0` is `e`; with one it is not known, and at
//! least that of the model that the search began with.

use super::outcome::Outcome;
use super::target::Target;

/// Less of the error spent says nothing about the price.
const SPENT: f64 = 0.02;
/// No display gives more than this share.
const MOST: f64 = 0.9;

/// What slack buys.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlackPrice {
    /// The share of display power that all of the allowed error buys.
    k: f64,
    /// The error of the model that the search began with, as a share of the allowed one.
    intact: f64,
}

/// A model, as far as its slack counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spending {
    /// Distance from the target, decibels.
    pub margin_db: f64,
    /// Display power, watts.
    pub display_w: f64,
}

impl Spending {
    /// That of an outcome.
    pub(crate) fn of(outcome: &Outcome, target: Target) -> Spending {
        let margin_db = target.margin_db(outcome.gate.quality);
        Spending { margin_db, display_w: outcome.watts.display_w }
    }

    /// The error as a share of the allowed one.
    fn error(self) -> f64 {
        10f64.powf(-self.margin_db / 10.0)
    }
}

impl SlackPrice {
    /// The price that a model shows before and after it spent its slack; `None` where it spent next
    /// to nothing, or saved nothing.
    pub fn between(intact: Spending, spent: Spending) -> Option<SlackPrice> {
        let error = spent.error() - intact.error();
        let saved = 1.0 - spent.display_w / intact.display_w;
        let is_known = error > SPENT && saved > 0.0 && saved.is_finite();
        is_known.then(|| SlackPrice { k: saved / error.sqrt(), intact: intact.error() })
    }

    /// Display power of a model, watts, once its slack is spent. `has_term`: some of it is spent on
    /// the display already.
    pub fn display_w(self, model: Spending, has_term: bool) -> f64 {
        let error = model.error();
        let before = if has_term { self.intact.min(error) } else { error };
        let left = |error: f64| 1.0 - (self.k * (error - before).max(0.0).sqrt()).min(MOST);
        model.display_w * (left(1.0) / left(error)).min(1.0)
    }
}

/// Display power of a sample, watts, as it would be with its slack spent.
pub(crate) fn spent_w(sample: &Outcome, price: Option<(SlackPrice, Target)>) -> f64 {
    match price {
        // It has spent what it had.
        Some(_) if sample.gains.is_some() => sample.watts.display_w,
        Some((price, target)) => {
            price.display_w(Spending::of(sample, target), sample.lambda.is_some())
        }
        None => sample.watts.display_w,
    }
}
