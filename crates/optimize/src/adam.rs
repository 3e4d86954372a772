//! Adam over the parameters of a model, with a learning rate per kind of parameter.
//!
//! `m = b1 m + (1 - b1) g`, `v = b2 v + (1 - b2) g²`, then
//! `p -= rate (m / (1 - b1ᵗ)) / (sqrt(v / (1 - b2ᵗ)) + eps)` with b1 = 0.9, b2 = 0.999,
//! eps = 1e-15: the published settings. Every parameter is worked on alone, so the result does not
//! depend on the number of threads.

use rayon::prelude::*;

use super::prune::select;
use powergs_scene::Gaussians;

/// Decay of the first moment.
const BETA_1: f64 = 0.9;
/// Decay of the second moment.
const BETA_2: f64 = 0.999;
/// Keeps the step of a parameter without gradient finite.
const EPSILON: f64 = 1e-15;
/// Parameters that one task works on; a multiple of all group widths.
const PART: usize = 48 * 1024;
/// Gradients beyond this would overflow when squared: as bad as infinite ones.
const LARGEST: f32 = 1e18;

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
    fn of(&self, group: Group, k: usize) -> f64 {
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
    /// Steps done.
    pub steps: u64,
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
        };
        Adam { first: zeros.clone(), second: zeros, steps: 0 }
    }

    /// One step against `gradients`, in the order of [`Group::ALL`] and as long as the lists of
    /// `scene`. A kind of parameter whose rate is 0 keeps its values and its moments.
    pub fn step(&mut self, scene: &mut Gaussians, gradients: [&[f32]; 5], rates: &Rates) {
        self.steps += 1;
        let t = self.steps.min(i32::MAX as u64) as i32;
        let corrections = [1.0 - BETA_1.powi(t), 1.0 - BETA_2.powi(t)];
        let coefficients = scene.sh_coefficients();
        for (group, slopes) in Group::ALL.into_iter().zip(gradients) {
            let period = if group == Group::Sh { coefficients } else { 1 };
            let steps: Vec<f32> =
                (0..period).map(|k| (rates.of(group, k) / corrections[0]) as f32).collect();
            if steps.iter().all(|s| *s == 0.0) {
                continue;
            }
            let scale = (1.0 / corrections[1]).sqrt() as f32;
            let part = PART / period * period;
            let values = group.of_mut(scene).par_chunks_mut(part);
            let slopes = slopes.par_chunks(part);
            let first = group.of_mut(&mut self.first).par_chunks_mut(part);
            let second = group.of_mut(&mut self.second).par_chunks_mut(part);
            values.zip(slopes).zip(first.zip(second)).for_each(|((p, g), (m, v))| {
                update(p, g, m, v, &steps, scale);
            });
        }
    }

    /// Keeps the moments of the Gaussians of `kept`, ascending indices.
    pub fn select(&mut self, kept: &[u32]) {
        select(&mut self.first, kept);
        select(&mut self.second, kept);
    }

    /// Sets the moments of all opacities to zero.
    pub(crate) fn forget_opacities(&mut self) {
        self.first.logit_opacities.fill(0.0);
        self.second.logit_opacities.fill(0.0);
    }
}

/// The first gradient that is not finite (or too large to be squared), in the order of
/// [`Group::ALL`], of a model like `scene`.
pub fn bad_gradient(scene: &Gaussians, gradients: [&[f32]; 5]) -> Option<BadGradient> {
    Group::ALL.into_iter().zip(gradients).find_map(|(group, values)| {
        let bad = |part: &[f32]| part.iter().any(|g| is_bad(*g));
        let part = values.par_chunks(PART).position_first(bad)?;
        let within = values[part * PART..].iter().position(|g| is_bad(*g))?;
        let (at, width) = (part * PART + within, group.width(scene));
        Some(BadGradient { group, gaussian: at / width, position: at % width })
    })
}

fn is_bad(gradient: f32) -> bool {
    gradient.is_nan() || gradient.abs() > LARGEST
}

/// A part of one kind of parameter. `steps` repeats along it: rate over the correction of the
/// first moment. `scale`: one over the root of the correction of the second.
fn update(p: &mut [f32], g: &[f32], m: &mut [f32], v: &mut [f32], steps: &[f32], scale: f32) {
    let n = steps.len();
    let rows = p.chunks_exact_mut(n).zip(g.chunks_exact(n));
    let moments = m.chunks_exact_mut(n).zip(v.chunks_exact_mut(n));
    if n == 1 {
        let step = steps[0];
        for ((p, g), (m, v)) in p.iter_mut().zip(g).zip(m.iter_mut().zip(v)) {
            one(p, *g, m, v, step, scale);
        }
        return;
    }
    for ((p, g), (m, v)) in rows.zip(moments) {
        for ((p, g), ((m, v), step)) in p.iter_mut().zip(g).zip(m.iter_mut().zip(v).zip(steps)) {
            one(p, *g, m, v, *step, scale);
        }
    }
}

#[inline(always)]
fn one(p: &mut f32, g: f32, m: &mut f32, v: &mut f32, step: f32, scale: f32) {
    const B1: f32 = BETA_1 as f32;
    const B2: f32 = BETA_2 as f32;
    *m = B1 * *m + (1.0 - B1) * g;
    *v = B2 * *v + (1.0 - B2) * g * g;
    *p -= step * *m / (v.sqrt() * scale + EPSILON as f32);
}
