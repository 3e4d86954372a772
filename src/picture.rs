//! An image in memory: what the rasteriser makes, and what display power and quality look at.

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
        self.pixels.iter().flatten().map(|&v| (v.clamp(0.0, 1.0) * 255.0).round() as u8).collect()
    }

    /// A smaller picture for reports: box-filtered by the integer factor that makes the longer
    /// side at most `side` pixels.
    pub fn shrunk(&self, side: u32) -> Picture {
        let factor = self.width.max(self.height).div_ceil(side.max(1)).max(1);
        let (width, height) = (self.width.div_ceil(factor), self.height.div_ceil(factor));
        let mut pixels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                pixels.push(self.box_mean(x * factor, y * factor, factor));
            }
        }
        Picture { width, height, pixels }
    }

    fn box_mean(&self, x0: u32, y0: u32, side: u32) -> [f32; 3] {
        let (x1, y1) = ((x0 + side).min(self.width), (y0 + side).min(self.height));
        let mut sum = [0.0f32; 3];
        for y in y0..y1 {
            for x in x0..x1 {
                let p = self.pixels[(y * self.width + x) as usize];
                sum = std::array::from_fn(|c| sum[c] + p[c].clamp(0.0, 1.0));
            }
        }
        let n = ((x1 - x0) * (y1 - y0)) as f32;
        sum.map(|s| s / n)
    }

    /// Mean linear R, G, B of the displayed (clamped) picture: the input of display power.
    pub fn mean_linear_rgb(&self) -> [f64; 3] {
        let mut sum = [0.0f64; 3];
        for row in self.pixels.chunks(self.width.max(1) as usize) {
            let mut line = [0.0f64; 3];
            for p in row {
                line = std::array::from_fn(|c| line[c] + f64::from(linear(p[c].clamp(0.0, 1.0))));
            }
            sum = std::array::from_fn(|c| sum[c] + line[c]);
        }
        sum.map(|s| s / self.pixels.len().max(1) as f64)
    }
}

/// sRGB decoding of one channel in 0..1 (IEC 61966-2-1).
fn linear(x: f32) -> f32 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}
