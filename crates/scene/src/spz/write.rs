//! Writes SPZ version 3: one gzip stream, axes right-up-back.
//!
//! Positions have as many bits after the point as let the farthest Gaussian fit into 24 bits.
//! Scales, colours and SH coefficients beyond the range of their bytes become its end.

use std::f64::consts::SQRT_2;
use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::super::Gaussians;
use super::super::axes::StoredAxes;
use super::super::convert::{opacities_beyond_bytes, opacity_byte, rest_of};
use super::super::export::{Clamped, ExportError};
use super::super::smallest_three::{SmallestThree, encode};
use super::attributes::{Attribute, COLOUR_SCALE, component};
use super::{FLAG_ANTIALIASED, MAGIC};

const VERSION: u32 = 3;
/// The largest coordinate in units of its last bit.
const MOST: f64 = 8_388_607.0;
/// Most bits after the point: with 23 bits coordinates below 1 have as many as single precision.
const MOST_BITS: u8 = 23;

/// The file, and what was cut off.
///
/// # Errors
/// A position beyond 24 bits, an error of the encoder.
pub(in super::super) fn write(scene: &Gaussians) -> Result<(Vec<u8>, Clamped), ExportError> {
    let bits = fractional_bits(scene)?;
    let mut turned = scene.clone();
    StoredAxes::RIGHT_UP_BACK.turn(&mut turned);
    let mut clamped =
        Clamped { opacity: opacities_beyond_bytes(&scene.logit_opacities), ..Clamped::default() };
    let mut stream = GzEncoder::new(Vec::new(), Compression::best());
    stream.write_all(MAGIC)?;
    stream.write_all(&VERSION.to_le_bytes())?;
    stream.write_all(&(scene.len() as u32).to_le_bytes())?;
    let flags = if scene.antialiased { FLAG_ANTIALIASED } else { 0 };
    stream.write_all(&[scene.sh_degree, bits, flags, 0])?;
    for attribute in Attribute::ALL {
        stream.write_all(&packed(attribute, &turned, bits, &mut clamped))?;
    }
    Ok((stream.finish()?, clamped))
}

/// The most bits after the point with which all positions fit.
fn fractional_bits(scene: &Gaussians) -> Result<u8, ExportError> {
    let all = scene.means.as_flattened().iter().enumerate();
    let farthest = all.max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
    let (at, &value) = farthest.expect("the model was checked to have Gaussians");
    let fits = |bits: &u8| (f64::from(value.abs()) * 2_f64.powi((*bits).into())).round() <= MOST;
    (0..=MOST_BITS).rev().find(fits).ok_or(ExportError::Position {
        index: at / 3,
        value,
        limit: MOST as u32,
        format: "spz",
    })
}

/// The bytes of an attribute of a model that has the axes of the file.
fn packed(attribute: Attribute, scene: &Gaussians, bits: u8, clamped: &mut Clamped) -> Vec<u8> {
    let n = scene.sh_coefficients();
    match attribute {
        Attribute::Positions => {
            let unit = 2_f64.powi(bits.into());
            let fixed = |v: &f32| (f64::from(*v) * unit).round() as i32;
            let all = scene.means.as_flattened().iter().map(fixed);
            all.flat_map(|v| {
                let [a, b, c, _] = v.to_le_bytes();
                [a, b, c]
            })
            .collect()
        }
        Attribute::Opacities => {
            scene.logit_opacities.iter().map(|&raw| opacity_byte(raw)).collect()
        }
        Attribute::Colours => {
            let code = |dc: &f32| (f64::from(*dc) * COLOUR_SCALE + 0.5) * 255.0;
            bytes(scene.sh.iter().step_by(n).map(code), &mut clamped.colour_dc)
        }
        Attribute::Scales => {
            let code = |scale: &f32| (f64::from(*scale) + 10.0) * 16.0;
            bytes(scene.log_scales.as_flattened().iter().map(code), &mut clamped.scale)
        }
        Attribute::Rotations => scene.rotations.iter().flat_map(|&q| rotation(q)).collect(),
        Attribute::Harmonics => {
            let rest = rest_of(scene.sh_degree);
            let texels = scene.sh.chunks_exact(3 * n).flat_map(|sh| {
                (0..3 * rest).map(move |i| f64::from(sh[i % 3 * n + 1 + i / 3]) * 128.0 + 128.0)
            });
            bytes(texels, &mut clamped.colour_rest)
        }
    }
}

/// Codes as bytes; those beyond the first and the last are counted.
fn bytes(codes: impl Iterator<Item = f64>, clamped: &mut u64) -> Vec<u8> {
    let mut beyond = 0;
    let byte = |code: f64| {
        // A code that rounds into the range is not beyond it.
        beyond += u64::from(!(-0.5..=255.5).contains(&code));
        code.round() as u8
    };
    let bytes = codes.map(byte).collect();
    *clamped += beyond;
    bytes
}

/// The place of the largest of x, y, z, w in two bits, the others with a sign and nine bits each.
fn rotation([w, x, y, z]: [f32; 4]) -> [u8; 4] {
    let ten_bits = |c: f64| {
        let magnitude = (c.abs() * SQRT_2 * 511.0).round().min(511.0) as u32;
        u32::from(c < 0.0 && magnitude > 0) << 9 | magnitude
    };
    let SmallestThree { place, codes } = encode([x, y, z, w], ten_bits, component);
    codes.iter().fold(place, |word, code| word << 10 | code).to_le_bytes()
}
