//! The check that turns decoded data into a valid model, and what every format may say of its kind.
//!
//! Files keep opacities as logits and scales as logarithms, and their ends are infinite there: they
//! become the nearest finite numbers with the same picture. Readers say what a file claims to be;
//! what follows from the numbers is found here.

use super::{Gaussians, SceneError, Warning};

/// Magnitudes beyond this cannot be squared in single precision.
const LARGEST: f32 = 1e15;
/// The largest natural logarithm of a scale: `e^40` squared is still finite.
const LARGEST_LOG_SCALE: f32 = 40.0;
/// The logit of an opacity that is 1 in single precision; its negative is that of one that no pixel
/// can see.
const OPAQUE: f32 = 20.0;
/// The scale that stands for none, world units.
const SMALLEST_SCALE: f32 = 1e-12;
/// Quaternions with a squared length below this have no direction.
const SHORTEST_SQUARED: f32 = 1e-30;

/// Drops Gaussians with unusable parameters, gives directionless quaternions the identity, and
/// says so in `warnings`. An error if nothing is left.
pub(super) fn check(
    mut scene: Gaussians,
    warnings: &mut Vec<Warning>,
) -> Result<Gaussians, SceneError> {
    settle_ends(&mut scene, warnings);
    let count = scene.len();
    let mut kept = 0;
    let mut first_dropped = None;
    for i in 0..count {
        if !is_usable(&scene, i) {
            first_dropped.get_or_insert(i as u64);
            continue;
        }
        if kept != i {
            move_down(&mut scene, i, kept);
        }
        kept += 1;
    }
    if kept == 0 {
        return Err(SceneError::NothingLeft { count: count as u64 });
    }
    truncate(&mut scene, kept);
    if let Some(first) = first_dropped {
        warnings.push(Warning::Dropped { count: (count - kept) as u64, first });
    }
    give_direction(&mut scene, warnings);
    if scene.antialiased {
        warnings.push(Warning::Antialiased);
    }
    if is_activated(&scene) {
        warnings.push(Warning::Activated);
    }
    Ok(scene)
}

/// Gives opacities of 0 and 1, and scales of 0, the finite numbers that stand for them.
fn settle_ends(scene: &mut Gaussians, warnings: &mut Vec<Warning>) {
    for logit in scene.logit_opacities.iter_mut().filter(|logit| logit.is_infinite()) {
        *logit = OPAQUE.copysign(*logit);
    }
    let mut count = 0;
    for scales in &mut scene.log_scales {
        let mut is_raised = false;
        for scale in scales.iter_mut().filter(|scale| **scale == f32::NEG_INFINITY) {
            *scale = SMALLEST_SCALE.ln();
            is_raised = true;
        }
        count += u64::from(is_raised);
    }
    if count > 0 {
        warnings.push(Warning::NonPositiveScales { count });
    }
}

/// Whether all numbers are what an exporter stores that forgot to undo the activations. As raw
/// parameters they would be of Gaussians that are all larger than the unit of the world and more
/// than half opaque.
fn is_activated(scene: &Gaussians) -> bool {
    let scales = scene.log_scales.as_flattened();
    scene.logit_opacities.iter().all(|o| (0.0..=1.0).contains(o))
        // Formats that round make zeros of small ones.
        && scales.iter().all(|s| *s >= 0.0)
        && scales.iter().any(|s| *s > 0.0)
}

/// Whether the parameters of Gaussian `i` are finite and can be squared.
pub(super) fn is_usable(scene: &Gaussians, i: usize) -> bool {
    // NaN compares as false, so that each test refuses it too.
    let sane = |v: &f32| v.abs() <= LARGEST;
    scene.means[i].iter().all(sane)
        && scene.log_scales[i].iter().all(|s| s.is_finite() && *s <= LARGEST_LOG_SCALE)
        && scene.rotations[i].iter().all(sane)
        && scene.logit_opacities[i].is_finite()
        && scene.sh_of(i).iter().all(sane)
}

fn move_down(scene: &mut Gaussians, from: usize, to: usize) {
    scene.means[to] = scene.means[from];
    scene.log_scales[to] = scene.log_scales[from];
    scene.rotations[to] = scene.rotations[from];
    scene.logit_opacities[to] = scene.logit_opacities[from];
    let n = 3 * scene.sh_coefficients();
    scene.sh.copy_within(from * n..(from + 1) * n, to * n);
}

fn truncate(scene: &mut Gaussians, len: usize) {
    scene.means.truncate(len);
    scene.log_scales.truncate(len);
    scene.rotations.truncate(len);
    scene.logit_opacities.truncate(len);
    scene.sh.truncate(len * 3 * scene.sh_coefficients());
}

/// Whether a quaternion is long enough to be a rotation.
pub(super) fn has_direction(q: &[f32; 4]) -> bool {
    q.iter().map(|c| c * c).sum::<f32>() >= SHORTEST_SQUARED
}

fn give_direction(scene: &mut Gaussians, warnings: &mut Vec<Warning>) {
    let mut count = 0;
    let mut first = 0;
    for (i, q) in scene.rotations.iter_mut().enumerate() {
        if !has_direction(q) {
            *q = [1.0, 0.0, 0.0, 0.0];
            if count == 0 {
                first = i as u64;
            }
            count += 1;
        }
    }
    if count > 0 {
        warnings.push(Warning::ZeroQuaternions { count, first });
    }
}
