//! How the savings depend on the panel: display power from 0.38 to 2.66 times rendering power.
//!
//! A panel that draws s times as much makes the display term s times as large; the controller then
//! ends at λ / s and the same model. So the curve of one panel is that of all: its
//! display part scales. Nothing is trained for this study.

use super::fit::{Sample, fit, optimum};
use super::outcome::Outcome;
use super::role::{Baseline, Role};

/// The published range of the ratio, dense model.
pub const RATIOS: (f64, f64) = (0.38, 2.66);
/// Ratios that are evaluated, evenly spaced.
const COUNT: usize = 13;

/// Powers with one panel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RatioRow {
    /// Display power over rendering power of the dense model.
    pub ratio: f64,
    /// Factor on the display power of the run.
    pub scale: f64,
    /// The best ratio of pruned Gaussians.
    pub rho: f64,
    /// Power of our model, watts.
    pub ours_w: f64,
    /// Saved against `render-only`, share.
    pub over_render_only: Option<f64>,
    /// Saved against `display-only`, share.
    pub over_display_only: Option<f64>,
    /// Saved against the dense model, share.
    pub over_dense: f64,
}

/// The study; empty without enough samples on the target. Our model is the cheapest of the fitted
/// optimum and the samples.
pub fn ratios(done: &[Outcome]) -> Vec<RatioRow> {
    let Some(dense) = done.iter().find(|o| o.role == Role::Dense) else { return Vec::new() };
    let of = |b: Baseline| done.iter().find(|o| o.role == Role::Baseline(b));
    let (render_only, display_only) = (of(Baseline::RenderOnly), of(Baseline::DisplayOnly));
    let samples: Vec<Sample> = done
        .iter()
        .filter(|o| o.role == Role::Sample && o.passed)
        .map(|o| Sample { rho: o.rho, display_w: o.watts.display_w, render_w: o.watts.render_w })
        .collect();
    if samples.is_empty() || dense.watts.display_w <= 0.0 {
        return Vec::new();
    }
    let row = |i: usize| {
        let share = i as f64 / (COUNT - 1) as f64;
        let ratio = RATIOS.0 + (RATIOS.1 - RATIOS.0) * share;
        let scale = ratio * dense.watts.render_w / dense.watts.display_w;
        let (rho, ours_w) = cheapest(&samples, scale);
        let saved = |o: &Outcome| 1.0 - ours_w / (o.watts.render_w + scale * o.watts.display_w);
        RatioRow {
            ratio,
            scale,
            rho,
            ours_w,
            over_render_only: render_only.map(saved),
            over_display_only: display_only.map(saved),
            over_dense: saved(dense),
        }
    };
    (0..COUNT).map(row).collect()
}

/// Ratio and power of the cheapest model with display power scaled.
fn cheapest(samples: &[Sample], scale: f64) -> (f64, f64) {
    let scaled: Vec<Sample> =
        samples.iter().map(|s| Sample { display_w: scale * s.display_w, ..*s }).collect();
    let best = scaled.iter().map(|s| (s.rho, s.total_w()));
    let best = best.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0.0, f64::INFINITY));
    match fit(&scaled).map(|f| optimum(&f)) {
        Ok(o) if o.is_trusted() && o.total_w() < best.1 => (o.rho, o.total_w()),
        _ => best,
    }
}
