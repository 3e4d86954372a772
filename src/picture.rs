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
    pub fn mean_linear_rgb(&self) -> [f64; 3] {
        let counts = self
            .pixels
            .par_chunks(1 << 16)
            .map(|part| {
                let mut counts = [[0u64; 256]; 3];
                for pixel in part {
                    for (row, v) in counts.iter_mut().zip(pixel) {
                        row[usize::from(quantized(*v))] += 1;
                    }
                }
                counts
            })
            .reduce(
                || [[0u64; 256]; 3],
                |mut a, b| {
                    a.iter_mut().flatten().zip(b.iter().flatten()).for_each(|(x, y)| *x += y);
                    a
                },
            );
        let n = self.pixels.len().max(1) as f64;
        counts.map(|row| {
            let sum: f64 =
                row.iter().enumerate().map(|(v, &n)| linear(v as f64 / 255.0) * n as f64).sum();
            sum / n
        })
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
