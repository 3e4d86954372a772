//! An image in memory: the output of the rasteriser, the input of display power and quality.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, i32x16};
use fearless_simd_macros::simd;
use rayon::prelude::*;

/// An RGB image, sRGB-encoded floats, row-major. Values may exceed 1 (renders are not clamped).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// The picture as a display gets it: clamped to 0..1 and rounded to 8 bits, 3 bytes a pixel.
    pub fn to_rgb8(&self) -> Vec<u8> {
        self.pixels.iter().flatten().map(|&v| quantized(v)).collect()
    }

    /// A smaller picture for reports: every pixel is the mean of 2x2 samples of a square, which is
    /// so large that the longer side of the picture has at most `side` pixels.
    pub fn shrunk(&self, side: u32) -> Picture {
        let factor = self.width.max(self.height).div_ceil(side.max(1)).max(1);
        let (width, height) = (self.width.div_ceil(factor), self.height.div_ceil(factor));
        let pixels = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                (0..width).map(move |x| self.sampled(x * factor, y * factor, factor))
            })
            .collect();
        Picture { width, height, pixels }
    }

    fn sampled(&self, x0: u32, y0: u32, side: u32) -> [f32; 3] {
        let mut sum = [0.0f32; 3];
        for i in 0..4 {
            let x = (x0 + side * (2 * (i & 1) + 1) / 4).min(self.width - 1);
            let y = (y0 + side * (2 * (i >> 1) + 1) / 4).min(self.height - 1);
            let pixel = self.pixels[y as usize * self.width as usize + x as usize];
            for (s, v) in sum.iter_mut().zip(pixel) {
                *s += v.clamp(0.0, 1.0);
            }
        }
        sum.map(|s| s / 4.0)
    }

    /// Mean linear R, G, B of the displayed picture (8 bits a channel): the input of display power.
    /// Sums are integers, so they do not depend on how the work is divided.
    pub fn mean_linear_rgb(&self) -> [f64; 3] {
        let table: [u64; 256] =
            std::array::from_fn(|v| (linear(v as f64 / 255.0) * FIXED).round() as u64);
        let level = Level::new();
        let sums = self
            .pixels
            .par_chunks(1 << 15)
            .map(|part| {
                let mut sums = [0u64; 3];
                dispatch!(level, simd => light(simd, part.as_flattened(), &table, &mut sums));
                sums
            })
            .reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
        let scale = FIXED * self.pixels.len().max(1) as f64;
        sums.map(|sum| sum as f64 / scale)
    }
}

/// Fixed point of linear light: the largest image of 2³² pixels does not overflow.
const FIXED: f64 = (1u64 << 31) as f64;

/// Adds the table's value of every 8-bit channel value; `values` begins with red.
#[simd]
fn light<S: Simd>(simd: S, values: &[f32], table: &[u64; 256], sums: &mut [u64; 3]) {
    // Sixteen pixels at a time, so that a lane's channel is its position modulo three.
    let (blocks, rest) = values.as_chunks::<48>();
    for block in blocks {
        let mut codes = [0i32; 48];
        for (lanes, out) in block.as_chunks::<16>().0.iter().zip(codes.as_chunks_mut::<16>().0) {
            let v = f32x16::simd_from(simd, *lanes);
            let clamped = v.max(f32x16::splat(simd, 0.0)).min(f32x16::splat(simd, 1.0));
            *out = (clamped * 255.0 + 0.5).to_int::<i32x16<S>>().into();
        }
        for code in codes.as_chunks::<3>().0 {
            for (sum, v) in sums.iter_mut().zip(code) {
                *sum += table[(*v & 255) as usize];
            }
        }
    }
    for (i, v) in rest.iter().enumerate() {
        sums[i % 3] += table[usize::from(quantized(*v))];
    }
}

fn quantized(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// sRGB decoding of one channel (IEC 61966-2-1); negative values are black, above 1 the curve goes
/// on.
pub fn linear(x: f64) -> f64 {
    if x <= 0.04045 { x.max(0.0) / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
