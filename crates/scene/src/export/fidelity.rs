//! What a written model holds of the one that it was made of.

use serde::Serialize;

use super::super::Gaussians;
use super::super::convert::sigmoid;

/// How well each field of a model is held: the model against what was read back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fidelity {
    /// Coordinates, world units.
    pub position: Kept,
    /// Natural logarithms of the standard deviations.
    pub scale: Kept,
    /// Rotations: the angle between the two, degrees. Quaternions of another length or the other
    /// sign are the same rotation, but not held exactly.
    pub rotation: Kept,
    /// Opacities after the logistic function, 0 to 1.
    pub opacity: Kept,
    /// DC coefficients of the colours.
    pub colour_dc: Kept,
    /// The other SH coefficients; of degree 0 there are none, and nothing is lost.
    pub colour_rest: Kept,
}

/// How well a field is held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Kept {
    /// Whether every number is read back as it was, to the last bit.
    pub exact: bool,
    /// The largest error.
    pub largest: f64,
    /// The root of the mean squared error.
    pub rms: f64,
    /// Numbers beyond the range of the format, which became the end of it.
    pub clamped: u64,
}

/// Numbers that a writer moved to the end of a range.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Clamped {
    pub scale: u64,
    pub opacity: u64,
    pub colour_dc: u64,
    pub colour_rest: u64,
}

impl Fidelity {
    /// Compares `scene` with `held`, which has as many Gaussians and the same degree.
    pub(super) fn of(scene: &Gaussians, held: &Gaussians, clamped: &Clamped) -> Fidelity {
        let n = scene.sh_coefficients();
        let colours = || scene.sh.iter().zip(&held.sh).enumerate();
        let dc = colours().filter(|(i, _)| i % n == 0).map(|(_, pair)| apart(pair));
        let rest = colours().filter(|(i, _)| i % n != 0).map(|(_, pair)| apart(pair));
        let opacities = scene.logit_opacities.iter().zip(&held.logit_opacities);
        let opacities = opacities.map(|(a, b)| (a == b, (sigmoid(*a) - sigmoid(*b)).abs()));
        let rotations = scene.rotations.iter().zip(&held.rotations);
        let rotations = rotations.map(|(a, b)| (a == b, angle(a, b)));
        Fidelity {
            position: Kept::of(rows(&scene.means, &held.means), 0),
            scale: Kept::of(rows(&scene.log_scales, &held.log_scales), clamped.scale),
            rotation: Kept::of(rotations, 0),
            opacity: Kept::of(opacities, clamped.opacity),
            colour_dc: Kept::of(dc, clamped.colour_dc),
            colour_rest: Kept::of(rest, clamped.colour_rest),
        }
    }

    /// The fields by name, in the order of the model.
    pub fn named(&self) -> [(&'static str, &Kept); 6] {
        [
            ("position", &self.position),
            ("scale", &self.scale),
            ("rotation", &self.rotation),
            ("opacity", &self.opacity),
            ("colour_dc", &self.colour_dc),
            ("colour_rest", &self.colour_rest),
        ]
    }

    /// Whether every field is held exactly.
    pub fn is_exact(&self) -> bool {
        self.named().iter().all(|(_, kept)| kept.exact)
    }
}

impl Kept {
    /// From whether each number is the same, and how far it is off. The sum has the order of the
    /// model, so that it does not depend on threads.
    fn of(errors: impl Iterator<Item = (bool, f64)>, clamped: u64) -> Kept {
        let mut kept = Kept { exact: true, largest: 0.0, rms: 0.0, clamped };
        let mut count = 0_u64;
        for (same, error) in errors {
            kept.exact &= same;
            kept.largest = kept.largest.max(error);
            kept.rms += error * error;
            count += 1;
        }
        kept.rms = (kept.rms / count.max(1) as f64).sqrt();
        kept
    }
}

fn rows<'a>(a: &'a [[f32; 3]], b: &'a [[f32; 3]]) -> impl Iterator<Item = (bool, f64)> + 'a {
    a.as_flattened().iter().zip(b.as_flattened()).map(apart)
}

fn apart((a, b): (&f32, &f32)) -> (bool, f64) {
    (a == b, (f64::from(*a) - f64::from(*b)).abs())
}

/// The angle of the rotation from one to the other, degrees: four times the arcsine of half the
/// distance of the unit quaternions, which is exact for small angles, too.
fn angle(a: &[f32; 4], b: &[f32; 4]) -> f64 {
    let (a, b) = (unit(a), unit(b));
    let distance = |sign: f64| {
        let squares = a.iter().zip(&b).map(|(a, b)| (a - sign * b).powi(2));
        squares.sum::<f64>().sqrt()
    };
    4.0 * (0.5 * distance(1.0).min(distance(-1.0))).min(1.0).asin().to_degrees()
}

fn unit(q: &[f32; 4]) -> [f64; 4] {
    let q = q.map(f64::from);
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    q.map(|c| c / length)
}
