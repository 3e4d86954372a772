//! The display term alone: power of a picture, and its gradient, beside another loss.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16};
use rayon::prelude::*;

use super::band::{pattern, total};
use super::light::light;
use super::window::LANES;
use powergs_base::picture::Picture;
use powergs_frame::display::Display;

/// Values of a part: three channels of whole vectors. Sums of parts are added in their order.
const PART: usize = 3 * LANES * 64;

/// Adds the derivative of `lambda` times the power of `picture` on `display` to `gradient`, and
/// returns the power, watts. Values above 1 count as they are, values below 0 as black.
///
/// # Panics
/// If `gradient` has another size than the picture.
pub fn display_term(
    picture: &Picture,
    lambda: f64,
    display: &Display,
    gradient: &mut [[f32; 3]],
) -> f64 {
    assert_eq!(gradient.len(), picture.pixels.len(), "one gradient per pixel");
    let pixels = picture.pixels.len().max(1) as f64;
    let watts = pattern(&display.coefficients().map(|k| (k / pixels) as f32));
    let slopes = pattern(&display.coefficients().map(|k| (lambda * k / pixels) as f32));
    let level = Level::new();
    let values = picture.pixels.as_flattened().par_chunks(PART);
    let parts = values.zip(gradient.as_flattened_mut().par_chunks_mut(PART));
    let sums: Vec<f64> = parts
        .map(|(values, gradient)| {
            dispatch!(level, simd => part(simd, values, gradient, &watts, &slopes))
        })
        .collect();
    sums.iter().sum::<f64>() + display.static_power.0
}

#[inline(always)]
fn part<S: Simd>(
    simd: S,
    values: &[f32],
    gradient: &mut [f32],
    watts: &[[f32; LANES]; 3],
    slopes: &[[f32; LANES]; 3],
) -> f64 {
    let mut sum = f32x16::splat(simd, 0.0);
    let pairs = values.chunks(LANES).zip(gradient.chunks_mut(LANES)).enumerate();
    for (v, (values, gradient)) in pairs {
        let n = values.len();
        // Black beyond the end.
        let mut lanes = [0.0; LANES];
        lanes[..n].copy_from_slice(values);
        let (linear, slope) = light(simd, f32x16::from_slice(simd, &lanes));
        sum = linear.mul_add(f32x16::from_slice(simd, &watts[v % 3]), sum);
        lanes[..n].copy_from_slice(gradient);
        let before = f32x16::from_slice(simd, &lanes);
        let after = slope.mul_add(f32x16::from_slice(simd, &slopes[v % 3]), before);
        after.store_slice(&mut lanes);
        gradient.copy_from_slice(&lanes[..n]);
    }
    total(sum)
}
