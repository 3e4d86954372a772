//! Filters of FLIP: contrast sensitivity, and detectors of edges and points. The border is
//! repeated outwards.

use std::f64::consts::PI;

use rayon::prelude::*;

/// Contrast sensitivity of a channel as two Gaussians `(a, b)`: `a √(π/b) e^(−π² d²/b)`, d in
/// degrees.
pub type FilterSensitivity = [(f64, f64); 2];

/// Of lightness.
pub(crate) const ACHROMATIC: FilterSensitivity = [(1.0, 0.0047), (0.0, 1e-5)];
/// Between red and green.
pub(crate) const RED_GREEN: FilterSensitivity = [(1.0, 0.0053), (0.0, 1e-5)];
/// Between blue and yellow.
pub(crate) const BLUE_YELLOW: FilterSensitivity = [(34.1, 0.04), (13.5, 0.025)];

/// Width of the feature detectors, degrees.
const FEATURE: f64 = 0.082;

/// Weights along an axis, from −radius to radius.
#[derive(Debug, Clone)]
pub(crate) struct Kernel(Vec<f32>);

/// The kernels of feature detection.
pub struct Features {
    /// First derivative.
    pub edge: Kernel,
    /// Second derivative.
    pub point: Kernel,
    /// The Gaussian across the derivative.
    pub smooth: Kernel,
}

impl Kernel {
    /// Edge and point detectors: derivatives whose positive and negative weights add up to 1 and
    /// −1.
    pub(crate) fn features(pixels_per_degree: f64) -> Features {
        let sigma = 0.5 * FEATURE * pixels_per_degree;
        let radius = (3.0 * sigma).ceil() as i64;
        let sample = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (-radius..=radius)
                .map(|x| f(x as f64) * (-(x * x) as f64 / (2.0 * sigma * sigma)).exp())
                .collect()
        };
        Features {
            edge: balanced(&sample(&|x| -x)),
            point: balanced(&sample(&|x| x * x / (sigma * sigma) - 1.0)),
            smooth: balanced(&sample(&|_| 1.0)),
        }
    }
}

/// Positive weights divided by their sum, negative ones by minus theirs.
fn balanced(weights: &[f64]) -> Kernel {
    let sum = |sign: f64| weights.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
    let (up, down) = (sum(1.0), sum(-1.0));
    Kernel(weights.iter().map(|&w| (if w < 0.0 { w / down } else { w / up }) as f32).collect())
}

/// A channel filtered by its contrast sensitivity.
pub(crate) fn sensitivity(
    plane: &[f32],
    size: (usize, usize),
    gaussians: FilterSensitivity,
    pixels_per_degree: f64,
) -> Vec<f32> {
    // All channels have the radius of the widest Gaussian.
    let widest = BLUE_YELLOW[0].1;
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i64;
    let parts = gaussians.map(|(a, b)| {
        let at = |x: i64| (-(PI * x as f64 / pixels_per_degree).powi(2) / b).exp();
        let weights: Vec<f64> = (-radius..=radius).map(at).collect();
        // The volume of the two-dimensional Gaussian.
        let volume = a * (PI / b).sqrt() * weights.iter().sum::<f64>().powi(2);
        (balanced(&weights), volume)
    });
    let whole: f64 = parts.iter().map(|p| p.1).sum();
    let mut out = vec![0.0; plane.len()];
    for (kernel, volume) in parts.iter().filter(|p| p.1 > 0.0) {
        let share = (volume / whole) as f32;
        for (o, v) in out.iter_mut().zip(convolved(plane, size, kernel, kernel)) {
            *o += share * v;
        }
    }
    out
}

/// Correlation with `horizontal` along rows and `vertical` along columns.
pub(crate) fn convolved(
    plane: &[f32],
    (width, height): (usize, usize),
    horizontal: &Kernel,
    vertical: &Kernel,
) -> Vec<f32> {
    let radius = horizontal.0.len() / 2;
    let mut along = vec![0.0; plane.len()];
    along.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each_init(
        || vec![0.0; width + 2 * radius],
        |padded, (out, row)| {
            padded[..radius].fill(row[0]);
            padded[radius..radius + width].copy_from_slice(row);
            padded[radius + width..].fill(row[width - 1]);
            out.fill(0.0);
            for (k, &w) in horizontal.0.iter().enumerate() {
                for (o, v) in out.iter_mut().zip(&padded[k..]) {
                    *o += w * v;
                }
            }
        },
    );
    let radius = vertical.0.len() / 2;
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (k, &w) in vertical.0.iter().enumerate() {
            let from = (y + k).saturating_sub(radius).min(height - 1);
            for (o, v) in out.iter_mut().zip(&along[from * width..(from + 1) * width]) {
                *o += w * v;
            }
        }
    });
    out
}
