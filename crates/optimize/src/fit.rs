//! Display and rendering power as functions of the pruning ratio ρ, and where their sum is least.
//!
//! All samples reach the target; display power counts as if none had quality to spare
//! ([`super::slack`]). With u = (ρ − ρmin) / (ρmax − ρmin) and powers
//! scaled to their extremes, both curves are Michaelis-Menten curves of the drop from the largest
//! power: `1 − (y − ymin) / (ymax − ymin) = V x / (K + x)`, x = 1 − u for the display and x = u for
//! rendering, V ≥ 0, K ≥ 0, least squares. Source: `powergs`.
//!
//! In place of K we search t = K / (1 + K), and in place of V the value at x = 1,
//! s = V / (1 + K): the curve is `s x / (t + (1 − t) x)`, a straight line at t = 1, where K and V
//! are infinite. s follows from t in closed form, so one bounded number is searched, and data that
//! are nearly straight are no special case.

mod curve;
mod optimum;
mod samples;

pub use curve::{Curve, Shape};
pub use optimum::{Optimum, OptimumPlace};
pub use samples::{SampleError, read_samples};

/// One model that reaches the target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Share of Gaussians that were pruned, 0 to 1.
    pub rho: f64,
    /// Display power, W.
    pub display_w: f64,
    /// Rendering power, W.
    pub render_w: f64,
}

impl Sample {
    /// Display and rendering power together, W.
    pub fn total_w(&self) -> f64 {
        self.display_w + self.render_w
    }
}

/// Samples that no curve can be fitted to.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Two numbers per curve need three places.
    #[error(
        "{distinct} different values of rho: a fit needs at least 3; take more samples at the \
         target quality"
    )]
    TooFew {
        /// Different values of rho.
        distinct: usize,
    },
    /// A value that cannot be.
    #[error(
        "sample {index} (rho {rho}, display {display_w} W, render {render_w} W): rho must be from \
         0 to 1, powers from 0 to 1e9 W; leave the sample out or measure it again"
    )]
    Value {
        /// Position of the sample, from 0.
        index: usize,
        /// Its ratio.
        rho: f64,
        /// Its display power.
        display_w: f64,
        /// Its rendering power.
        render_w: f64,
    },
}

/// More than any machine: keeps sums finite.
const WATTS_MAX: f64 = 1e9;

/// Both curves of a set of samples.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fit {
    /// The samples, by ascending ρ.
    pub samples: Vec<Sample>,
    /// Display power.
    pub display: Curve,
    /// Rendering power.
    pub render: Curve,
}

/// Fits both curves.
///
/// # Errors
/// Fewer than three different ρ, or values that cannot be.
pub fn fit(samples: &[Sample]) -> Result<Fit, FitError> {
    for (index, s) in samples.iter().enumerate() {
        let good = |w: f64| (0.0..=WATTS_MAX).contains(&w);
        if !(0.0..=1.0).contains(&s.rho) || !good(s.display_w) || !good(s.render_w) {
            let Sample { rho, display_w, render_w } = *s;
            return Err(FitError::Value { index, rho, display_w, render_w });
        }
    }
    let mut samples = samples.to_vec();
    samples.sort_by(|a, b| a.rho.total_cmp(&b.rho));
    let distinct = samples.chunk_by(|a, b| a.rho == b.rho).count();
    if distinct < 3 {
        return Err(FitError::TooFew { distinct });
    }
    let (low, high) = (samples[0].rho, samples[samples.len() - 1].rho);
    let u = |s: &Sample| (s.rho - low) / (high - low);
    let display: Vec<_> = samples.iter().map(|s| (1.0 - u(s), s.display_w)).collect();
    let render: Vec<_> = samples.iter().map(|s| (u(s), s.render_w)).collect();
    Ok(Fit { display: Curve::fit(&display), render: Curve::fit(&render), samples })
}

/// The ρ at which the sum of both curves is least.
pub fn optimum(fit: &Fit) -> Optimum {
    Optimum::of(fit)
}

impl Fit {
    /// Least ρ of the samples.
    pub fn rho_min(&self) -> f64 {
        self.samples[0].rho
    }

    /// Largest ρ of the samples.
    pub fn rho_max(&self) -> f64 {
        self.samples[self.samples.len() - 1].rho
    }

    /// Where ρ lies between the least and the largest, 0 to 1; the curves end there.
    fn place(&self, rho: f64) -> f64 {
        ((rho - self.rho_min()) / (self.rho_max() - self.rho_min())).clamp(0.0, 1.0)
    }

    /// The fitted display power at ρ, W; beyond the samples that at the nearest one.
    pub fn display_w(&self, rho: f64) -> f64 {
        self.display.at(1.0 - self.place(rho))
    }

    /// The fitted rendering power at ρ, W; beyond the samples that at the nearest one.
    pub fn render_w(&self, rho: f64) -> f64 {
        self.render.at(self.place(rho))
    }

    /// The fitted total, W.
    pub fn total_w(&self, rho: f64) -> f64 {
        self.display_w(rho) + self.render_w(rho)
    }

    /// The sample with the least total power, the first one if several have it.
    pub(crate) fn best_sample(&self) -> &Sample {
        let first = &self.samples[0];
        self.samples.iter().fold(first, |a, b| if b.total_w() < a.total_w() { b } else { a })
    }

    /// What a reader of the fit should know, in sentences.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (name, curve) in [("display", &self.display), ("render", &self.render)] {
            notes.extend(curve.note().map(|note| format!("{name} power: {note}")));
        }
        notes.extend(optimum(self).note());
        notes
    }
}
