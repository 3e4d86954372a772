//! A trained 3DGS model in memory.

use super::ShDegree;

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
    /// Whether the model was trained with the 2D filter of Mip-Splatting: it is shown with
    /// opacities that are compensated for the low-pass of each view.
    pub antialiased: bool,
}

impl Gaussians {
    /// An empty model with room for `count` Gaussians.
    pub fn with_capacity(count: usize, sh_degree: u8) -> Self {
        Self {
            means: Vec::with_capacity(count),
            log_scales: Vec::with_capacity(count),
            rotations: Vec::with_capacity(count),
            logit_opacities: Vec::with_capacity(count),
            sh_degree,
            sh: Vec::with_capacity(count * 3 * (sh_degree as usize + 1).pow(2)),
            antialiased: false,
        }
    }

    /// Appends `other`. The lower SH degree is raised to the higher with zeros; how the model is
    /// shown stays that of `self`.
    pub fn append(&mut self, mut other: Self) {
        let degree = self.sh_degree.max(other.sh_degree);
        self.raise_degree(degree);
        other.raise_degree(degree);
        self.means.append(&mut other.means);
        self.log_scales.append(&mut other.log_scales);
        self.rotations.append(&mut other.rotations);
        self.logit_opacities.append(&mut other.logit_opacities);
        self.sh.append(&mut other.sh);
    }

    /// Raises the degree of the spherical harmonics, 0 to 3, with coefficients of zero. A model of
    /// that degree or a higher one stays as it is.
    pub fn raise_degree(&mut self, degree: u8) {
        if degree <= self.sh_degree {
            return;
        }
        let n = (degree as usize + 1).pow(2);
        let padded = |channel: &[f32]| {
            let zeros = std::iter::repeat_n(0.0, n - channel.len());
            channel.iter().copied().chain(zeros).collect::<Vec<_>>()
        };
        self.sh = self.sh.chunks_exact(self.sh_coefficients()).flat_map(padded).collect();
        self.sh_degree = degree;
    }

    /// Bytes that the parameters take in memory.
    pub fn bytes(&self) -> u64 {
        4 * (11 * self.len() as u64 + self.sh.len() as u64)
    }

    /// Number of Gaussians.
    pub fn len(&self) -> usize {
        self.means.len()
    }

    /// Whether the model is empty.
    pub fn is_empty(&self) -> bool {
        self.means.is_empty()
    }

    /// The degree of its spherical harmonics.
    ///
    /// # Panics
    /// When `sh_degree` is above 3: readers of files reduce it.
    pub fn degree(&self) -> ShDegree {
        ShDegree::new(self.sh_degree).expect("a scene has an SH degree of 0 to 3")
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
