//! An image in memory: what the rasteriser makes, and what display power and quality look at.

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

    /// A smaller picture for reports: box-filtered by the integer factor that makes the longer
    /// side at most `side` pixels.
    pub fn shrunk(&self, side: u32) -> Picture {
        let factor = self.width.max(self.height).div_ceil(side.max(1)).max(1);
        let (width, height) = (self.width.div_ceil(factor), self.height.div_ceil(factor));
        let pixels = (0..height)
            .into_par_iter()
            .flat_map_iter(|y| {
                (0..width).map(move |x| self.box_mean(x * factor, y * factor, factor))
            })
            .collect();
        Picture { width, height, pixels }
    }

    fn box_mean(&self, x0: u32, y0: u32, side: u32) -> [f32; 3] {
        let (x1, y1) = ((x0 + side).min(self.width), (y0 + side).min(self.height));
        let mut sum = [0.0f32; 3];
        for y in y0..y1 {
            let line = y as usize * self.width as usize;
            for p in &self.pixels[line + x0 as usize..line + x1 as usize] {
                for (s, v) in sum.iter_mut().zip(p) {
                    *s += v.clamp(0.0, 1.0);
                }
            }
        }
        let n = ((x1 - x0) * (y1 - y0)) as f32;
        sum.map(|s| s / n)
    }

    /// Mean linear R, G, B of the displayed picture (8 bits a channel): the input of display power.
    /// Sums are integers, so they do not depend on how the work is divided.
    pub fn mean_linear_rgb(&self) -> [f64; 3] {
        let table: [u64; 256] =
            std::array::from_fn(|v| (linear(v as f64 / 255.0) * FIXED).round() as u64);
        let sums = self
            .pixels
            .par_chunks(1 << 15)
            .map(|part| {
                let mut sums = [0u64; 3];
                for pixel in part {
                    for (sum, v) in sums.iter_mut().zip(pixel) {
                        *sum += table[usize::from(quantized(*v))];
                    }
                }
                sums
            })
            .reduce(|| [0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]);
        let scale = FIXED * self.pixels.len().max(1) as f64;
        sums.map(|sum| sum as f64 / scale)
    }
}

/// Fixed point of linear light: the largest image of 2³² pixels does not overflow.
const FIXED: f64 = (1u64 << 31) as f64;

fn quantized(v: f32) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// sRGB decoding of one channel (IEC 61966-2-1); negative values are black, above 1 the curve goes
/// on.
pub fn linear(x: f64) -> f64 {
    if x <= 0.04045 { x.max(0.0) / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
