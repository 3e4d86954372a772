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
        let start = 3 * (y as usize * self.width as usize + x as usize);
        [self.bytes[start], self.bytes[start + 1], self.bytes[start + 2]]
    }

    /// The part of `width` x `height` pixels from column `x` and row `y`, as far as it is inside.
    pub fn cropped(&self, x: u32, y: u32, width: u32, height: u32) -> RgbImage {
        let width = width.min(self.width.saturating_sub(x));
        let height = height.min(self.height.saturating_sub(y));
        RgbImage::from_fn(width, height, |i, j| self.pixel(x + i, y + j))
    }

    /// The image as a PNG file.
    ///
    /// # Errors
    /// An image without pixels.
    pub fn png(&self) -> io::Result<Vec<u8>> {
        self.png_of(None, None)
    }

    /// As [`RgbImage::png`], with the number of pixels in an inch of print, and the software that
    /// made it.
    ///
    /// # Errors
    /// As [`RgbImage::png`].
    pub fn png_of(&self, per_inch: Option<f64>, software: Option<&str>) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        let about = PngAbout { per_inch, software };
        encode(&mut file, self.width, self.height, &self.bytes, about)?;
        Ok(file)
    }
}

/// Writes an 8-bit PNG of `width * height` pixels of three bytes.
///
/// # Errors
/// Those of `out`, and a size that does not fit `rgb`.
pub fn write_png(out: impl Write, width: u32, height: u32, rgb: &[u8]) -> io::Result<()> {
    encode(out, width, height, rgb, PngAbout::default())
}

/// What a PNG says besides its pixels.
#[derive(Debug, Clone, Copy, Default)]
struct PngAbout<'a> {
    /// Pixels in an inch of print.
    per_inch: Option<f64>,
    /// What made it.
    software: Option<&'a str>,
}

/// Metres in an inch.
const INCH: f64 = 0.0254;

fn encode(
    out: impl Write,
    width: u32,
    height: u32,
    rgb: &[u8],
    about: PngAbout<'_>,
) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    // PNG counts by the metre.
    encoder.set_pixel_dims(about.per_inch.map(|n| {
        let per_metre = (n / INCH).round() as u32;
        png::PixelDimensions { xppu: per_metre, yppu: per_metre, unit: png::Unit::Meter }
    }));
    if let Some(software) = about.software {
        encoder.add_text_chunk("Software".to_owned(), software.to_owned())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    writer.finish()?;
    Ok(())
}
