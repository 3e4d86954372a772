//! Where the sum of both curves is least, in closed form.
//!
//! Display power falls with x = 1 − u and rendering power with x = u, both convex, so the sum has
//! one minimum. With a² and b² the numerators of the two slopes and t, r the bends of display and
//! rendering, `a / (1 − (1 − t) u) = b / (r + (1 − r) u)` gives
//! `u = (b − a r) / (a (1 − r) + b (1 − t))`, clamped to 0..1. In terms of V and K that is
//! `(√B (1 + Kd) − √A Kr) / (√A + √B)`; the form with bends holds for straight lines too.

use std::cmp::Ordering;

use serde::{Deserialize, Serialize};

use super::Fit;

/// Where the optimum lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OptimumPlace {
    /// Between the samples.
    Interior,
    /// At the least ρ: pruning does not pay.
    LeastPruned,
    /// At the largest ρ: more pruning might pay still.
    MostPruned,
    /// The fitted total is the same everywhere.
    Anywhere,
}

impl OptimumPlace {
    /// Its name in outputs.
    pub fn name(self) -> &'static str {
        match self {
            OptimumPlace::Interior => "interior",
            OptimumPlace::LeastPruned => "least_pruned",
            OptimumPlace::MostPruned => "most_pruned",
            OptimumPlace::Anywhere => "anywhere",
        }
    }
}

/// The minimum of the fitted total.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Optimum {
    /// ρ of the minimum.
    pub rho: f64,
    /// Fitted display power there, W.
    pub display_w: f64,
    /// Fitted rendering power there, W.
    pub render_w: f64,
    /// Where it lies.
    pub place: OptimumPlace,
    /// ρ of the sample with the least total.
    pub best_sample_rho: f64,
    /// The total of that sample, W.
    pub best_sample_w: f64,
}

/// An optimum this far from the best sample is not believed.
const NEAR: f64 = 0.2;

impl Optimum {
    pub(super) fn of(fit: &Fit) -> Optimum {
        let (a, b) = (fit.display.root_slope(), fit.render.root_slope());
        let (t, r) = (fit.display.bend, fit.render.bend);
        let best = fit.best_sample();
        let (above, below) = (b - a * r, a * (1.0 - r) + b * (1.0 - t));
        let (rho, place) = match above.total_cmp(&0.0) {
            // Both lines straight and equally steep, or both flat.
            Ordering::Equal if below == 0.0 => (best.rho, OptimumPlace::Anywhere),
            Ordering::Greater if above < below => {
                let u = above / below;
                (fit.rho_min() + u * (fit.rho_max() - fit.rho_min()), OptimumPlace::Interior)
            }
            Ordering::Greater => (fit.rho_max(), OptimumPlace::MostPruned),
            Ordering::Less | Ordering::Equal => (fit.rho_min(), OptimumPlace::LeastPruned),
        };
        Optimum {
            rho,
            display_w: fit.display_w(rho),
            render_w: fit.render_w(rho),
            place,
            best_sample_rho: best.rho,
            best_sample_w: best.total_w(),
        }
    }

    /// Fitted total, W.
    pub fn total_w(&self) -> f64 {
        self.display_w + self.render_w
    }

    /// Whether the best sample is near: less than 0.2 away. The fit is not believed otherwise.
    pub fn is_trusted(&self) -> bool {
        (self.rho - self.best_sample_rho).abs() < NEAR
    }

    /// The ρ to prune to: the optimum if it is trusted, else that of the best sample.
    pub fn chosen_rho(&self) -> f64 {
        if self.is_trusted() { self.rho } else { self.best_sample_rho }
    }

    /// What a reader should know.
    pub(super) fn note(&self) -> Option<String> {
        let far = format!(
            "the fitted optimum is {:.2} away from the best sample: prune to that sample's rho \
             {:.3}, or take more samples between",
            (self.rho - self.best_sample_rho).abs(),
            self.best_sample_rho
        );
        match self.place {
            _ if !self.is_trusted() => Some(far),
            OptimumPlace::MostPruned => {
                Some("the optimum is the largest rho: samples beyond it may be better".into())
            }
            OptimumPlace::Anywhere => Some("the fitted total is the same everywhere".into()),
            OptimumPlace::LeastPruned | OptimumPlace::Interior => None,
        }
    }
}
