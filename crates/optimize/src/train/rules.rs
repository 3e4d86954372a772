//! The numbers of the published schedule.

use serde::Serialize;

use super::super::adam::Rates;
use super::super::invalid::{Invalid, in_range};

/// Iterations of the published schedule.
pub const PUBLISHED_ITERATIONS: u32 = 30_000;
/// Most iterations.
const MOST_ITERATIONS: u32 = 10_000_000;
/// Rates and thresholds are at most this.
const MOST_RATE: f64 = 1e3;
/// The rate of the constant coefficients of the spherical harmonics over that of the others.
const SH_REST: f64 = 20.0;

/// The rules of a training. Iterations count from 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrainRules {
    /// Iterations.
    pub iterations: u32,
    /// Seed of all that is drawn: points, orders of views, places of the halves of a Gaussian.
    pub seed: u64,
    /// Learning rate of the centres at the beginning, in extents of the cameras.
    pub position_rate: f64,
    /// The same at the end; it falls exponentially.
    pub position_rate_end: f64,
    /// Learning rate of the constant coefficients of the spherical harmonics; a twentieth for the
    /// others.
    pub sh_rate: f64,
    /// Learning rate of the logits of the opacities.
    pub opacity_rate: f64,
    /// Learning rate of the logarithms of the scales.
    pub scale_rate: f64,
    /// Learning rate of the quaternions.
    pub rotation_rate: f64,
    /// The degree of the spherical harmonics at the end, 0 to 3.
    pub sh_degree: u8,
    /// Iterations after which the degree rises by one.
    pub sh_every: u32,
    /// Gaussians are densified after this iteration,
    pub densify_from: u32,
    /// and before this one,
    pub densify_until: u32,
    /// each time that this number of iterations has passed,
    pub densify_every: u32,
    /// where the mean gradient by the centre in the picture is at least this: the loss by half
    /// widths of the picture.
    pub densify_slope: f64,
    /// Gaussians larger than this are split, smaller ones cloned; extents of the cameras.
    pub split_scale: f64,
    /// Gaussians of less opacity are pruned.
    pub prune_opacity: f64,
    /// Larger ones are pruned, once opacities were reset; extents of the cameras.
    pub prune_scale: f64,
    /// Those of a larger radius in some picture are pruned, once opacities were reset, pixels; 0
    /// for none. The published code has 20, and forgets the radii before it compares them.
    pub prune_radius: f64,
    /// Iterations after which opacities are reset to 0.01, as long as Gaussians are densified.
    pub reset_every: u32,
    /// Nothing is added that would make more Gaussians than this.
    pub max_points: u64,
}

impl TrainRules {
    /// The published rules for this number of iterations: where it is not
    /// [`PUBLISHED_ITERATIONS`], all intervals are scaled in proportion, to at least 1.
    pub fn published(iterations: u32) -> TrainRules {
        let share = f64::from(iterations) / f64::from(PUBLISHED_ITERATIONS);
        let scaled = |n: u32| ((f64::from(n) * share).round() as u32).max(1);
        TrainRules {
            iterations,
            seed: 0,
            position_rate: 1.6e-4,
            position_rate_end: 1.6e-6,
            sh_rate: 2.5e-3,
            opacity_rate: 0.05,
            scale_rate: 5e-3,
            rotation_rate: 1e-3,
            sh_degree: 3,
            sh_every: scaled(1000),
            densify_from: scaled(500),
            densify_until: scaled(15_000),
            densify_every: scaled(100),
            densify_slope: 2e-4,
            split_scale: 0.01,
            prune_opacity: 0.005,
            prune_scale: 0.1,
            prune_radius: 0.0,
            reset_every: scaled(3000),
            max_points: 5_000_000,
        }
    }

    /// Checks that every number lies in its range.
    ///
    /// # Errors
    /// [`Invalid::Range`]: the first that does not.
    pub fn check(&self) -> Result<(), Invalid> {
        let counts = [
            ("iterations", self.iterations),
            ("sh_every", self.sh_every),
            ("densify_every", self.densify_every),
            ("reset_every", self.reset_every),
        ];
        for (key, count) in counts {
            in_range(key, count.into(), 1.0, MOST_ITERATIONS.into())?;
        }
        in_range("sh_degree", self.sh_degree.into(), 0.0, 3.0)?;
        // Of 0 no logarithm is there to fall along.
        for (key, rate) in
            [("position_rate", self.position_rate), ("position_rate_end", self.position_rate_end)]
        {
            in_range(key, rate, 1e-12, MOST_RATE)?;
        }
        let reals = [
            ("sh_rate", self.sh_rate),
            ("opacity_rate", self.opacity_rate),
            ("scale_rate", self.scale_rate),
            ("rotation_rate", self.rotation_rate),
            ("densify_slope", self.densify_slope),
            ("split_scale", self.split_scale),
            ("prune_scale", self.prune_scale),
        ];
        for (key, real) in reals {
            in_range(key, real, 0.0, MOST_RATE)?;
        }
        in_range("prune_opacity", self.prune_opacity, 0.0, 0.1)?;
        in_range("prune_radius", self.prune_radius, 0.0, 1e6)?;
        in_range("max_points", self.max_points as f64, 1.0, 1e9)
    }

    /// The learning rates of an iteration, for cameras of this extent.
    pub fn rates(&self, iteration: u32, extent: f64) -> Rates {
        let t = (f64::from(iteration) / f64::from(self.iterations)).min(1.0);
        let (begin, end) = (self.position_rate.ln(), self.position_rate_end.ln());
        Rates {
            means: extent * (begin * (1.0 - t) + end * t).exp(),
            scales: self.scale_rate,
            rotations: self.rotation_rate,
            opacities: self.opacity_rate,
            sh_dc: self.sh_rate,
            sh_rest: self.sh_rate / SH_REST,
        }
    }

    /// The degree of the spherical harmonics in an iteration.
    pub fn degree(&self, iteration: u32) -> u8 {
        let risen = iteration / self.sh_every;
        u32::from(self.sh_degree).min(risen) as u8
    }

    /// Whether gradients are gathered in an iteration.
    pub fn observes(&self, iteration: u32) -> bool {
        iteration < self.densify_until
    }

    /// Whether Gaussians are densified in an iteration.
    pub fn densifies(&self, iteration: u32) -> bool {
        self.observes(iteration)
            && iteration > self.densify_from
            && iteration.is_multiple_of(self.densify_every)
    }

    /// Whether opacities are reset in an iteration; over white also when densifying begins, as
    /// published.
    pub fn resets(&self, iteration: u32, is_white: bool) -> bool {
        let is_first = is_white && iteration == self.densify_from;
        self.observes(iteration) && (is_first || iteration.is_multiple_of(self.reset_every))
    }
}
