//! Pictures from the bytes of a file. Sizes are checked before memory is taken.

use std::io::Cursor;

use image_webp::WebPDecoder;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// A kind of picture file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Portable Network Graphics.
    Png,
    /// JPEG, baseline or progressive.
    Jpeg,
    /// WebP, lossless or lossy.
    WebP,
}

impl Format {
    /// The format that a file beginning with these bytes has: twelve are enough.
    pub(crate) fn of(bytes: &[u8]) -> Option<Format> {
        if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            return Some(Format::Png);
        }
        if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
            return Some(Format::Jpeg);
        }
        let webp = bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP");
        webp.then_some(Format::WebP)
    }
}

/// Limits on the size of a decoded picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// The longest side, pixels.
    pub side: u32,
    /// Memory for the pixels, bytes.
    pub bytes: u64,
}

/// A picture that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// Another kind of file.
    #[error("this is not a PNG, JPEG or WebP picture")]
    Unknown,
    /// Damaged, or of a kind that the decoder does not know.
    #[error("Format error decoding {format:?}: {what}")]
    Broken {
        /// The format.
        format: Format,
        /// What the decoder says.
        what: String,
    },
    /// The file ends too early.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A side is too long.
    #[error("Image size exceeds limit")]
    Side,
    /// Too many pixels.
    #[error("Memory limit exceeded")]
    Memory,
}

/// The values of a picture, row by row, channels together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Samples {
    /// 0 to 255.
    Eight(Vec<u8>),
    /// 0 to 65,535.
    Sixteen(Vec<u16>),
}

/// A picture at the depth that its file has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decoded {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Values a pixel: grey, grey and alpha, RGB, or RGB and alpha.
    pub channels: usize,
    /// `width * height * channels` values.
    pub samples: Samples,
}

impl Decoded {
    /// Red, green, blue and alpha of every pixel, 0 to 1.
    pub fn rgba(&self) -> impl Iterator<Item = [f32; 4]> {
        let (eight, sixteen): (&[u8], &[u16]) = match &self.samples {
            Samples::Eight(values) => (values, &[]),
            Samples::Sixteen(values) => (&[], values),
        };
        let eight = eight.chunks_exact(self.channels).map(|p| rgba(p, u8::MAX));
        let sixteen = sixteen.chunks_exact(self.channels).map(|p| rgba(p, u16::MAX));
        let eight = eight.map(|p| p.map(|v| f32::from(v) / 255.0));
        eight.chain(sixteen.map(|p| p.map(|v| f32::from(v) / 65535.0)))
    }

    /// Red, green, blue and alpha of every pixel, 8 bits each.
    pub fn rgba8(&self) -> Vec<[u8; 4]> {
        match &self.samples {
            Samples::Eight(values) => {
                values.chunks_exact(self.channels).map(|p| rgba(p, u8::MAX)).collect()
            }
            Samples::Sixteen(values) => {
                let short = |v: u16| ((u32::from(v) + 128) / 257) as u8;
                values.chunks_exact(self.channels).map(|p| rgba(p, u16::MAX).map(short)).collect()
            }
        }
    }
}

fn rgba<T: Copy>(pixel: &[T], opaque: T) -> [T; 4] {
    match *pixel {
        [v] => [v, v, v, opaque],
        [v, a] => [v, v, v, a],
        [r, g, b] => [r, g, b, opaque],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [opaque; 4],
    }
}

/// Width and height, pixels, from the head of a file.
///
/// # Errors
/// A [`DecodeError`]: no picture, or a damaged head.
pub fn size(bytes: &[u8]) -> Result<(u32, u32), DecodeError> {
    Ok(match Format::of(bytes).ok_or(DecodeError::Unknown)? {
        Format::Png => {
            let mut decoder = png::Decoder::new(Cursor::new(bytes));
            let info = decoder.read_header_info().map_err(png_error)?;
            (info.width, info.height)
        }
        Format::Jpeg => jpeg_head(bytes, usize::MAX)?.0,
        Format::WebP => WebPDecoder::new(Cursor::new(bytes)).map_err(webp_error)?.dimensions(),
    })
}

/// The picture that a file holds; its format is told from its content. Of an animation, the first
/// frame.
///
/// # Errors
/// A [`DecodeError`]: no picture, damaged, or larger than `limits`.
pub fn decode(bytes: &[u8], limits: Limits) -> Result<Decoded, DecodeError> {
    match Format::of(bytes).ok_or(DecodeError::Unknown)? {
        Format::Png => decode_png(bytes, limits),
        Format::Jpeg => decode_jpeg(bytes, limits),
        Format::WebP => decode_webp(bytes, limits),
    }
}

/// The bytes of a picture of this size, if it may have it.
fn allowed((width, height): (u32, u32), pixel: u64, limits: Limits) -> Result<usize, DecodeError> {
    if width > limits.side || height > limits.side {
        return Err(DecodeError::Side);
    }
    let bytes = u64::from(width) * u64::from(height) * pixel;
    if bytes > limits.bytes {
        return Err(DecodeError::Memory);
    }
    usize::try_from(bytes).map_err(|_| DecodeError::Memory)
}

fn decode_png(bytes: &[u8], limits: Limits) -> Result<Decoded, DecodeError> {
    let most = png::Limits { bytes: usize::try_from(limits.bytes).unwrap_or(usize::MAX) };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), most);
    decoder.set_ignore_text_chunk(true);
    let info = decoder.read_header_info().map_err(png_error)?;
    allowed((info.width, info.height), 1, limits)?;
    // Palettes become colours, and 1, 2 and 4 bits become 8.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(png_error)?;
    let (width, height) = reader.info().size();
    let (colour, depth) = reader.output_color_type();
    let channels = colour.samples();
    let sixteen = depth == png::BitDepth::Sixteen;
    let pixel = channels as u64 * if sixteen { 2 } else { 1 };
    let mut values = vec![0; allowed((width, height), pixel, limits)?];
    reader.next_frame(&mut values).map_err(png_error)?;
    let samples = if sixteen {
        let pairs = values.as_chunks::<2>().0;
        Samples::Sixteen(pairs.iter().map(|b| u16::from_be_bytes(*b)).collect())
    } else {
        Samples::Eight(values)
    };
    Ok(Decoded { width, height, channels, samples })
}

fn png_error(error: png::DecodingError) -> DecodeError {
    match error {
        png::DecodingError::IoError(e) => DecodeError::Io(e),
        png::DecodingError::LimitsExceeded => DecodeError::Memory,
        other => DecodeError::Broken { format: Format::Png, what: other.to_string() },
    }
}

fn jpeg_options(side: usize) -> DecoderOptions {
    DecoderOptions::default().set_strict_mode(false).set_max_width(side).set_max_height(side)
}

/// Size and colour space.
fn jpeg_head(bytes: &[u8], side: usize) -> Result<((u32, u32), ColorSpace), DecodeError> {
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), jpeg_options(side));
    decoder.decode_headers().map_err(jpeg_error)?;
    let head = decoder.dimensions().zip(decoder.input_colorspace());
    let what = "no frame header".to_owned();
    let broken = || DecodeError::Broken { format: Format::Jpeg, what };
    let ((width, height), space) = head.ok_or_else(broken)?;
    Ok(((width as u32, height as u32), space))
}

fn decode_jpeg(bytes: &[u8], limits: Limits) -> Result<Decoded, DecodeError> {
    let ((width, height), space) = jpeg_head(bytes, limits.side as usize)?;
    let (space, channels) = match space {
        ColorSpace::Luma => (space, 1),
        ColorSpace::LumaA => (space, 2),
        ColorSpace::RGBA => (space, 4),
        // YCbCr, CMYK and YCCK are converted.
        _ => (ColorSpace::RGB, 3),
    };
    let mut values = vec![0; allowed((width, height), channels as u64, limits)?];
    let options = jpeg_options(limits.side as usize).jpeg_set_out_colorspace(space);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_into(&mut values).map_err(jpeg_error)?;
    Ok(Decoded { width, height, channels, samples: Samples::Eight(values) })
}

fn jpeg_error(error: zune_jpeg::errors::DecodeErrors) -> DecodeError {
    match error {
        zune_jpeg::errors::DecodeErrors::LargeDimensions(_) => DecodeError::Side,
        other => DecodeError::Broken { format: Format::Jpeg, what: other.to_string() },
    }
}

fn decode_webp(bytes: &[u8], limits: Limits) -> Result<Decoded, DecodeError> {
    let mut decoder = WebPDecoder::new(Cursor::new(bytes)).map_err(webp_error)?;
    let (width, height) = decoder.dimensions();
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let mut values = vec![0; allowed((width, height), channels as u64, limits)?];
    decoder.read_image(&mut values).map_err(webp_error)?;
    Ok(Decoded { width, height, channels, samples: Samples::Eight(values) })
}

fn webp_error(error: image_webp::DecodingError) -> DecodeError {
    match error {
        image_webp::DecodingError::IoError(e) => DecodeError::Io(e),
        other => DecodeError::Broken { format: Format::WebP, what: other.to_string() },
    }
}
