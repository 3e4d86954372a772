//! What a model must be before any format can hold it.

use super::super::Gaussians;
use super::super::check::{has_direction, is_usable};
use super::{ExportError, Target};

/// The highest SH degree that is written.
const HIGHEST_DEGREE: u8 = 3;

/// Refuses models that no reader would give back whole.
pub(super) fn check(scene: &Gaussians, target: Target) -> Result<(), ExportError> {
    if scene.sh_degree > HIGHEST_DEGREE {
        return Err(ExportError::Degree { degree: scene.sh_degree });
    }
    let n = scene.len();
    for (list, found, expected) in [
        ("log_scales", scene.log_scales.len(), n),
        ("rotations", scene.rotations.len(), n),
        ("logit_opacities", scene.logit_opacities.len(), n),
        ("sh", scene.sh.len(), n * 3 * scene.sh_coefficients()),
    ] {
        if found != expected {
            return Err(ExportError::Lengths { list, found, expected });
        }
    }
    let (count, most) = (n as u64, target.most());
    if count == 0 {
        return Err(ExportError::Empty);
    }
    if count > most {
        return Err(ExportError::TooMany { count, most, format: target.name() });
    }
    if let Some(index) = (0..n).find(|&i| !is_usable(scene, i)) {
        return Err(ExportError::Unusable { index });
    }
    match scene.rotations.iter().position(|q| !has_direction(q)) {
        Some(index) => Err(ExportError::NoDirection { index }),
        None => Ok(()),
    }
}
