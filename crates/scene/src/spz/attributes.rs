//! The attributes of an SPZ file, from bytes to raw parameters.

use std::f64::consts::FRAC_1_SQRT_2;

use super::super::Gaussians;
use super::super::convert::{logit, quaternion, rest_of};
use super::Header;

/// Colours are stored as `0.5 + 0.15 · DC`, which leaves room beyond 0 and 1.
pub(super) const COLOUR_SCALE: f64 = 0.15;

/// What a part of the file holds, in the order of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Attribute {
    Positions,
    Opacities,
    Colours,
    Scales,
    Rotations,
    Harmonics,
}

impl Attribute {
    pub(crate) const ALL: [Self; 6] = [
        Self::Positions,
        Self::Opacities,
        Self::Colours,
        Self::Scales,
        Self::Rotations,
        Self::Harmonics,
    ];

    /// Bytes per Gaussian.
    pub(crate) fn bytes(self, version: u8, degree: u8) -> usize {
        match self {
            Self::Positions if version == 1 => 6,
            Self::Positions => 9,
            Self::Opacities => 1,
            Self::Colours | Self::Scales => 3,
            Self::Rotations if version < 3 => 3,
            Self::Rotations => 4,
            Self::Harmonics => 3 * rest_of(degree),
        }
    }

    /// For messages.
    pub(crate) fn place(self) -> &'static str {
        match self {
            Self::Positions => "SPZ positions",
            Self::Opacities => "SPZ opacities",
            Self::Colours => "SPZ colours",
            Self::Scales => "SPZ scales",
            Self::Rotations => "SPZ rotations",
            Self::Harmonics => "SPZ spherical harmonics",
        }
    }
}

/// Appends the values of one attribute to `scene`.
pub(super) fn decode(attribute: Attribute, header: &Header, bytes: &[u8], scene: &mut Gaussians) {
    let old = header.version < 3;
    match attribute {
        Attribute::Positions if header.version == 1 => {
            scene.means.extend(bytes.chunks_exact(6).map(|b| {
                std::array::from_fn(|i| half(u16::from_le_bytes([b[2 * i], b[2 * i + 1]])))
            }));
        }
        Attribute::Positions => {
            let step = 0.5_f64.powi(header.fractional_bits.into());
            scene.means.extend(
                bytes.chunks_exact(9).map(|b| {
                    std::array::from_fn(|i| (f64::from(fixed24(&b[3 * i..])) * step) as f32)
                }),
            );
        }
        Attribute::Opacities => {
            scene.logit_opacities.extend(bytes.iter().map(|&b| logit(f64::from(b) / 255.0)));
        }
        Attribute::Colours => {
            let n = scene.sh_coefficients();
            scene.sh.resize(bytes.len() * n, 0.0);
            for (slot, &b) in scene.sh.iter_mut().step_by(n).zip(bytes) {
                *slot = ((f64::from(b) / 255.0 - 0.5) / COLOUR_SCALE) as f32;
            }
        }
        Attribute::Scales => {
            let scale = |&b: &u8| f32::from(b) / 16.0 - 10.0;
            let rows = bytes.chunks_exact(3).map(|b| [scale(&b[0]), scale(&b[1]), scale(&b[2])]);
            scene.log_scales.extend(rows);
        }
        Attribute::Rotations if old => {
            scene.rotations.extend(bytes.chunks_exact(3).map(|b| first_three([b[0], b[1], b[2]])));
        }
        Attribute::Rotations => {
            let words = bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            scene.rotations.extend(words.map(smallest_three));
        }
        Attribute::Harmonics => decode_harmonics(header.degree, bytes, scene),
    }
}

/// Stored coefficient by coefficient with three channels each; a fourth degree is left out.
fn decode_harmonics(degree: u8, bytes: &[u8], scene: &mut Gaussians) {
    let stored = rest_of(degree);
    if stored == 0 {
        return;
    }
    let n = scene.sh_coefficients();
    for (sh, b) in scene.sh.chunks_exact_mut(3 * n).zip(bytes.chunks_exact(3 * stored)) {
        for c in 0..n - 1 {
            for channel in 0..3 {
                sh[channel * n + 1 + c] = (f32::from(b[3 * c + channel]) - 128.0) / 128.0;
            }
        }
    }
}

fn fixed24(b: &[u8]) -> i32 {
    // The sign bit is moved to the top and back.
    i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8
}

/// Versions 1 and 2: x, y, z in bytes; w is not negative.
fn first_three(b: [u8; 3]) -> [f32; 4] {
    let [x, y, z] = b.map(|c| f64::from(c) / 127.5 - 1.0);
    quaternion([x, y, z], 0)
}

/// Versions 3 and 4: the place (of x, y, z, w) of the largest component in the top two bits, the
/// others with a sign and nine bits each, the last in the lowest bits.
fn smallest_three(word: u32) -> [f32; 4] {
    let small = [20, 10, 0].map(|shift| component(word >> shift));
    let [x, y, z, w] = quaternion(small, (word >> 30) as usize);
    [w, x, y, z]
}

/// A component of a quaternion from the lowest ten bits of `word`.
pub(super) fn component(word: u32) -> f64 {
    let magnitude = f64::from(word & 511) / 511.0 * FRAC_1_SQRT_2;
    if word & 512 != 0 { -magnitude } else { magnitude }
}

/// IEEE half precision.
fn half(bits: u16) -> f32 {
    let sign = if bits & 0x8000 != 0 { -1.0 } else { 1.0 };
    let fraction = f32::from(bits & 0x3ff);
    match (bits >> 10) & 0x1f {
        0 => sign * fraction * 2f32.powi(-24),
        31 if fraction == 0.0 => sign * f32::INFINITY,
        31 => f32::NAN,
        exponent => sign * (1024.0 + fraction) * 2f32.powi(i32::from(exponent) - 25),
    }
}
