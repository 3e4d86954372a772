//! The exact footprint: the ellipse inside which a splat's α reaches 1/255.
//!
//! With conic C and offset δ, α ≥ 1/255 where δᵀCδ ≤ L, L = 2 ln(255 o). The right boundary at
//! height δy is δx = (−c1 δy + √(c0 L − det δy²)) / c0, whose maximum over a slab of rows is at the
//! ellipse's rightmost point or at the slab's nearest edge.

use super::{ALPHA_STEPS, Splat};

/// The ellipse of one splat, double precision.
#[derive(Debug, Clone, Copy)]
pub struct Ellipse {
    mean: [f64; 2],
    conic: [f64; 3],
    det: f64,
    level: f64,
    /// Half-height of the ellipse, pixels.
    reach_y: f64,
    /// δy of the rightmost point.
    extreme_y: f64,
}

impl Ellipse {
    /// The ellipse of `splat`; `None` if nothing of it reaches α = 1/255. With a margin that covers
    /// the single-precision evaluation of α, so that the ellipse never misses a pixel that blends.
    pub fn new(splat: &Splat, conic: [f32; 3]) -> Option<Ellipse> {
        let [c0, c1, c2] = conic.map(f64::from);
        let det = c0 * c2 - c1 * c1;
        let exact = 2.0 * (ALPHA_STEPS * f64::from(splat.opacity)).ln();
        if exact.is_nan() || exact < -1e-3 {
            return None;
        }
        // Terms of the quadratic form cancel by up to c0·c2/det where they meet the boundary.
        let level = exact + 2e-3 + 1e-6 * exact * (c0 * c2 / det).abs();
        let reach_y = (c0 * level / det).sqrt();
        let extreme_y = -c1 * (level / (c2 * det)).sqrt();
        let mean = splat.mean.map(f64::from);
        Some(Ellipse { mean, conic: [c0, c1, c2], det, level, reach_y, extreme_y })
    }

    /// That of a splat whose conic nobody has at hand; `None` also where its covariance has none.
    pub fn of(splat: &Splat) -> Option<Ellipse> {
        Ellipse::new(splat, splat.conic()?)
    }

    /// The pixels `x0..x1` of a row that the ellipse reaches, of those between two columns.
    pub fn span(&self, y: u32, [x0, x1]: [u32; 2]) -> Option<[u32; 2]> {
        let (first, end) = self.columns(i64::from(y), i64::from(y) + 1)?;
        let first = first.clamp(i64::from(x0), i64::from(x1)) as u32;
        let end = end.clamp(i64::from(first), i64::from(x1)) as u32;
        (first < end).then_some([first, end])
    }

    /// Whether the shape is a proper ellipse; where rounding made the conic indefinite, only the
    /// bounding square limits the splat.
    fn is_proper(&self) -> bool {
        self.det > 0.0 && self.conic[0] > 0.0 && self.reach_y.is_finite()
    }

    /// The pixels columns `first..end` that the ellipse may reach in the pixel rows `y0..y1`
    /// (half open), unclipped; `None` if it reaches none.
    pub fn columns(&self, y0: i64, y1: i64) -> Option<(i64, i64)> {
        if !self.is_proper() {
            return Some((-FURTHEST, FURTHEST));
        }
        let lo = (y0 as f64 - self.mean[1]).max(-self.reach_y);
        let hi = ((y1 - 1) as f64 - self.mean[1]).min(self.reach_y);
        if lo > hi {
            return None;
        }
        let right = self.boundary(self.extreme_y.clamp(lo, hi), 1.0);
        let left = self.boundary((-self.extreme_y).clamp(lo, hi), -1.0);
        let first = -floor(-(self.mean[0] + left));
        let end = floor(self.mean[0] + right) + 1;
        (first < end).then_some((first, end))
    }

    /// The pixel rows `first..end` that the ellipse reaches, unclipped.
    pub fn rows(&self) -> (i64, i64) {
        if !self.is_proper() {
            return (-FURTHEST, FURTHEST);
        }
        let first = -floor(self.reach_y - self.mean[1]);
        (first, floor(self.mean[1] + self.reach_y) + 1)
    }

    /// Whether the ellipse reaches a pixel.
    pub fn reaches(&self, x: i64, y: i64) -> bool {
        let [dx, dy] = [x as f64 - self.mean[0], y as f64 - self.mean[1]];
        let [c0, c1, c2] = self.conic;
        !self.is_proper() || c0 * dx * dx + 2.0 * c1 * dx * dy + c2 * dy * dy <= self.level
    }

    fn boundary(&self, dy: f64, side: f64) -> f64 {
        let [c0, c1, _] = self.conic;
        (-c1 * dy + side * (c0 * self.level - self.det * dy * dy).max(0.0).sqrt()) / c0
    }
}

/// Columns beyond this are as good as this one, and what is added to them does not overflow.
const FURTHEST: i64 = i64::MAX / 4;

/// The largest integer not above `x`, saturating at [`FURTHEST`]. Unlike `f64::floor` it is no
/// library call on processors without SSE4.1, which a plain build targets.
fn floor(x: f64) -> i64 {
    let whole = (x as i64).clamp(-FURTHEST, FURTHEST);
    whole - i64::from(x < whole as f64)
}
