//! The check that turns decoded data into a valid model, and what every format may say of its kind.
//!
//! Files keep opacities as logits and scales as logarithms, and their ends are infinite there: they
//! become the nearest finite numbers with the same picture. Readers say what a file claims to be;
//! what follows from the numbers is found here.

use super::{Gaussians, SceneError, Warning};

/// The largest share of numbers that are taken for mistakes where all others follow a rule.
const STRAYS: f64 = 0.05;
/// Fewer Gaussians than this may have any numbers.
const FEW: usize = 16;
/// The share of Gaussians that may be smaller than the steps of their positions.
const COARSE: f64 = 0.1;
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
    warnings.extend(activation(&scene));
    warnings.extend(coarse_positions(&scene));
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

/// Whether so few of some numbers break a rule that they do so by mistake, and the others decide.
pub(super) fn are_strays(breaking: usize, of: usize) -> bool {
    breaking as f64 <= STRAYS * of as f64
}

/// Whether a rule holds for the numbers, but for strays.
fn nearly_all(values: &[f32], rule: impl Fn(f32) -> bool) -> bool {
    are_strays(values.iter().filter(|value| !rule(**value)).count(), values.len())
}

/// What an exporter forgot to undo. As raw parameters its numbers would be of Gaussians that are
/// all about as large as the unit of the world and about half transparent. Trained models have a
/// fifth to two fifths of their logits between -1 and 1, and axes that differ by more than a factor
/// of e.
fn activation(scene: &Gaussians) -> Option<Warning> {
    let (opacities, scales) = (&scene.logit_opacities, scene.log_scales.as_flattened());
    // Formats that round make zeros of small scales.
    let are_sizes = nearly_all(scales, |s| s >= 0.0) && scales.iter().any(|s| *s > 0.0);
    if are_sizes && nearly_all(opacities, |o| (0.0..=1.0).contains(&o)) {
        return Some(Warning::Activated);
    }
    if scene.len() < FEW {
        return None;
    }
    // Before training all opacities are the same.
    let differ = opacities.iter().any(|o| *o != opacities[0]);
    if differ && nearly_all(opacities, |o| (-1.0..=1.0).contains(&o)) {
        return Some(Warning::ActivatedOpacities);
    }
    let are_small = are_sizes && nearly_all(scales, |s| s < 1.0);
    are_small.then_some(Warning::ActivatedScales)
}

/// Positions that single precision rounds by as much as Gaussians are large. A few Gaussians far
/// away, or of next to no size, are no fault of the coordinates.
fn coarse_positions(scene: &Gaussians) -> Option<Warning> {
    let mut steps: Vec<f64> = Vec::new();
    for (mean, scale) in scene.means.iter().zip(&scene.log_scales) {
        let step = step(mean.iter().fold(0.0, |most: f32, v| most.max(v.abs())));
        let longest = scale.iter().fold(f32::MIN, |most, s| most.max(*s));
        if 2.0 * step > f64::from(longest).exp() {
            steps.push(step);
        }
    }
    if steps.len() as f64 <= COARSE * scene.len() as f64 {
        return None;
    }
    let count = steps.len();
    let (_, step, _) = steps.select_nth_unstable_by(count / 2, f64::total_cmp);
    let step = *step;
    let origin = std::array::from_fn(|axis| {
        let mut values: Vec<f32> = scene.means.iter().map(|mean| mean[axis]).collect();
        let middle = values.len() / 2;
        let (_, median, _) = values.select_nth_unstable_by(middle, f32::total_cmp);
        f64::from(*median).round()
    });
    Some(Warning::CoarsePositions { count: count as u64, step, origin })
}

/// The distance of two neighbouring numbers of single precision of this size.
fn step(magnitude: f32) -> f64 {
    let exponent = f64::from(magnitude.max(f32::MIN_POSITIVE)).log2().floor();
    (exponent - f64::from(f32::MANTISSA_DIGITS - 1)).exp2()
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
