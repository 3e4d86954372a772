//! An 8-bit RGB image: parts of charts, and what PNG files are made of.

use std::io::{self, Write};

/// An image of three bytes a pixel, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RgbImage {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
}

impl RgbImage {
    /// An image of one colour.
    pub fn filled(width: u32, height: u32, colour: [u8; 3]) -> Self {
        Self::from_fn(width, height, |_, _| colour)
    }

    /// An image whose pixel at column `x` and row `y` is `colour(x, y)`.
    pub fn from_fn(width: u32, height: u32, mut colour: impl FnMut(u32, u32) -> [u8; 3]) -> Self {
        let mut bytes = Vec::with_capacity(3 * width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                bytes.extend(colour(x, y));
            }
        }
        RgbImage { width, height, bytes }
    }

    /// An image of these bytes; `None` if there are too few for its size. Bytes beyond it are
    /// left out.
    pub fn from_bytes(width: u32, height: u32, mut bytes: Vec<u8>) -> Option<Self> {
        let needed = 3 * width as usize * height as usize;
        (bytes.len() >= needed).then(|| {
            bytes.truncate(needed);
            RgbImage { width, height, bytes }
        })
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All bytes, row by row.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The pixel at column `x` and row `y`.
    ///
    /// # Panics
    /// Outside the image.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        let start = self.start(x, y);
        [self.bytes[start], self.bytes[start + 1], self.bytes[start + 2]]
    }

    fn start(&self, x: u32, y: u32) -> usize {
        3 * (y as usize * self.width as usize + x as usize)
    }

    /// Puts `top` over this image with its upper left corner at column `x` and row `y`; what lies
    /// outside is left out.
    pub fn paste(&mut self, top: &RgbImage, x: u32, y: u32) {
        let columns = top.width.min(self.width.saturating_sub(x));
        let rows = top.height.min(self.height.saturating_sub(y));
        let length = 3 * columns as usize;
        for row in 0..if length > 0 { rows } else { 0 } {
            let (from, to) = (top.start(0, row), self.start(x, y + row));
            self.bytes[to..to + length].copy_from_slice(&top.bytes[from..from + length]);
        }
    }

    /// The part of `width` x `height` pixels from column `x` and row `y`, as far as it is inside.
    pub fn cropped(&self, x: u32, y: u32, width: u32, height: u32) -> RgbImage {
        let width = width.min(self.width.saturating_sub(x));
        let height = height.min(self.height.saturating_sub(y));
        RgbImage::from_fn(width, height, |i, j| self.pixel(x + i, y + j))
    }

    /// The image at another size: linear between pixels where it grows, a tent over all pixels
    /// that fall together where it shrinks.
    pub fn resized(&self, width: u32, height: u32) -> RgbImage {
        if (width, height) == (self.width, self.height) {
            return self.clone();
        }
        if self.bytes.is_empty() {
            return RgbImage::filled(width, height, [0; 3]);
        }
        let stride = self.width as usize;
        let line = 3 * stride;
        let mut tall = Vec::with_capacity(line * height as usize);
        for tap in taps(self.height, height) {
            for i in 0..line {
                let mut sum = 0.0;
                for (k, w) in tap.weights.iter().enumerate() {
                    sum += f32::from(self.bytes[(tap.first + k) * line + i]) * w;
                }
                tall.push(sum);
            }
        }
        let columns = taps(self.width, width);
        let mut bytes = Vec::with_capacity(3 * width as usize * height as usize);
        for row in tall.chunks_exact(line) {
            for tap in &columns {
                for c in 0..3 {
                    let mut sum = 0.0;
                    for (k, w) in tap.weights.iter().enumerate() {
                        sum += row[3 * (tap.first + k) + c] * w;
                    }
                    bytes.push(sum.clamp(0.0, 255.0).round() as u8);
                }
            }
        }
        RgbImage { width, height, bytes }
    }

    /// The image as a PNG file.
    ///
    /// # Errors
    /// An image without pixels.
    pub fn png(&self) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        write_png(&mut file, self.width, self.height, &self.bytes)?;
        Ok(file)
    }
}

/// The old samples that a new one is made of.
struct Tap {
    first: usize,
    weights: Vec<f32>,
}

fn taps(old: u32, new: u32) -> Vec<Tap> {
    let ratio = old as f32 / new as f32;
    let reach = ratio.max(1.0);
    let tent = |x: f32| (1.0 - x.abs()).max(0.0);
    let tap = |i: u32| {
        let middle = (i as f32 + 0.5) * ratio;
        let first = ((middle - reach).floor() as i64).clamp(0, i64::from(old) - 1);
        let last = ((middle + reach).ceil() as i64).clamp(first + 1, i64::from(old));
        let middle = middle - 0.5;
        let mut weights: Vec<f32> =
            (first..last).map(|k| tent((k as f32 - middle) / reach)).collect();
        let sum = weights.iter().fold(0.0, |sum, w| sum + w);
        weights.iter_mut().for_each(|w| *w /= sum);
        Tap { first: first as usize, weights }
    };
    (0..new).map(tap).collect()
}

/// Writes an 8-bit PNG of `width * height` pixels of three bytes.
///
/// # Errors
/// Those of `out`, and a size that does not fit `rgb`.
pub fn write_png(out: impl Write, width: u32, height: u32, rgb: &[u8]) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(())
}
