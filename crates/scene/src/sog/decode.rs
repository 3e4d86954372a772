//! From the pixels of SOG images to raw parameters.

use std::f64::consts::SQRT_2;

use super::super::convert::{quaternion, rest_of};
use super::super::error::SceneError;
use super::meta::SogTable;
use super::plane::Plane;

/// Alpha of a rotation whose largest component is w.
pub(super) const FIRST_LARGEST: u8 = 252;

/// Positions: 16 bits between the bounds, then the inverse of `sign(x) ln(1 + |x|)`.
pub(super) fn means(bounds: &[[f64; 3]; 2], low: &Plane, high: &Plane) -> Vec<[f32; 3]> {
    let mean = |(low, high): (&[u8; 4], &[u8; 4])| {
        std::array::from_fn(|axis| {
            let t = f64::from(u16::from_le_bytes([low[axis], high[axis]])) / 65535.0;
            let x = bounds[0][axis] * (1.0 - t) + bounds[1][axis] * t;
            (x.abs().exp_m1() * x.signum()) as f32
        })
    };
    low.pixels().iter().zip(high.pixels()).map(mean).collect()
}

/// Logarithmic scales.
pub(super) fn scales(tables: &[SogTable; 3], plane: &Plane) -> Vec<[f32; 3]> {
    let scale = |p: &[u8; 4]| std::array::from_fn(|axis| tables[axis][p[axis] as usize]);
    plane.pixels().iter().map(scale).collect()
}

/// Quaternions. An alpha that names no component gives a quaternion of length zero, which the
/// check of the whole model replaces and counts.
pub(super) fn rotations(plane: &Plane) -> Vec<[f32; 4]> {
    let rotation = |p: &[u8; 4]| match p[3].checked_sub(FIRST_LARGEST) {
        None => [0.0; 4],
        Some(largest) => quaternion([p[0], p[1], p[2]].map(component), largest as usize),
    };
    plane.pixels().iter().map(rotation).collect()
}

/// A component of a quaternion.
pub(super) fn component(byte: u8) -> f64 {
    (f64::from(byte) / 255.0 - 0.5) * SQRT_2
}

/// Raw opacities.
pub(super) fn opacities(tables: &[SogTable; 4], sh0: &Plane) -> Vec<f32> {
    sh0.pixels().iter().map(|p| tables[3][p[3] as usize]).collect()
}

/// SH coefficients of a model of degree 0.
pub(super) fn constant(tables: &[SogTable; 4], sh0: &Plane) -> Vec<f32> {
    let colour = |p: &[u8; 4]| -> [f32; 3] { std::array::from_fn(|c| tables[c][p[c] as usize]) };
    sh0.pixels().iter().flat_map(colour).collect()
}

/// SH coefficients `[channel][coefficient]` of a model with a palette.
pub(super) fn harmonics(
    tables: &[SogTable; 4],
    sh0: &Plane,
    table: &SogTable,
    palette: &Plane,
    labels: &Plane,
) -> Result<Vec<f32>, SceneError> {
    let n = 3 * (1 + rest_of(palette.degree()));
    let mut sh = Vec::with_capacity(n * sh0.pixels().len());
    for (colour, label) in sh0.pixels().iter().zip(labels.pixels()) {
        let entry = palette.entry(u16::from_le_bytes([label[0], label[1]]) as usize)?;
        for channel in 0..3 {
            sh.push(tables[channel][colour[channel] as usize]);
            sh.extend(entry.iter().map(|texel| table[texel[channel] as usize]));
        }
    }
    Ok(sh)
}
