//! Lossless WebP files.

use std::io;

use image_webp::{ColorType, EncoderParams, WebPEncoder};

/// The longest side of a WebP picture, pixels.
pub const WEBP_SIDE: u32 = 1 << 14;

/// A lossless WebP file of `width * height` pixels of red, green, blue and alpha, row by row. It is
/// made with and without prediction, and the smaller one is taken.
///
/// # Errors
/// A size that does not fit `rgba`, an empty one, and a side beyond [`WEBP_SIDE`].
pub fn webp(width: u32, height: u32, rgba: &[u8]) -> io::Result<Vec<u8>> {
    if 4 * u64::from(width) * u64::from(height) != rgba.len() as u64 {
        let what = format!("{} bytes for {width}x{height} pixels", rgba.len());
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    let plain = encode(width, height, rgba, false)?;
    let predicted = encode(width, height, rgba, true)?;
    Ok(if predicted.len() < plain.len() { predicted } else { plain })
}

fn encode(width: u32, height: u32, rgba: &[u8], predict: bool) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = WebPEncoder::new(&mut file);
    let mut params = EncoderParams::default();
    params.use_predictor_transform = predict;
    encoder.set_params(params);
    let encoded = encoder.encode(rgba, width, height, ColorType::Rgba8);
    encoded.map_err(|e| io::Error::new(io::ErrorKind::InvalidInput, e.to_string()))?;
    Ok(file)
}
