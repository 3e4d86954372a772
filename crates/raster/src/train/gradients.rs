//! Gradients in the layout of the parameters.

use powergs_scene::Gaussians;

/// The gradient of a loss by the raw parameters of [`Gaussians`], in the same layout: one entry per
/// Gaussian and list. Units are those of the loss per unit of the parameter.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gradients {
    /// By the centre, 1/world units.
    pub means: Vec<[f32; 3]>,
    /// By the logarithm of the standard deviations.
    pub log_scales: Vec<[f32; 3]>,
    /// By the quaternion (w, x, y, z) before it is normalised.
    pub rotations: Vec<[f32; 4]>,
    /// By the opacity before the logistic function.
    pub logit_opacities: Vec<f32>,
    /// By the SH coefficients, per Gaussian `[channel][coefficient]`.
    pub sh: Vec<f32>,
}

impl Gradients {
    /// No gradients yet; [`Tape::backward`](super::Tape::backward) gives them their size.
    pub fn new() -> Gradients {
        Gradients::default()
    }

    /// The five lists as plain numbers, in the order means, log-scales, rotations, opacities, SH.
    pub fn flat(&self) -> [&[f32]; 5] {
        [
            self.means.as_flattened(),
            self.log_scales.as_flattened(),
            self.rotations.as_flattened(),
            &self.logit_opacities,
            &self.sh,
        ]
    }

    /// Gives every list the length of the scene's; contents are arbitrary.
    pub(super) fn resize_like(&mut self, scene: &Gaussians) {
        let n = scene.len();
        self.means.resize(n, [0.0; 3]);
        self.log_scales.resize(n, [0.0; 3]);
        self.rotations.resize(n, [0.0; 4]);
        self.logit_opacities.resize(n, 0.0);
        self.sh.resize(scene.sh.len(), 0.0);
    }
}
