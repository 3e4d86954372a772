//! Oriented-box-against-tile test by separating axes (GSCore's shape-aware test).
//!
//! The box has half-lengths of 3 sigma along the eigenvectors of the covariance. The published
//! code takes eigenvectors from eigenvalues with a floor, which clips near-isotropic splats
//! (`powergs.md` §10 B1); here the angle is θ = ½ atan2(2b, a − d), without a floor.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;

use super::Splat;
use super::project::LANES;

/// The box of one splat, prepared for tests against tiles of one size.
#[derive(Debug, Clone, Copy)]
pub struct Obb {
    mean: [f32; 2],
    axis: [f32; 2],
    /// Reach of the box plus half a tile along image x and y.
    reach_image: [f32; 2],
    /// Half-lengths plus the reach of half a tile along the two box axes.
    reach_box: [f32; 2],
    tile: f32,
}

impl Obb {
    /// Prepares the box of `splat` for tiles of side `tile` pixels.
    #[inline]
    pub(crate) fn new(splat: &Splat, tile: u32) -> Obb {
        let [a, b, d] = splat.cov;
        let (axis, half) = (principal_axis(a, b, d), half_lengths(a, b, d));
        let [c, s] = axis.map(f32::abs);
        let tile = tile as f32;
        let half_tile = 0.5 * tile;
        let corner = half_tile * (c + s);
        Obb {
            mean: splat.mean,
            axis,
            reach_image: [
                half_tile + half[0] * c + half[1] * s,
                half_tile + half[0] * s + half[1] * c,
            ],
            reach_box: [half[0] + corner, half[1] + corner],
            tile,
        }
    }

    /// The test restricted to one row of tiles; `None` if the row is out of reach.
    #[inline]
    pub(crate) fn meets_row(&self, ty: u32) -> Option<ObbRow<'_>> {
        let dy = (ty as f32 + 0.5) * self.tile - self.mean[1];
        let [c, s] = self.axis;
        (dy.abs() <= self.reach_image[1]).then_some(ObbRow { obb: self, along: [dy * s, dy * c] })
    }
}

/// The boxes of sixteen splats, with the bits of [`Obb::new`].
#[derive(Debug, Clone, Copy)]
pub(super) struct ObbBlock {
    mean: [[f32; LANES]; 2],
    axis: [[f32; LANES]; 2],
    reach_image: [[f32; LANES]; 2],
    reach_box: [[f32; LANES]; 2],
    tile: f32,
}

impl ObbBlock {
    /// Prepares the boxes of splats with these means and covariances.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, mean: [f32x16<S>; 2], cov: [f32x16<S>; 3], tile: u32) -> Self {
        let ([cosine, sine], half) = (principal_axes(simd, cov), half_lengths_of(simd, cov));
        let (c, s) = (cosine.abs(), sine.abs());
        let tile = tile as f32;
        let half_tile = 0.5 * tile;
        let corner = (c + s) * half_tile;
        ObbBlock {
            mean: [mean[0].into(), mean[1].into()],
            axis: [cosine.into(), sine.into()],
            reach_image: [
                (half[0] * c + half_tile + half[1] * s).into(),
                (half[0] * s + half_tile + half[1] * c).into(),
            ],
            reach_box: [(half[0] + corner).into(), (half[1] + corner).into()],
            tile,
        }
    }

    /// One of the boxes.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Obb {
        let of = |pair: &[[f32; LANES]; 2]| [pair[0][lane], pair[1][lane]];
        Obb {
            mean: of(&self.mean),
            axis: of(&self.axis),
            reach_image: of(&self.reach_image),
            reach_box: of(&self.reach_box),
            tile: self.tile,
        }
    }
}

/// [`principal_axis`] of sixteen.
#[inline(always)]
fn principal_axes<S: Simd>(simd: S, [a, b, d]: [f32x16<S>; 3]) -> [f32x16<S>; 2] {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let (x, b_lanes): ([f32; LANES], [f32; LANES]) = ((a - d).into(), b.into());
    let mut h = [0.0; LANES];
    for (h, (x, b)) in h.iter_mut().zip(x.iter().zip(&b_lanes)) {
        let (x, y) = (f64::from(*x), 2.0 * f64::from(*b));
        *h = (x * x + y * y).sqrt() as f32;
    }
    let h = f32x16::simd_from(simd, h);
    let (cos2, sin2) = ((a - d) / h, b * 2.0 / h);
    let is_wide = cos2.simd_ge(zero);
    let major = (is_wide.select(one + cos2, one - cos2) * 0.5).sqrt();
    let is_turned = !is_wide & b.simd_lt(zero);
    let major = is_turned.select(-major, major);
    let minor = sin2 / (major * 2.0);
    let is_round = h.simd_eq(zero);
    let cosine = is_round.select(one, is_wide.select(major, minor));
    [cosine, is_round.select(zero, is_wide.select(minor, major))]
}

/// [`half_lengths`] of sixteen.
#[inline(always)]
fn half_lengths_of<S: Simd>(simd: S, [a, b, d]: [f32x16<S>; 3]) -> [f32x16<S>; 2] {
    let zero = f32x16::splat(simd, 0.0);
    let mid = (a + d) * 0.5;
    let root = (mid * mid - (a * d - b * b)).max_precise(zero).sqrt();
    let length = |square: f32x16<S>| square.max_precise(zero).sqrt() * 3.0;
    [length(mid + root), length(mid - root)]
}

/// One row of tiles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ObbRow<'a> {
    obb: &'a Obb,
    along: [f32; 2],
}

impl ObbRow<'_> {
    /// Whether the box meets tile `tx` of this row; touching counts. Every condition is monotonic
    /// in `tx`, so the tiles that are met form an interval, in floating point too.
    pub(crate) fn meets(&self, tx: u32) -> bool {
        let o = self.obb;
        let dx = (tx as f32 + 0.5) * o.tile - o.mean[0];
        let [c, s] = o.axis;
        dx.abs() <= o.reach_image[0]
            && (dx * c + self.along[0]).abs() <= o.reach_box[0]
            && (self.along[1] - dx * s).abs() <= o.reach_box[1]
    }

    /// [`ObbRow::interval`], of up to sixteen tiles at once.
    #[inline(always)]
    pub(crate) fn interval_by<S: Simd>(&self, simd: S, x0: u32, x1: u32) -> (u32, u32) {
        if x1 - x0 > 16 {
            return self.interval(x0, x1);
        }
        let o = self.obb;
        let [c, s] = o.axis;
        let within =
            |values: f32x16<S>, reach: f32| values.abs().simd_le(f32x16::splat(simd, reach));
        let tx = f32x16::from_fn(simd, |i| i as f32) + x0 as f32;
        let dx = (tx + 0.5) * o.tile - o.mean[0];
        let met = within(dx, o.reach_image[0])
            & within(dx * c + self.along[0], o.reach_box[0])
            & within(f32x16::splat(simd, self.along[1]) - dx * s, o.reach_box[1]);
        let met = met.to_bitmask() as u32 & ((1 << (x1 - x0)) - 1);
        if met == 0 { (x1, x1) } else { (x0 + met.trailing_zeros(), x0 + met.ilog2() + 1) }
    }

    /// The interval of tiles that are met within `x0..x1`, empty if none is.
    pub(crate) fn interval(&self, x0: u32, x1: u32) -> (u32, u32) {
        let mut lo = x0;
        while lo < x1 && !self.meets(lo) {
            lo += 1;
        }
        let mut hi = x1;
        while hi > lo && !self.meets(hi - 1) {
            hi -= 1;
        }
        (lo, hi)
    }
}

/// (cos θ, sin θ) of the major axis, θ = ½ atan2(2b, a − d), by half-angle formulas that do not
/// cancel. An isotropic splat has θ = 0.
#[inline]
pub(super) fn principal_axis(a: f32, b: f32, d: f32) -> [f32; 2] {
    // In double precision the squares of the largest covariances do not overflow.
    let (x, y) = (f64::from(a - d), 2.0 * f64::from(b));
    let h = (x * x + y * y).sqrt() as f32;
    if h == 0.0 {
        return [1.0, 0.0];
    }
    let (cos2, sin2) = ((a - d) / h, 2.0 * b / h);
    if cos2 >= 0.0 {
        let c = (0.5 * (1.0 + cos2)).sqrt();
        [c, sin2 / (2.0 * c)]
    } else {
        let s = (0.5 * (1.0 - cos2)).sqrt().copysign(if b < 0.0 { -1.0 } else { 1.0 });
        [sin2 / (2.0 * s), s]
    }
}

/// Three sigma along the major and the minor axis.
#[inline]
pub(super) fn half_lengths(a: f32, b: f32, d: f32) -> [f32; 2] {
    let mid = 0.5 * (a + d);
    let root = (mid * mid - (a * d - b * b)).max(0.0).sqrt();
    [3.0 * (mid + root).max(0.0).sqrt(), 3.0 * (mid - root).max(0.0).sqrt()]
}
