//! The gradient of one block of pixels by the splats that blended in it, front to back.
//!
//! With g the gradient by a pixel's colour, c the colour of a splat, T the transmittance before it
//! and B the part of the pixel's colour that comes from behind it (background included), the
//! gradient by ln α is s = α (T g·c − g·B / (1 − α)). g·B is what is left of g·pixel when the
//! contributions so far are taken off: no list per pixel and no reverse walk. Transmittances and
//! stops repeat the forward pass bit for bit.
//!
//! A row of 16 pixels is one vector. δx is the same in every row, so that three sums over rows per
//! column (s, s δy, s δy²) hold all six moments of s; they are taken once per splat and block.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use crate::blend::{BLOCK, BlendLine, BlendLines, Hit, Paint, alpha_of};
use powergs_frame::splat::gradient::PixelSums;
use powergs_frame::splat::{ALPHA_MAX, TRANSMITTANCE_MIN};

/// Hits whose paints are brought together first, so that cache misses overlap.
const BATCH: usize = 64;

/// Which sums are found.
pub trait UnblendKind: Copy + Send + Sync {
    /// Those that positions and shapes need.
    const GEOMETRY: bool;
}

/// All nine sums.
#[derive(Debug, Clone, Copy)]
pub struct Everything;
impl UnblendKind for Everything {
    const GEOMETRY: bool = true;
}

/// Opacity and colour; the others stay as they are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ColourOpacity;
impl UnblendKind for ColourOpacity {
    const GEOMETRY: bool = false;
}

/// One value per pixel of a row of a block.
type Pixels = [f32; BLOCK];

/// The state of a row of pixels. Side by side: where two of them are a page apart, processors may
/// take the one that is read for the one that was just written, and wait for it.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
struct PixelRow {
    /// 0 where the pixel stopped.
    transmittance: Pixels,
    /// g·B.
    behind: Pixels,
    /// g per channel.
    gradient: [Pixels; 3],
    /// α of the splat at hand, before it is clamped.
    alphas: Pixels,
}

/// The state of one block.
#[derive(Debug, Clone)]
pub(crate) struct UnblendBlock {
    rows: [PixelRow; BLOCK],
    origin: [f32; 2],
    /// α above this has no gradient.
    alpha_limit: f32,
}

impl UnblendBlock {
    /// A block in which α above `alpha_limit` has no gradient.
    pub(crate) fn new(alpha_limit: f32) -> UnblendBlock {
        UnblendBlock { rows: [PixelRow::default(); BLOCK], origin: [0.0; 2], alpha_limit }
    }

    /// Starts over with the top-left pixel at (x, y); no pixel takes part.
    pub(crate) fn reset(&mut self, x: u32, y: u32) {
        self.rows = [PixelRow::default(); BLOCK];
        self.origin = [x as f32, y as f32];
    }

    /// Lets the pixels of row `y` take part, given their final colours and gradients.
    pub(crate) fn load_row(&mut self, y: usize, colours: &[[f32; 3]], gradients: &[[f32; 3]]) {
        let row = &mut self.rows[y];
        for (x, (colour, gradient)) in colours.iter().zip(gradients).enumerate() {
            let [r, g, b] = *gradient;
            row.transmittance[x] = 1.0;
            row.gradient[0][x] = r;
            row.gradient[1][x] = g;
            row.gradient[2][x] = b;
            row.behind[x] = r * colour[0] + g * colour[1] + b * colour[2];
        }
    }
}

/// The list of a tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UnblendList<'a> {
    /// By run of the row: the rank of its splat.
    pub ranks: &'a [u32],
    /// The runs of its splats, front to back.
    pub runs: &'a [u32],
    /// Which of them blended.
    pub hits: &'a [Hit],
}

/// Adds to `sums` (by run) the sums of the splats of `list` that blended over `block`.
#[simd]
pub(crate) fn unblend<S: Simd, K: UnblendKind>(
    simd: S,
    kind: K,
    block: &mut UnblendBlock,
    list: UnblendList<'_>,
    paints: &[Paint],
    sums: &mut [PixelSums],
) {
    let iota: f32x16<S> = f32x16::from_fn(simd, |i| i as f32);
    let columns = iota + block.origin[0];
    let rows = iota + block.origin[1];
    let mut near = [Paint::default(); BATCH];
    for hits in list.hits.chunks(BATCH) {
        for (paint, hit) in near.iter_mut().zip(hits) {
            *paint = paints[list.ranks[list.runs[hit.at as usize] as usize] as usize];
        }
        for (hit, paint) in hits.iter().zip(&near) {
            let dx = columns - paint.mean[0];
            let found = unblend_splat(simd, kind, block, hit.rows, paint, rows, dx);
            let to = &mut sums[list.runs[hit.at as usize] as usize];
            if K::GEOMETRY { found.add_all(simd, dx, to) } else { found.add_some(to) }
        }
    }
}

/// Sums over the rows of a block, per column.
struct UnblendColumns<S: Simd> {
    /// Σ s, Σ s δy, Σ s δy².
    alpha: [f32x16<S>; 3],
    /// Σ α T g per channel.
    colour: [f32x16<S>; 3],
}

#[inline(always)]
fn unblend_splat<S: Simd, K: UnblendKind>(
    simd: S,
    _kind: K,
    block: &mut UnblendBlock,
    mut hit_rows: u32,
    paint: &Paint,
    rows: f32x16<S>,
    dx: f32x16<S>,
) -> UnblendColumns<S> {
    let lines = BlendLines::of(simd, paint, rows);
    let dys = BlendLine::of(rows - paint.mean[1]);
    let zero = f32x16::splat(simd, 0.0);
    let mut sums = UnblendColumns { alpha: [zero; 3], colour: [zero; 3] };
    // Exponentials first: they wait for nothing, so that many are in flight.
    let mut left = hit_rows;
    while left != 0 {
        let y = left.trailing_zeros() as usize & (BLOCK - 1);
        left &= left - 1;
        let power = f32x16::splat(simd, paint.quadratic[0])
            .mul_add(dx, lines.linear.at(simd, y))
            .mul_add(dx, lines.base.at(simd, y));
        alpha_of(simd, power, paint.log_opacity).store_slice(&mut block.rows[y].alphas);
    }
    while hit_rows != 0 {
        let y = hit_rows.trailing_zeros() as usize & (BLOCK - 1);
        hit_rows &= hit_rows - 1;
        let UnblendRow { weight, s, gradient } =
            unblend_row(simd, &mut block.rows[y], block.alpha_limit, paint);
        for (sum, g) in sums.colour.iter_mut().zip(gradient) {
            *sum = weight.mul_add(g, *sum);
        }
        sums.alpha[0] += s;
        if K::GEOMETRY {
            let dy = dys.at(simd, y);
            let sy = s * dy;
            sums.alpha[1] += sy;
            sums.alpha[2] = sy.mul_add(dy, sums.alpha[2]);
        }
    }
    sums
}

/// A splat in a row of pixels.
struct UnblendRow<S: Simd> {
    /// α T.
    weight: f32x16<S>,
    /// Gradient by ln α.
    s: f32x16<S>,
    /// g per channel.
    gradient: [f32x16<S>; 3],
}

/// Takes one splat off a row.
#[inline(always)]
fn unblend_row<S: Simd>(
    simd: S,
    row: &mut PixelRow,
    alpha_limit: f32,
    paint: &Paint,
) -> UnblendRow<S> {
    let exact = f32x16::from_slice(simd, &row.alphas);
    let zero = f32x16::splat(simd, 0.0);
    let t = f32x16::from_slice(simd, &row.transmittance);
    let alpha = exact.min(f32x16::splat(simd, ALPHA_MAX));
    let weight = alpha * t;
    let left = t - weight;
    // No for pixels that stop here and for those that did before: of 0 nothing is left.
    let goes_on = left.simd_ge(f32x16::splat(simd, TRANSMITTANCE_MIN));
    let weight = goes_on.select(weight, zero);
    goes_on.select(left, zero).store_slice(&mut row.transmittance);
    let r = f32x16::from_slice(simd, &row.gradient[0]);
    let g = f32x16::from_slice(simd, &row.gradient[1]);
    let b = f32x16::from_slice(simd, &row.gradient[2]);
    let [cr, cg, cb] = paint.colour;
    let gc = b.mul_add(cb, g.mul_add(cg, r * cr)) * weight;
    let behind = f32x16::from_slice(simd, &row.behind) - gc;
    behind.store_slice(&mut row.behind);
    // α is at most 0.99 here, so that nothing is divided by 0.
    let s = gc - behind * (alpha / (-alpha + 1.0));
    let flows = goes_on & exact.simd_le(f32x16::splat(simd, alpha_limit));
    UnblendRow { weight, s: flows.select(s, zero), gradient: [r, g, b] }
}

/// Adds halves so that the sum of all lanes of `a` and of `b` are those of the even and the odd
/// lanes of the result.
#[inline(always)]
fn fold<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    a.zip_low(b) + a.zip_high(b)
}

impl<S: Simd> UnblendColumns<S> {
    /// Adds all nine sums to `to`.
    #[inline(always)]
    fn add_all(self, _simd: S, dx: f32x16<S>, to: &mut PixelSums) {
        let [s, sy, syy] = self.alpha;
        let [r, g, b] = self.colour;
        let sx = s * dx;
        // Three folds leave eight sums, two lanes each, in this order.
        let even = fold(fold(s, sy * dx), fold(sy, r));
        let odd = fold(fold(sx, syy), fold(sx * dx, g));
        let (low, high) = fold(even, odd).split();
        let sums: [f32; 8] = (low + high).into();
        for (to, sum) in to.iter_mut().zip(sums) {
            *to += sum;
        }
        to[8] += b.reduce_sum();
    }

    /// Adds the sums of opacity and colour to `to`.
    #[inline(always)]
    fn add_some(self, to: &mut PixelSums) {
        to[0] += self.alpha[0].reduce_sum();
        for (to, sum) in to[6..].iter_mut().zip(self.colour) {
            *to += sum.reduce_sum();
        }
    }
}
