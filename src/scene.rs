//! Trained 3DGS models and cameras, whatever file they came from.
//!
//! [`Gaussians`] holds *raw* parameters (log-scale, un-normalised quaternion, logit opacity), as
//! trained and as stored by the INRIA PLY layout. Activations happen where splats are projected.

pub mod camera;

pub use camera::{Camera, Split};

/// A trained model. All lists have one entry per Gaussian; position in the list is its index in
/// the scene, and so its address in DRAM.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gaussians {
    /// Centre, world units.
    pub means: Vec<[f32; 3]>,
    /// Natural logarithm of the standard deviation along each axis, world units.
    pub log_scales: Vec<[f32; 3]>,
    /// Quaternion (w, x, y, z), not necessarily normalised.
    pub rotations: Vec<[f32; 4]>,
    /// Opacity before the logistic function.
    pub logit_opacities: Vec<f32>,
    /// Degree of the spherical harmonics, 0 to 3.
    pub sh_degree: u8,
    /// SH coefficients, per Gaussian `[channel][coefficient]`: `3 * (sh_degree + 1)²` floats.
    pub sh: Vec<f32>,
}

impl Gaussians {
    /// Number of Gaussians.
    pub fn len(&self) -> usize {
        self.means.len()
    }

    /// Whether the model is empty.
    pub fn is_empty(&self) -> bool {
        self.means.is_empty()
    }

    /// SH coefficients per channel: `(sh_degree + 1)²`.
    pub fn sh_coefficients(&self) -> usize {
        (self.sh_degree as usize + 1).pow(2)
    }

    /// The SH coefficients of Gaussian `i`, `[channel][coefficient]`.
    pub fn sh_of(&self, i: usize) -> &[f32] {
        let n = 3 * self.sh_coefficients();
        &self.sh[i * n..(i + 1) * n]
    }
}
