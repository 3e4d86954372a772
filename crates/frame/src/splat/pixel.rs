//! A splat pixel by pixel, in plain arithmetic: for pictures and counts in an order of one's own.

use super::obb::{half_lengths, principal_axis};
use super::{ALPHA_MAX, ALPHA_MIN, Ellipse, Splat};

/// The opacity of a splat by place.
#[derive(Debug, Clone, Copy)]
pub struct PixelAlpha {
    mean: [f32; 2],
    conic: [f32; 3],
    opacity: f32,
}

impl PixelAlpha {
    /// Of a splat; one whose covariance has no inverse is flat.
    pub fn of(splat: &Splat) -> PixelAlpha {
        let conic = splat.conic().unwrap_or_default();
        PixelAlpha { mean: splat.mean, conic, opacity: splat.opacity }
    }

    /// At a pixel, 0 to [`ALPHA_MAX`]; 0 where it does not reach [`ALPHA_MIN`] and nothing is
    /// blended.
    pub fn at(&self, x: u32, y: u32) -> f32 {
        let [dx, dy] = [x as f32 - self.mean[0], y as f32 - self.mean[1]];
        let [c0, c1, c2] = self.conic;
        let power = -0.5 * (c0 * dx * dx + c2 * dy * dy) - c1 * dx * dy;
        let alpha = (self.opacity * power.min(0.0).exp()).min(ALPHA_MAX);
        if f64::from(alpha) < ALPHA_MIN { 0.0 } else { alpha }
    }
}

/// The rows of an area of the image, `(x0, y0, x1, y1)`, half open, that the ellipse of a splat
/// reaches, each with the span of pixels in it: none where it reaches the row beside the area, or
/// between two pixels.
pub fn spans(
    splat: &Splat,
    (x0, y0, x1, y1): (u32, u32, u32, u32),
) -> impl Iterator<Item = (u32, Option<[u32; 2]>)> + use<> {
    let ellipse = Ellipse::of(splat);
    let rows = ellipse.map_or((0, 0), |ellipse| ellipse.rows());
    let first = rows.0.clamp(i64::from(y0), i64::from(y1)) as u32;
    let end = rows.1.clamp(i64::from(first), i64::from(y1)) as u32;
    (first..end).map(move |y| (y, ellipse.and_then(|ellipse| ellipse.span(y, [x0, x1]))))
}

/// The rows of an area of the image, `(x0, y0, x1, y1)`, half open, with pixel centres inside of
/// the oriented box of a splat, 3 sigma along both axes, each with the span of these.
pub fn box_spans(
    splat: &Splat,
    (x0, y0, x1, y1): (u32, u32, u32, u32),
) -> impl Iterator<Item = (u32, [u32; 2])> + use<> {
    let [a, b, d] = splat.cov;
    let [c, s] = principal_axis(a, b, d).map(f64::from);
    let half = half_lengths(a, b, d).map(f64::from);
    let [mx, my] = splat.mean.map(f64::from);
    let high = half[0] * s.abs() + half[1] * c.abs();
    let row = |y: f64| y.clamp(f64::from(y0), f64::from(y1)) as u32;
    let rows = row((my - high).ceil())..row((my + high).floor() + 1.0);
    rows.filter_map(move |y| {
        let dy = f64::from(y) - my;
        // |dx c + dy s| and |dy c - dx s| are at most the halves.
        let (mut low, mut high) = (f64::from(x0) - mx, f64::from(x1) - 1.0 - mx);
        for (slope, offset, half) in [(c, dy * s, half[0]), (-s, dy * c, half[1])] {
            if slope == 0.0 {
                high = if offset.abs() <= half { high } else { f64::NEG_INFINITY };
                continue;
            }
            let ends = [(-half - offset) / slope, (half - offset) / slope];
            low = low.max(ends[0].min(ends[1]));
            high = high.min(ends[0].max(ends[1]));
        }
        let first = (low + mx).ceil();
        let end = (high + mx).floor() + 1.0;
        (first < end).then_some((y, [first as u32, end as u32]))
    })
}
