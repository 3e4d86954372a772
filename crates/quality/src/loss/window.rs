//! The window of SSIM: 11 x 11, a Gaussian of sigma 1.5, as two passes of 11 taps.
//!
//! Rows are interleaved RGB: a neighbour to the right is three values further. Outside the picture
//! everything is 0, as published.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;

/// Values that are worked on at a time.
pub(crate) const LANES: usize = 16;
/// Pixels on each side of the middle.
pub(crate) const RADIUS: usize = 5;
/// Pixels of the window along an axis.
pub(crate) const TAPS: usize = 2 * RADIUS + 1;
/// Values on each side of a padded row.
pub(crate) const PAD: usize = 3 * RADIUS;

const SIGMA: f64 = 1.5;

/// The weights along an axis; they add up to 1.
pub(crate) fn weights() -> [f32; TAPS] {
    let raw: [f64; TAPS] = std::array::from_fn(|i| {
        let d = i as f64 - RADIUS as f64;
        (-d * d / (2.0 * SIGMA * SIGMA)).exp()
    });
    let sum: f64 = raw.iter().sum();
    raw.map(|w| (w / sum) as f32)
}

/// A padded row for `n` values: zeros, the values, zeros.
pub(crate) fn padded(n: usize) -> Vec<f32> {
    vec![0.0; super::lanes(n) + 2 * PAD + 1]
}

/// The window along a padded row, centred on the values `i..i + 16` of the row.
#[inline(always)]
pub(crate) fn along<S: Simd>(simd: S, w: &[f32; TAPS], row: &[f32], i: usize) -> f32x16<S> {
    let near = &row[i..i + LANES + 2 * PAD];
    let mut sum = f32x16::from_slice(simd, &near[..LANES]) * w[0];
    for k in 1..TAPS {
        let values = f32x16::from_slice(simd, &near[3 * k..3 * k + LANES]);
        sum = values.mul_add(f32x16::splat(simd, w[k]), sum);
    }
    sum
}

/// The window across 11 rows, at the values `i..i + 16`.
#[inline(always)]
pub(crate) fn across<S: Simd>(
    simd: S,
    w: &[f32; TAPS],
    rows: &[&[f32]; TAPS],
    i: usize,
) -> f32x16<S> {
    let mut sum = f32x16::from_slice(simd, &rows[0][i..i + LANES]) * w[0];
    for k in 1..TAPS {
        let values = f32x16::from_slice(simd, &rows[k][i..i + LANES]);
        sum = values.mul_add(f32x16::splat(simd, w[k]), sum);
    }
    sum
}

/// The last 11 rows of `MAPS` maps.
#[derive(Debug)]
pub struct Ring<const MAPS: usize> {
    stride: usize,
    values: Vec<f32>,
    zeros: Vec<f32>,
}

impl<const MAPS: usize> Ring<MAPS> {
    /// A ring for rows of `n` values.
    pub(crate) fn new(n: usize) -> Self {
        let stride = super::lanes(n);
        Ring { stride, values: vec![0.0; TAPS * MAPS * stride], zeros: vec![0.0; stride] }
    }

    /// Where row `y` of map `map` goes, over the row 11 above it.
    pub(crate) fn row_mut(&mut self, map: usize, y: usize) -> &mut [f32] {
        let at = ((y % TAPS) * MAPS + map) * self.stride;
        &mut self.values[at..at + self.stride]
    }

    /// The 11 rows of a map around row `y` of a picture of `height` rows.
    pub(crate) fn around(&self, map: usize, y: usize, height: usize) -> [&[f32]; TAPS] {
        std::array::from_fn(|k| match (y + k).checked_sub(RADIUS) {
            Some(row) if row < height => {
                let at = ((row % TAPS) * MAPS + map) * self.stride;
                &self.values[at..at + self.stride]
            }
            _ => &self.zeros,
        })
    }
}
