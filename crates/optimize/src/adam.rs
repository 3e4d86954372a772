//! Adam over the parameters of a model, with a learning rate per kind of parameter.
//!
//! `m = b1 m + (1 - b1) g`, `v = b2 v + (1 - b2) g²`, then
//! `p -= rate (m / (1 - b1ᵗ)) / (sqrt(v / (1 - b2ᵗ)) + eps)` with b1 = 0.9, b2 = 0.999,
//! eps = 1e-15: the published settings. A Gaussian steps where it is seen, and `t` counts its own
//! steps: what a view does not show has nothing to learn from it, and keeps values and moments.
//! Gradients are found sixteen Gaussians at a time and used at once; they are never in memory
//! together. Every parameter is worked on alone, so the result does not depend on the number of
//! threads.

mod rates;
mod step;

use super::prune::select;
use powergs_raster::train::Slopes;
use powergs_scene::Gaussians;

pub use rates::Rates;

/// A kind of parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// Centres.
    Means,
    /// Logarithms of the scales.
    Scales,
    /// Quaternions.
    Rotations,
    /// Logits of the opacities.
    Opacities,
    /// Spherical harmonics.
    Sh,
}

impl Group {
    /// All kinds, in the order in which they are stored and updated.
    pub const ALL: [Group; 5] =
        [Group::Means, Group::Scales, Group::Rotations, Group::Opacities, Group::Sh];

    /// The name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Group::Means => "mean",
            Group::Scales => "log-scale",
            Group::Rotations => "rotation",
            Group::Opacities => "opacity",
            Group::Sh => "SH coefficient",
        }
    }

    /// The values of this kind.
    pub fn of(self, scene: &Gaussians) -> &[f32] {
        match self {
            Group::Means => scene.means.as_flattened(),
            Group::Scales => scene.log_scales.as_flattened(),
            Group::Rotations => scene.rotations.as_flattened(),
            Group::Opacities => &scene.logit_opacities,
            Group::Sh => &scene.sh,
        }
    }

    /// The values of this kind, to be changed.
    pub(crate) fn of_mut(self, scene: &mut Gaussians) -> &mut [f32] {
        match self {
            Group::Means => scene.means.as_flattened_mut(),
            Group::Scales => scene.log_scales.as_flattened_mut(),
            Group::Rotations => scene.rotations.as_flattened_mut(),
            Group::Opacities => &mut scene.logit_opacities,
            Group::Sh => &mut scene.sh,
        }
    }

    /// Values per Gaussian.
    pub fn width(self, scene: &Gaussians) -> usize {
        match self {
            Group::Means | Group::Scales => 3,
            Group::Rotations => 4,
            Group::Opacities => 1,
            Group::Sh => 3 * scene.sh_coefficients(),
        }
    }
}

/// A gradient that must not be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BadGradient {
    /// The kind of parameter.
    pub group: Group,
    /// Index of the Gaussian.
    pub gaussian: usize,
    /// Position among the values of that kind of this Gaussian.
    pub position: usize,
}

/// The moments of all parameters, in the shape of the model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adam {
    /// First moments.
    pub first: Gaussians,
    /// Second moments.
    pub second: Gaussians,
    /// Steps that each Gaussian has done.
    pub steps: Vec<u32>,
}

impl Adam {
    /// Moments of zero for `scene`.
    pub fn new(scene: &Gaussians) -> Adam {
        let zeros = Gaussians {
            means: vec![[0.0; 3]; scene.len()],
            log_scales: vec![[0.0; 3]; scene.len()],
            rotations: vec![[0.0; 4]; scene.len()],
            logit_opacities: vec![0.0; scene.len()],
            sh_degree: scene.sh_degree,
            sh: vec![0.0; scene.sh.len()],
            antialiased: scene.antialiased,
        };
        Adam { first: zeros.clone(), second: zeros, steps: vec![0; scene.len()] }
    }

    /// Whether nothing has been stepped yet.
    pub fn is_cold(&self) -> bool {
        self.steps.iter().all(|n| *n == 0)
    }

    /// One step of the Gaussians that the view of `slopes` sees; the others are not touched.
    /// `read`: the model that was rendered, unless it was `scene` itself; gradients are its own.
    /// A parameter whose rate is 0 keeps its value, and where all kinds but the spherical harmonics
    /// have a rate of 0, these keep their moments too.
    ///
    /// # Errors
    /// The first gradient that is not finite (or too large to be squared), in the order of
    /// Gaussians; some of the others have done their step.
    pub fn step(
        &mut self,
        scene: &mut Gaussians,
        read: Option<&Gaussians>,
        slopes: &Slopes<'_>,
        rates: &Rates,
    ) -> Result<(), BadGradient> {
        step::step(self, scene, read, slopes, rates)
    }

    /// Keeps the moments of the Gaussians of `kept`, ascending indices.
    pub fn select(&mut self, kept: &[u32]) {
        select(&mut self.first, kept);
        select(&mut self.second, kept);
        for (to, &from) in kept.iter().enumerate() {
            self.steps[to] = self.steps[from as usize];
        }
        self.steps.truncate(kept.len());
    }

    /// Sets the moments of all opacities to zero.
    pub(crate) fn forget_opacities(&mut self) {
        self.first.logit_opacities.fill(0.0);
        self.second.logit_opacities.fill(0.0);
    }
}
