//! The colour filter of Duinkharjav et al. 2022: colours in the periphery are replaced by those of
//! least display power that the eye cannot distinguish from them.
//!
//! In an opponent space of linear colours, the colours that the eye cannot distinguish from a given
//! one form an ellipse of equal luminance; its axes grow with eccentricity and are given by a small
//! fitted network. The colour of least power on the ellipse has a closed form. Source: `d22`; the
//! formulas are in `docs/metrics.md`.

use rayon::prelude::*;

use super::Display;
pub use crate::fovea::GazeError;
use powergs_base::picture::{Picture, linear};

/// Linear sRGB to the opponent space: L − M, S − (L + M), L + M.
const OPPONENT: [[f64; 3]; 3] = [
    [0.143_761_428_034_245_24, 0.165_564_732_320_997_97, 0.002_287_540_298_822_887],
    [-0.212_443_033_397_820_64, -0.714_242_299_373_636_5, -0.065_591_533_195_301_59],
    [0.212_591_496, 0.715_171_392, 0.072_197_112],
];

/// Scales of the two contrasts, in and out of the network.
const CONTRAST: [f64; 2] = [0.3025, 0.00655];
/// Eccentricity at which the network ends, degrees.
const ECCENTRICITY_MAX: f64 = 35.0;
/// Centres of the five radial functions.
const CENTRES: [[f64; 3]; 5] = [
    [0.2879376, 0.2369402, 0.5613159],
    [0.3230579, 0.2218269, 1.4405838],
    [0.318064, -0.4273168, 0.4582058],
    [1.0374745, 0.4247434, -0.3239653],
    [-0.964787, 0.5064501, 0.668164],
];
/// Logarithms of their widths.
const WIDTHS: [f64; 5] = [-0.7643494, 0.0958314, -1.0020376, 0.4951079, 0.2628713];
/// Weights of the radial functions for both axes.
const WEIGHTS: [[f64; 5]; 2] = [
    [-2.9852293, 4.9475226, -4.432104, -0.3183534, -4.0198545],
    [1.4707772, -0.2756947, -0.8809302, -8.512325, -4.4651446],
];
/// Offsets of both axes.
const OFFSETS: [f64; 2] = [0.0355586, 4.137568];

/// Below this eccentricity nothing changes, degrees.
const FOVEA: f64 = 8.5;
/// Degrees from there to where the filter has its full strength.
const RAMP: f64 = 3.0;

/// A gaze at a picture on a flat screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaze {
    x: f64,
    y: f64,
    /// Distance of the eye in widths of the screen.
    distance: f64,
}

impl Gaze {
    /// A gaze at (`x`, `y`), shares of width and height from the upper left corner, on a screen
    /// that is `fov_deg` wide.
    ///
    /// # Errors
    /// A gaze outside the picture, an angle that is not between 0 and 180 degrees, or NaN.
    pub fn new(x: f64, y: f64, fov_deg: f64) -> Result<Gaze, GazeError> {
        if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
            return Err(GazeError::Gaze { x, y });
        }
        if !(fov_deg > 0.0 && fov_deg < 180.0) {
            return Err(GazeError::FieldOfView { degrees: fov_deg });
        }
        Ok(Gaze { x, y, distance: 0.5 / (fov_deg.to_radians() / 2.0).tan() })
    }

    /// The angle between the gaze and pixel (`column`, `row`), degrees. As published, it is that of
    /// their distance on a screen seen from straight ahead.
    pub fn eccentricity_deg(&self, column: u32, row: u32, picture: &Picture) -> f64 {
        let (width, height) = (f64::from(picture.width), f64::from(picture.height));
        let dx = (f64::from(column) + 0.5) / width - self.x;
        let dy = ((f64::from(row) + 0.5) / height - self.y) * height / width;
        (dx.hypot(dy) / self.distance).atan().to_degrees()
    }
}

/// The filter for one panel.
#[derive(Debug, Clone)]
pub struct Filter {
    /// The opponent space back to linear sRGB.
    inverse: [[f64; 3]; 3],
    /// Power per unit of the two opponent coordinates that change.
    slopes: [f64; 2],
}

impl Filter {
    /// The filter that saves power on `display`.
    pub fn new(display: &Display) -> Filter {
        Filter::with_weights(display.coefficients())
    }

    /// The filter for power weights of linear red, green and blue, in any unit.
    pub fn with_weights(weights: [f64; 3]) -> Filter {
        let inverse = inverted(&OPPONENT);
        let slope = |i: usize| (0..3).map(|c| weights[c] * inverse[c][i]).sum();
        Filter { inverse, slopes: [slope(0), slope(1)] }
    }

    /// Semi-axes, in opponent units, of the ellipse of colours that the eye cannot distinguish from
    /// an sRGB colour (clamped to 0..1) at an eccentricity in degrees.
    pub fn axes(&self, srgb: [f64; 3], eccentricity_deg: f64) -> [f64; 2] {
        axes(times(&OPPONENT, srgb.map(|v| linear(v.clamp(0.0, 1.0)))), eccentricity_deg)
    }

    /// The cheapest colour on that ellipse, sRGB.
    pub fn colour(&self, srgb: [f64; 3], eccentricity_deg: f64) -> [f64; 3] {
        let mut k = times(&OPPONENT, srgb.map(|v| linear(v.clamp(0.0, 1.0))));
        let a = axes(k, eccentricity_deg);
        let length = (a[0] * self.slopes[0]).hypot(a[1] * self.slopes[1]);
        if length > 0.0 {
            for i in 0..2 {
                k[i] -= a[i] * a[i] * self.slopes[i] / length;
            }
        }
        times(&self.inverse, k).map(|v| encoded(v.clamp(0.0, 1.0)))
    }

    /// Whether the filter changes anything at an eccentricity, degrees.
    pub fn changes(eccentricity_deg: f64) -> bool {
        share(eccentricity_deg) > 0.0
    }

    /// The filtered picture: unchanged in the fovea, fully filtered from 11.5 degrees on, blended
    /// in sRGB between.
    pub fn apply(&self, picture: &Picture, gaze: &Gaze) -> Picture {
        let width = picture.width.max(1) as usize;
        let mut pixels = picture.pixels.clone();
        pixels.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let degrees = gaze.eccentricity_deg(column as u32, row as u32, picture);
                let share = share(degrees);
                if share > 0.0 {
                    let cheap = self.colour(pixel.map(f64::from), degrees);
                    for (v, cheap) in pixel.iter_mut().zip(cheap) {
                        *v += (share * (cheap - f64::from(*v))) as f32;
                    }
                }
            }
        });
        Picture { width: picture.width, height: picture.height, pixels }
    }
}

/// The share of the filtered colour.
fn share(eccentricity_deg: f64) -> f64 {
    ((eccentricity_deg - FOVEA) / RAMP).clamp(0.0, 1.0)
}

/// The axes for an opponent colour.
fn axes(k: [f64; 3], eccentricity_deg: f64) -> [f64; 2] {
    // The grey of the same luminance.
    let grey = times(&OPPONENT, [k[2]; 3]);
    let contrast = |i: usize| (k[i] / (grey[i] + 1e-9) - 1.0) / CONTRAST[i];
    let place =
        [contrast(0), contrast(1), eccentricity_deg.min(ECCENTRICITY_MAX) / ECCENTRICITY_MAX];
    let radial: [f64; 5] = std::array::from_fn(|j| {
        let square: f64 = place.iter().zip(CENTRES[j]).map(|(n, c)| (n - c) * (n - c)).sum();
        (-square / (2.0 * WIDTHS[j]).exp()).exp()
    });
    std::array::from_fn(|i| {
        let sum: f64 = WEIGHTS[i].iter().zip(radial).map(|(w, r)| w * r).sum();
        let out = CONTRAST[i] / (1.0 + (-(sum + OFFSETS[i])).exp());
        (grey[i] * out).abs()
    })
}

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// The inverse of a matrix that has one, by cofactors.
fn inverted(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / determinant))
}

/// sRGB encoding of one channel.
fn encoded(x: f64) -> f64 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}
