//! LDR-FLIP: the difference that people see when they flip between two pictures.
//!
//! Andersson et al., "FLIP: A Difference Evaluator for Alternating Images" (HPG 2020), after the
//! published formulas and constants (`flip` in `docs/metrics.md`): colours are filtered by the
//! contrast sensitivity of the eye in an opponent space, compared in a Hunt-adjusted CIELAB by the
//! HyAB distance, and differences of edges and points raise the result. 0 is equal, 1 the largest
//! difference.

pub mod colour;
mod filter;

use rayon::prelude::*;

use colour::{hunt_lab, linear_rgb, opponent};
use filter::{Kernel, convolved};
use powergs_base::picture::Picture;

/// Exponent of the colour difference.
const QC: f32 = 0.7;
/// Share of the largest colour difference that is mapped to [`PT`].
const PC: f32 = 0.4;
/// Where the two parts of the map meet.
const PT: f32 = 0.95;
/// Exponent of the feature difference.
const QF: f32 = 0.5;

/// Pixels per degree of a 3840-pixel-wide display of 0.7 m, seen from 0.7 m: the published default.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Mean of [`map`]; NaN if a value is not finite.
///
/// # Panics
/// As [`map`].
pub fn flip(reference: &Picture, test: &Picture, pixels_per_degree: f64) -> f64 {
    let map = map(reference, test, pixels_per_degree);
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}

/// The difference of every pixel, 0 to 1, row-major. Pictures are clamped to 0..1.
///
/// # Panics
/// If the sizes differ, there are no pixels, or `pixels_per_degree` is not from 1 to 1000.
pub fn map(reference: &Picture, test: &Picture, pixels_per_degree: f64) -> Vec<f32> {
    assert_eq!((reference.width, reference.height), (test.width, test.height), "equal sizes");
    assert!(!reference.pixels.is_empty(), "a difference needs pixels");
    assert!((1.0..=1000.0).contains(&pixels_per_degree), "an eye sees 1 to 1000 pixels a degree");
    let [a, b] = [reference, test].map(|p| FlipSeen::of(p, pixels_per_degree));
    // The largest difference that the sRGB gamut knows: green and blue.
    let extreme = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(QC);
    (0..reference.pixels.len())
        .into_par_iter()
        .map(|i| {
            let colour = spread(hyab(a.colour[i], b.colour[i]).powf(QC), extreme);
            let edges = (a.edges[i] - b.edges[i]).abs();
            let points = (a.points[i] - b.points[i]).abs();
            let features = (edges.max(points) * std::f32::consts::FRAC_1_SQRT_2).powf(QF);
            // `max` would turn NaN into a number.
            if (edges + points).is_nan() { f32::NAN } else { colour.powf(1.0 - features) }
        })
        .collect()
}

/// Lightness differences count apart from those of chroma.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Maps 0..`extreme` to 0..1; most of it to the differences that are common.
fn spread(difference: f32, extreme: f32) -> f32 {
    let knee = PC * extreme;
    if difference < knee {
        difference * PT / knee
    } else {
        PT + (difference - knee) / (extreme - knee) * (1.0 - PT)
    }
}

/// A picture as the eye sees it.
struct FlipSeen {
    /// Hunt-adjusted CIELAB of the filtered picture.
    colour: Vec<[f32; 3]>,
    /// Strength of edges.
    edges: Vec<f32>,
    /// Strength of points.
    points: Vec<f32>,
}

impl FlipSeen {
    fn of(picture: &Picture, pixels_per_degree: f64) -> FlipSeen {
        let size = (picture.width as usize, picture.height as usize);
        let space: Vec<[f32; 3]> = picture
            .pixels
            .par_iter()
            .map(|p| opponent(p.map(|v| powergs_base::picture::linear(clamped(v)) as f32)))
            .collect();
        let plane = |c: usize| space.iter().map(|p| p[c]).collect::<Vec<f32>>();
        let [y, cx, cz] = [plane(0), plane(1), plane(2)];
        let grey: Vec<f32> = y.iter().map(|v| (v + 16.0) / 116.0).collect();
        let sensed = [
            filter::sensitivity(&y, size, filter::ACHROMATIC, pixels_per_degree),
            filter::sensitivity(&cx, size, filter::RED_GREEN, pixels_per_degree),
            filter::sensitivity(&cz, size, filter::BLUE_YELLOW, pixels_per_degree),
        ];
        let colour = (0..y.len())
            .into_par_iter()
            .map(|i| {
                let rgb = linear_rgb([sensed[0][i], sensed[1][i], sensed[2][i]]);
                hunt_lab(rgb.map(|v| if v.is_nan() { v } else { v.clamp(0.0, 1.0) }))
            })
            .collect();
        let features = Kernel::features(pixels_per_degree);
        let strength = |derivative: &Kernel| {
            let x = convolved(&grey, size, derivative, &features.smooth);
            let y = convolved(&grey, size, &features.smooth, derivative);
            x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect()
        };
        FlipSeen { colour, edges: strength(&features.edge), points: strength(&features.point) }
    }
}

fn clamped(v: f32) -> f64 {
    // Infinity is no colour either.
    if v.is_finite() { f64::from(v.clamp(0.0, 1.0)) } else { f64::NAN }
}
