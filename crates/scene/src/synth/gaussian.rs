//! One Gaussian, drawn from a layout.
//!
//! The distributions are those of trained models. Of seven (38,480 to 250,000 Gaussians, five
//! trainers): sizes do not depend on opacity, and axis ratios have long tails that a Weibull
//! distribution of the logarithm describes: the median of longest to shortest is 3.8 to 22, one in
//! twenty is beyond 50. Of the two that were trained from photos with the standard recipe, 64 and
//! 65 % of opacities are below 0.35, and the SH coefficients of degree 1, 2 and 3 have standard
//! deviations 0.026, 0.020 and 0.013. Published: 65.1 % below 0.35.

use glam::{DMat3, DQuat, DVec3, Vec3};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal, Weibull};
use rand_pcg::Pcg64Mcg;

use super::layout::{Layout, LayoutKind};
use super::shape::ShapeSample;
use super::texture::SUN;

/// SH coefficients of degree 3, all channels.
pub(super) const COEFFICIENTS: usize = 48;
/// SH constants of degree 0 and 1.
const SH: (f32, f32) = (0.282_094_79, 0.488_602_5);
/// Standard deviation of the random SH coefficients by degree, 1 to 3.
const SH_NOISE: [f32; 3] = [0.026, 0.020, 0.013];
/// Spread of colour between neighbours, sRGB.
const COLOUR_NOISE: f32 = 0.04;

/// Height of the highlight of a perfectly glossy surface, sRGB.
const HIGHLIGHT: f32 = 0.15;

/// The parameters of one Gaussian, raw as in `Gaussians`.
#[derive(Debug)]
pub(super) struct Gaussian {
    pub mean: [f32; 3],
    pub log_scale: [f32; 3],
    pub rotation: [f32; 4],
    pub logit_opacity: f32,
    pub sh: [f32; COEFFICIENTS],
}

/// The distributions of one kind of Gaussian. The geometric mean of both long axes is log-normal.
struct Distributions {
    /// log(longest / middle).
    long: LogRatio,
    /// log(middle / shortest).
    flat: LogRatio,
    /// Standard deviation of the offset along the normal, in units of the spacing.
    fuzz: f64,
    /// Share of faint Gaussians.
    faint: f64,
    /// Share of large opaque Gaussians underneath.
    backing: f64,
}

/// Spread of the logarithm of the size.
const SIZE: f64 = 0.55;

/// The logarithm of the ratio of two axes: Weibull, as in trained models.
#[derive(Clone, Copy)]
struct LogRatio {
    scale: f64,
    shape: f64,
}

impl LogRatio {
    const LONG: LogRatio = LogRatio { scale: 0.86, shape: 1.19 };
    const FLAT: LogRatio = LogRatio { scale: 1.05, shape: 1.14 };

    const fn times(self, factor: f64) -> LogRatio {
        LogRatio { scale: self.scale * factor, ..self }
    }

    fn draw(self, rng: &mut Pcg64Mcg) -> f64 {
        Weibull::new(self.scale, self.shape).map_or(0.0, |ratio| ratio.sample(rng))
    }
}

const SURFACE: Distributions = Distributions {
    long: LogRatio::LONG,
    flat: LogRatio::FLAT,
    fuzz: 0.35,
    faint: 0.635,
    backing: 0.01,
};
const TERRAIN: Distributions = Distributions { backing: 0.04, ..SURFACE };
const FOLIAGE: Distributions = Distributions {
    long: LogRatio::LONG.times(1.25),
    flat: LogRatio::FLAT.times(0.85),
    fuzz: 0.2,
    backing: 0.0,
    ..SURFACE
};
const SHELL: Distributions = Distributions { fuzz: 1.0, faint: 0.5, backing: 0.06, ..SURFACE };
const FLOATERS: Distributions = Distributions { fuzz: 0.0, faint: 1.0, backing: 0.0, ..SURFACE };

const fn distributions(kind: LayoutKind) -> &'static Distributions {
    match kind {
        LayoutKind::Surface => &SURFACE,
        LayoutKind::Terrain => &TERRAIN,
        LayoutKind::Foliage => &FOLIAGE,
        LayoutKind::Shell => &SHELL,
        LayoutKind::Floaters => &FLOATERS,
    }
}

/// Mean and spread of the logit opacity. Few opaque Gaussians close a trained surface, many faint
/// ones of the same sizes refine it.
struct Solidity {
    logit: f64,
    spread: f64,
    size: f64,
    /// Distance behind the surface, in units of the spacing.
    behind: f64,
}

const FAINT: Solidity = Solidity { logit: -2.6, spread: 1.2, size: 1.0, behind: 0.0 };
const SOLID: Solidity = Solidity { logit: 1.5, spread: 2.1, size: 1.0, behind: 0.0 };
/// The large ones underneath, without which a surface of random points has holes.
const BACKING: Solidity = Solidity { logit: 4.0, spread: 1.0, size: 2.5, behind: 1.0 };

impl Solidity {
    fn draw(shares: &Distributions, rng: &mut Pcg64Mcg) -> &'static Solidity {
        let at: f64 = rng.random();
        if at < shares.faint {
            &FAINT
        } else if at < 1.0 - shares.backing {
            &SOLID
        } else {
            &BACKING
        }
    }
}

impl Gaussian {
    /// Draws a part, a point of it, and the Gaussian there.
    pub(crate) fn draw(layout: &Layout, rng: &mut Pcg64Mcg) -> Gaussian {
        let (part, count) = layout.draw(rng);
        let sample = part.shape.sample(rng);
        let shape = distributions(part.kind);
        let spacing = 1.0 / (count * sample.density).sqrt();
        let solidity = Solidity::draw(shape, rng);
        let offset = (normal(rng) * shape.fuzz - solidity.behind) * spacing;
        let position = sample.position + sample.normal * offset;
        let size = (part.cover * solidity.size * spacing).ln() + normal(rng) * SIZE;
        let [long, flat] = [shape.long, shape.flat].map(|r| r.draw(rng) * layout.elongation);
        let log_scale = [size + 0.5 * long, size - 0.5 * long, size - 0.5 * long - flat];
        let logit_opacity = solidity.logit + solidity.spread * normal(rng);
        let colour = part.look.colour(position, sample.normal);
        Gaussian {
            mean: position.as_vec3().to_array(),
            log_scale: log_scale.map(|s| s as f32),
            rotation: orientation(&sample, rng),
            // Training removes what is below 0.005, and single precision ends near 1.
            logit_opacity: logit_opacity.clamp(-5.29, 8.0) as f32,
            sh: harmonics(colour, part.look.gloss, sample.normal, rng),
        }
    }
}

fn normal(rng: &mut Pcg64Mcg) -> f64 {
    rng.sample(StandardNormal)
}

/// The quaternion (w, x, y, z) whose axes are: along, across, normal.
fn orientation(sample: &ShapeSample, rng: &mut Pcg64Mcg) -> [f32; 4] {
    // Surfaces are not quite flat, and neither are trained Gaussians quite aligned with them.
    let wobble = DVec3::from_array(std::array::from_fn(|_| 0.12 * normal(rng)));
    let up = (sample.normal + wobble).normalize_or(DVec3::Z);
    let along = sample.along.map_or_else(
        || {
            let (x, y) = up.any_orthonormal_pair();
            let angle = std::f64::consts::TAU * rng.random::<f64>();
            x * angle.cos() + y * angle.sin()
        },
        |along| up.cross(along.cross(up)).normalize_or(up.any_orthonormal_vector()),
    );
    let q = DQuat::from_mat3(&DMat3::from_cols(along, up.cross(along), up)).as_quat();
    [q.w, q.x, q.y, q.z]
}

/// SH coefficients `[channel][coefficient]` with this colour on average: noise that decays with the
/// degree, and towards the mirrored sun a highlight of degree 1.
fn harmonics(colour: Vec3, gloss: f32, facing: DVec3, rng: &mut Pcg64Mcg) -> [f32; COEFFICIENTS] {
    let mut sh = [0.0; COEFFICIENTS];
    let mirrored = (facing * (2.0 * facing.dot(SUN)) - SUN).as_vec3();
    // Colours are looked up by the direction from the camera, so the highlight is at -mirrored.
    let lobe = [mirrored.y, -mirrored.z, mirrored.x].map(|v| v * HIGHLIGHT * gloss / SH.1);
    let jitter = normal(rng) as f32 * COLOUR_NOISE;
    for (channel, sh) in sh.chunks_exact_mut(COEFFICIENTS / 3).enumerate() {
        let own = 0.3 * COLOUR_NOISE * normal(rng) as f32;
        sh[0] = (colour[channel] + jitter + own - 0.5) / SH.0;
        for (k, value) in sh.iter_mut().enumerate().skip(1) {
            let degree = k.isqrt();
            let noise: f32 = rng.sample(StandardNormal);
            *value = noise * SH_NOISE[degree - 1] + if k < 4 { lobe[k - 1] } else { 0.0 };
        }
    }
    sh
}
