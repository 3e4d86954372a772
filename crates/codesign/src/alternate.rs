//! The machine of the joint pair as the oracle of another fit of the ratio.
//!
//! Models that differ from the joint one in their ratio alone are samples of one quality: their
//! display power, and what the joint machine takes for them, are fitted as functions of the ratio
//! as in an optimisation, and the ratio at the minimum is the next model. It ends where the minimum
//! is at a model that is there.

use powergs_optimize::fit::{Sample, fit, optimum};

use super::compare::{Market, Pair};
use super::fit::Fitted;
use super::model::ModelPoint;

/// Two ratios that differ by less are the same.
const SAME: f64 = 0.01;
/// Ratios are rounded to this many parts of the whole, so that they have names.
const PARTS: f64 = 1000.0;

/// A ratio that was fitted, and what came of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Round {
    /// The ratio.
    pub rho: f64,
    /// The joint pair after it.
    pub pair: Pair,
    /// Its confirmed watts.
    pub watts: f64,
}

/// The model at the ratio where the joint machine takes least; `None` where there is one already,
/// or fewer than three ratios to fit.
pub fn next(models: &[Fitted], market: &Market<'_>, joint: Pair) -> Option<ModelPoint> {
    let of = &models.get(joint.0)?.point;
    let alike = |other: &ModelPoint| {
        !of.is_dense
            && !other.is_dense
            && (other.sh_degree, &other.format, other.formats)
                == (of.sh_degree, &of.format, of.formats)
    };
    let samples =
        models.iter().enumerate().filter(|(_, model)| alike(&model.point) && model.facts.passed);
    let samples = samples.filter_map(|(place, model)| {
        let price = market.price((place, joint.1))?;
        let render_w = price.total_w - price.display_w;
        Some(Sample { rho: model.point.rho, display_w: price.display_w, render_w })
    });
    let fitted = fit(&samples.collect::<Vec<_>>()).ok()?;
    let rho = (optimum(&fitted).chosen_rho() * PARTS).round() / PARTS;
    let is_there = |model: &Fitted| alike(&model.point) && (model.point.rho - rho).abs() < SAME;
    let is_new = !models.iter().any(is_there) && (0.0..1.0).contains(&rho);
    is_new.then(|| ModelPoint { rho, ..of.clone() })
}
