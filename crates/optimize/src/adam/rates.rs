//! Learning rates, one for each kind of parameter.

use super::Group;

/// Learning rates, per iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Centres, world units.
    pub means: f64,
    /// Logarithms of the scales.
    pub scales: f64,
    /// Quaternions.
    pub rotations: f64,
    /// Logits of the opacities.
    pub opacities: f64,
    /// Constant coefficients of the spherical harmonics.
    pub sh_dc: f64,
    /// The other coefficients.
    pub sh_rest: f64,
}

impl Rates {
    /// The published rates at the end of the published schedule, which is where fine-tuning is:
    /// `extent` is 1.1 times the largest distance of a training camera from their mean.
    pub fn published(extent: f64) -> Rates {
        Rates {
            means: 1.6e-6 * extent,
            scales: 0.005,
            rotations: 0.001,
            opacities: 0.05,
            sh_dc: 0.0025,
            sh_rest: 0.0025 / 20.0,
        }
    }

    /// Rates that move the moments and no parameter.
    pub(crate) fn still() -> Rates {
        // Not 0, at which moments would rest too; no parameter is so small that this moves it.
        let rate = 1e-36;
        Rates {
            means: rate,
            scales: rate,
            rotations: rate,
            opacities: rate,
            sh_dc: rate,
            sh_rest: rate,
        }
    }

    /// All rates times `factor`, those of the centres by its square: they rest at the end of the
    /// published schedule, and must move again where neighbours are gone.
    pub(crate) fn heated(self, factor: f64) -> Rates {
        Rates { means: self.means * factor * factor, ..self.scaled(factor) }
    }

    /// All rates times `factor`.
    pub fn scaled(self, factor: f64) -> Rates {
        Rates {
            means: self.means * factor,
            scales: self.scales * factor,
            rotations: self.rotations * factor,
            opacities: self.opacities * factor,
            sh_dc: self.sh_dc * factor,
            sh_rest: self.sh_rest * factor,
        }
    }

    /// Only colours: everything else stays where it is.
    pub fn colours_only(self) -> Rates {
        Rates { means: 0.0, scales: 0.0, rotations: 0.0, opacities: 0.0, ..self }
    }

    /// Only the constant coefficients and the opacities.
    pub(crate) fn colours_and_opacities(self) -> Rates {
        Rates { sh_rest: 0.0, opacities: self.opacities, ..self.colours_only() }
    }

    /// The rate of coefficient `k` of a channel, or of any value of another kind.
    pub(super) fn of(&self, group: Group, k: usize) -> f64 {
        match group {
            Group::Means => self.means,
            Group::Scales => self.scales,
            Group::Rotations => self.rotations,
            Group::Opacities => self.opacities,
            Group::Sh if k == 0 => self.sh_dc,
            Group::Sh => self.sh_rest,
        }
    }
}
