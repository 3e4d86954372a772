//! How a file stores scales and opacities: as the standard has them, or as trainers do, which
//! drafts of the extension and some converters kept.

use super::super::check::are_strays;
use super::super::convert::log_scale;
use super::super::{Gaussians, Warning};

/// How far beyond 0 and 1 an opacity may lie that was rounded.
const MARGIN: f64 = 0.01;

/// The Gaussians of a primitive.
pub(super) struct GltfPart {
    /// Complete, but for what `stored` says.
    pub gaussians: Gaussians,
    /// Oddities.
    pub warnings: Vec<Warning>,
    /// Of attributes: the opacities as they are in the file, which are missing in `gaussians`;
    /// there the scales are as in the file, too.
    pub stored: Option<Vec<f64>>,
}

/// What the numbers of a file are. It is one of the whole file, because a primitive may have next
/// to no Gaussians, and of most of its numbers, because a few may be wrong.
#[derive(Debug, Clone, Copy)]
pub(super) struct GltfDialect {
    are_logarithms: bool,
    are_logits: bool,
}

impl GltfDialect {
    /// Of all primitives of a file. The standard has neither negative scales nor opacities beyond 0
    /// and 1; of logarithms and logits most are.
    pub(super) fn of<'p>(parts: impl Iterator<Item = &'p GltfPart>) -> GltfDialect {
        let (mut scales, mut negative, mut opacities, mut beyond) = (0, 0, 0, 0);
        for part in parts {
            let Some(stored) = &part.stored else { continue };
            let own = part.gaussians.log_scales.as_flattened();
            scales += own.len();
            negative += own.iter().filter(|scale| **scale < 0.0).count();
            opacities += stored.len();
            let is_beyond = |p: &&f64| p.is_finite() && !(-MARGIN..=1.0 + MARGIN).contains(*p);
            beyond += stored.iter().filter(is_beyond).count();
        }
        GltfDialect {
            are_logarithms: !are_strays(negative, scales),
            are_logits: !are_strays(beyond, opacities),
        }
    }

    /// What whoever reads the file should know.
    pub(super) fn warnings(self) -> impl Iterator<Item = Warning> {
        let scales = self.are_logarithms.then_some(Warning::LogarithmicScales);
        scales.into_iter().chain(self.are_logits.then_some(Warning::LogitOpacities))
    }

    /// Raw parameters.
    pub(super) fn decoded(self, part: GltfPart) -> Gaussians {
        let mut scene = part.gaussians;
        let Some(opacities) = part.stored else { return scene };
        if !self.are_logarithms {
            let scales = scene.log_scales.as_flattened_mut();
            scales.iter_mut().for_each(|scale| *scale = log_scale(*scale));
        }
        let raw = |p: f64| if self.are_logits { p as f32 } else { logit(p) };
        scene.logit_opacities = opacities.into_iter().map(raw).collect();
        scene
    }
}

/// The logit of an opacity; what lies just beyond 0 and 1 was rounded, anything else has none.
fn logit(p: f64) -> f32 {
    let near = p.clamp(0.0, 1.0);
    let p = if (p - near).abs() <= MARGIN { near } else { f64::NAN };
    (p / (1.0 - p)).ln() as f32
}
