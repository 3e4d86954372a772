//! The light of sRGB colours in double precision, for checks of the display term of the loss.

use powergs_base::picture::linear;

/// Where the sRGB curve changes from a line to a power.
const KNEE: f64 = 0.04045;

/// The derivative of [`linear`] by the sRGB value; 0 at and below black.
pub fn linear_slope(srgb: f64) -> f64 {
    match srgb {
        s if s <= 0.0 => 0.0,
        s if s <= KNEE => 1.0 / 12.92,
        s => 2.4 / 1.055 * ((s + 0.055) / 1.055).powf(1.4),
    }
}

/// Means of linear R, G, B of sRGB pixels as rendered, not clamped above 1; black without pixels.
pub fn mean_linear(pixels: &[[f32; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in pixels {
        for (total, &value) in sum.iter_mut().zip(pixel) {
            *total += linear(f64::from(value));
        }
    }
    sum.map(|s| s / pixels.len().max(1) as f64)
}
