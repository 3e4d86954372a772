//! Front-to-back blending of one 16x16 block of pixels (`powergs.md` §1.2).
//!
//! A row of 16 pixels is one vector. Per splat, one vector operation over the 16 *rows* finds which
//! of them can reach α = 1/255 at all; only those are evaluated. α is computed as an exponential of
//! base 2 with the opacity folded in: α = 2^p, p = A δx² + B δx δy + C δy² + log₂ o.
//!
//! A stopped pixel has its transmittance with a minus sign: it takes no part, and the loop over
//! rows need not branch where pixels stop.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, u32x16};
use fearless_simd_macros::simd;

use powergs_frame::splat::simd::{ROUND, exp2};
use powergs_frame::splat::{ALPHA_MAX, Splat, TRANSMITTANCE_MIN};

/// Side of a block, pixels.
pub(crate) const BLOCK: usize = 16;
/// log₂(1/255).
pub(super) const LOG2_ALPHA_MIN: f32 = -7.994_353_4;
/// The unit in which weights are added up, a power of two: whole numbers have the same sum in any
/// order.
pub(crate) const WEIGHT_STEP: f32 = 1.0 / 65536.0;
/// No stop.
pub(crate) const OPEN: u32 = u32::MAX;

/// Opacity and colour of a splat in one level of a foveated model.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Tint {
    pub(super) log_opacity: f32,
    pub(super) colour: [f32; 3],
}

impl Tint {
    /// One that blends nothing.
    pub(super) const NOTHING: Tint = Tint { log_opacity: f32::NEG_INFINITY, colour: [0.0; 3] };

    /// Of an opacity, 0 to 1, and a colour.
    #[inline]
    pub(crate) fn new(opacity: f32, colour: [f32; 3]) -> Tint {
        Tint { log_opacity: opacity.log2(), colour }
    }
}

/// A splat in the form that blending uses: one cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
pub struct Paint {
    pub(super) mean: [f32; 2],
    /// A, B, C: −½ log₂e times the quadratic form (B with both off-diagonals).
    pub(super) quadratic: [f32; 3],
    pub(super) log_opacity: f32,
    /// δx at which a row's exponent is largest, per δy.
    slope: f32,
    /// Rows whose largest exponent is below this cannot reach α = 1/255.
    row_threshold: f32,
    pub(super) colour: [f32; 3],
    /// In foveated frames: opacity and colour in the next level.
    pub(super) next: Tint,
    /// In foveated frames: which levels these are (`foveated::paints` knows how).
    pub(super) levels: u32,
}

impl Paint {
    /// Prepares a splat with a regular covariance (others touch no tile).
    pub(crate) fn new(splat: &Splat, colour: [f32; 3]) -> Paint {
        let [c0, c1, c2] = splat.conic().unwrap_or([1.0, 0.0, 1.0]);
        let k = -0.5 * std::f32::consts::LOG2_E;
        let cancel = c0 * c2 / (c0 * c2 - c1 * c1);
        let proper = c0 > 0.0 && cancel.is_finite() && cancel > 0.0;
        let margin = if proper { 1e-3 + 1e-5 * cancel } else { f32::INFINITY };
        Paint {
            mean: splat.mean,
            quadratic: [k * c0, 2.0 * k * c1, k * c2],
            log_opacity: splat.opacity.log2(),
            slope: -c1 / c0,
            row_threshold: LOG2_ALPHA_MIN - margin,
            colour,
            next: Tint::default(),
            levels: 0,
        }
    }

    /// What its level makes of it.
    #[inline(always)]
    pub(super) fn tint(&self) -> Tint {
        Tint { log_opacity: self.log_opacity, colour: self.colour }
    }

    /// The same splat in another level.
    #[inline(always)]
    pub(super) fn set_tint(&mut self, tint: Tint) {
        (self.log_opacity, self.colour) = (tint.log_opacity, tint.colour);
    }
}

/// Where the paints of the entries of a list come from.
pub(super) trait Palette {
    /// Copies the paints of up to [`BATCH`] entries side by side.
    fn fetch(&self, entries: &[Entry], near: &mut [Paint; BATCH]);
}

impl Palette for &[Paint] {
    #[inline(always)]
    fn fetch(&self, entries: &[Entry], near: &mut [Paint; BATCH]) {
        for (paint, entry) in near.iter_mut().zip(entries) {
            *paint = self[entry.rank as usize];
        }
    }
}

/// An entry of a tile's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// Depth rank of the splat.
    pub rank: u32,
    /// Position in the list of all accepted splats of the tile, skipped ones included.
    pub ordinal: u32,
}

/// An entry that blends in a block, for the backward pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hit {
    /// The entry.
    pub entry: Entry,
    /// Rows with a pixel in which α reaches 1/255 before it stops, one bit each.
    pub rows: u32,
}

/// One value per pixel of a block.
pub(super) type Rows = [[f32; BLOCK]; BLOCK];

/// One value per row of a block, where vectors of them are stored and loaded one by one: a store
/// across two cache lines cannot be forwarded.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Line([f32; BLOCK]);

impl Line {
    #[inline(always)]
    pub(super) fn of<S: Simd>(values: f32x16<S>) -> Line {
        Line(values.into())
    }

    /// The value of row `y`, in all lanes.
    #[inline(always)]
    pub(super) fn at<S: Simd>(&self, simd: S, y: usize) -> f32x16<S> {
        f32x16::splat(simd, self.0[y])
    }
}

/// The state of one block.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Block {
    /// Negative where the pixel stopped, 0 where it takes no part.
    transmittance: Rows,
    colour: [Rows; 3],
    /// α of the splat at hand, before it is clamped.
    pub(super) alphas: Rows,
    /// Entries with α ≥ 1/255 so far, the terminating one included.
    blended: [[u32; BLOCK]; BLOCK],
    heaviest: Rows,
    heaviest_rank: [[u32; BLOCK]; BLOCK],
    /// Entries at which pixels stopped (only if counted).
    stop: [[u32; BLOCK]; BLOCK],
    /// Rows with a pixel that has not stopped.
    pub(super) alive: u32,
    /// Rows with a pixel that has.
    stopped: u32,
    pub(super) origin: [f32; 2],
    /// Entries that blended, of all blocks since it was last emptied (only for [`Taped`]).
    pub hits: Vec<Hit>,
    /// Ranks of splats that blended, with the number of pixels or the sum of weights in steps of
    /// [`WEIGHT_STEP`]; emptied after each block (only for [`Tallied`] and [`Dominance`]).
    pub tally: Vec<(u32, u32)>,
}

impl Default for Block {
    fn default() -> Self {
        Self::new()
    }
}

impl Block {
    /// A block that takes no part yet.
    pub(crate) fn new() -> Block {
        Block {
            transmittance: [[0.0; BLOCK]; BLOCK],
            colour: [[[0.0; BLOCK]; BLOCK]; 3],
            alphas: [[0.0; BLOCK]; BLOCK],
            blended: [[0; BLOCK]; BLOCK],
            heaviest: [[0.0; BLOCK]; BLOCK],
            heaviest_rank: [[OPEN; BLOCK]; BLOCK],
            stop: [[OPEN; BLOCK]; BLOCK],
            alive: 0,
            stopped: 0,
            origin: [0.0; 2],
            hits: Vec::new(),
            tally: Vec::new(),
        }
    }

    /// Starts over with the top-left pixel at (x, y), of which `width` x `height` pixels take part.
    pub(crate) fn reset<R: Record>(&mut self, x: u32, y: u32, width: usize, height: usize) {
        self.transmittance = [[0.0; BLOCK]; BLOCK];
        for row in self.transmittance.iter_mut().take(height) {
            row[..width].fill(1.0);
        }
        self.colour = [[[0.0; BLOCK]; BLOCK]; 3];
        self.alive = (1 << height) - 1;
        self.stopped = 0;
        self.origin = [x as f32, y as f32];
        if R::COUNT {
            self.blended = [[0; BLOCK]; BLOCK];
            self.stop = [[OPEN; BLOCK]; BLOCK];
        }
        if R::DOMINANCE {
            self.heaviest = [[0.0; BLOCK]; BLOCK];
            self.heaviest_rank = [[OPEN; BLOCK]; BLOCK];
        }
    }

    /// Takes pixels of row `y` out, one bit each, before anything is blended: they stay black and
    /// see no background.
    pub(crate) fn leave_out(&mut self, y: usize, lanes: u32) {
        for (x, t) in self.transmittance[y].iter_mut().enumerate() {
            if lanes >> x & 1 == 1 {
                *t = 0.0;
            }
        }
        if self.transmittance[y].iter().all(|&t| t == 0.0) {
            self.alive &= !(1 << y);
        }
    }

    /// Channel `c` of row `y` of the image over `background`.
    #[inline(always)]
    pub(super) fn row(&self, y: usize, c: usize, background: f32) -> [f32; BLOCK] {
        let mut row = [0.0; BLOCK];
        for (x, value) in row.iter_mut().enumerate() {
            let t = self.transmittance[y][x].abs();
            *value = self.colour[c][y][x] + t * background;
        }
        row
    }

    /// Writes row `y` of the image over `background` to `out`.
    pub(crate) fn write_row(&self, y: usize, background: [f32; 3], out: &mut [[f32; 3]]) {
        for (c, &behind) in background.iter().enumerate() {
            let row = self.row(y, c, behind);
            for (x, pixel) in out.iter_mut().enumerate() {
                pixel[c] = row[x];
            }
        }
    }

    /// The list entries at which the pixels of row `y` stopped, or [`OPEN`]; `None` if none did.
    pub(crate) fn stops(&self, y: usize) -> Option<&[u32; BLOCK]> {
        (self.stopped >> y & 1 == 1).then_some(&self.stop[y])
    }

    /// Entries that reached α ≥ 1/255 at the pixels of row `y`, the terminating one included.
    pub(crate) fn blended(&self, y: usize) -> &[u32; BLOCK] {
        &self.blended[y]
    }

    /// Ranks of the splats with the largest α·T at the pixels of row `y` (the first of equals), or
    /// [`OPEN`].
    pub(crate) fn heaviest(&self, y: usize) -> &[u32; BLOCK] {
        &self.heaviest_rank[y]
    }

    /// Takes note of the pixels in `rows`, one bit each, that list entry `at` has stopped.
    #[inline(always)]
    pub(super) fn note_stops<S: Simd, R: Record>(&mut self, simd: S, mut rows: u32, at: u32) {
        let zero = f32x16::splat(simd, 0.0);
        self.stopped |= rows;
        while rows != 0 {
            let y = rows.trailing_zeros() as usize & (BLOCK - 1);
            rows &= rows - 1;
            let t = f32x16::from_slice(simd, &self.transmittance[y]);
            if R::COUNT {
                let old = u32x16::from_slice(simd, &self.stop[y]);
                let new = t.simd_lt(zero) & old.simd_eq(u32x16::splat(simd, OPEN));
                new.select(u32x16::splat(simd, at), old).store_slice(&mut self.stop[y]);
            }
            if !t.simd_gt(zero).any_true() {
                self.alive &= !(1 << y);
            }
        }
    }
}

/// What is recorded besides the image.
pub trait Record: Copy + Send + Sync {
    /// Count entries that reach α ≥ 1/255.
    const COUNT: bool;
    /// Find the heaviest splat of every pixel.
    const DOMINANCE: bool;
    /// Keep the entries that blend, with their rows.
    const HITS: bool;
    /// Count the pixels that each splat is blended into.
    const PIXELS: bool = false;
    /// Add up the weights with which each splat is blended.
    const WEIGHTS: bool = false;
}

/// The image alone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImageOnly;
impl Record for ImageOnly {
    const COUNT: bool = false;
    const DOMINANCE: bool = false;
    const HITS: bool = false;
}

/// The counters of a trace.
#[derive(Debug, Clone, Copy)]
pub struct Counted;
impl Record for Counted {
    const COUNT: bool = true;
    const DOMINANCE: bool = false;
    const HITS: bool = false;
}

/// The counters of a trace and those that pruning needs.
#[derive(Debug, Clone, Copy)]
pub struct Dominance;
impl Record for Dominance {
    const COUNT: bool = true;
    const DOMINANCE: bool = true;
    const HITS: bool = false;
    const WEIGHTS: bool = true;
}

/// The records of the backward pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taped;
impl Record for Taped {
    const COUNT: bool = false;
    const DOMINANCE: bool = false;
    const HITS: bool = true;
}

/// The pixels that each splat is blended into.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tallied;
impl Record for Tallied {
    const COUNT: bool = false;
    const DOMINANCE: bool = false;
    const HITS: bool = false;
    const PIXELS: bool = true;
}

/// Entries whose paints are brought together before they are blended, so that cache misses overlap.
pub(super) const BATCH: usize = 64;

/// Blends `entries` into `block`.
#[simd]
pub(super) fn blend<S: Simd, R: Record, P: Palette>(
    simd: S,
    record: R,
    block: &mut Block,
    entries: &[Entry],
    palette: P,
) {
    let mut near = [Paint::default(); BATCH];
    for (batch, entries) in entries.chunks(BATCH).enumerate() {
        palette.fetch(entries, &mut near);
        blend_batch(simd, record, block, batch * BATCH, entries, &near);
        if block.alive == 0 {
            return;
        }
    }
}

/// Blends up to [`BATCH`] entries; `first` is the position of the first one.
#[inline(always)]
fn blend_batch<S: Simd, R: Record>(
    simd: S,
    record: R,
    block: &mut Block,
    first: usize,
    entries: &[Entry],
    near: &[Paint; BATCH],
) {
    let iota: f32x16<S> = f32x16::from_fn(simd, |i| i as f32);
    let columns = iota + block.origin[0];
    let rows = iota + block.origin[1];
    for (at, (entry, paint)) in entries.iter().zip(near).enumerate() {
        let lines = Lines::of(simd, paint, rows, block.origin[0]);
        let brush = Brush { tint: paint.tint(), rank: entry.rank };
        let mut touched = lines.touched & block.alive;
        if touched == 0 {
            continue;
        }
        let dx = columns - paint.mean[0];
        // Exponentials first: they wait for nothing, so that many are in flight.
        let mut left = touched;
        while left != 0 {
            let y = left.trailing_zeros() as usize & (BLOCK - 1);
            left &= left - 1;
            let power = f32x16::splat(simd, paint.quadratic[0])
                .mul_add(dx, lines.linear.at(simd, y))
                .mul_add(dx, lines.base.at(simd, y));
            alpha_of(simd, power, paint.log_opacity).store_slice(&mut block.alphas[y]);
        }
        let (mut hit_rows, mut stop_rows, mut pixels, mut weight) = (0, 0, 0, 0.0);
        while touched != 0 {
            let y = touched.trailing_zeros() as usize & (BLOCK - 1);
            touched &= touched - 1;
            let row = blend_row(simd, record, block, y, &brush);
            stop_rows |= u32::from(row.stops) << y;
            if R::HITS {
                hit_rows |= u32::from(row.hit) << y;
            }
            if R::PIXELS {
                pixels += row.pixels;
            }
            if R::WEIGHTS {
                weight += row.weight;
            }
        }
        if stop_rows != 0 {
            block.note_stops::<S, R>(simd, stop_rows, (first + at) as u32);
        }
        if R::HITS && hit_rows != 0 {
            block.hits.push(Hit { entry: *entry, rows: hit_rows });
        }
        if R::PIXELS && pixels != 0 {
            block.tally.push((entry.rank, pixels));
        }
        if R::WEIGHTS && weight > 0.0 {
            block.tally.push((entry.rank, (weight / WEIGHT_STEP) as u32));
        }
        if block.alive == 0 {
            return;
        }
    }
}

/// The exponent of one splat on the 16 rows of a block, as far as its opacity has no part in it.
pub(super) struct Form<S: Simd> {
    dy: f32x16<S>,
    /// C δy².
    square: f32x16<S>,
    /// B δy.
    pub(super) linear: f32x16<S>,
    /// δx of the pixel of the block at which a row is largest, and what it adds to the base
    /// there.
    peak: f32x16<S>,
    along: f32x16<S>,
}

impl<S: Simd> Form<S> {
    #[inline(always)]
    pub(super) fn of(simd: S, paint: &Paint, rows: f32x16<S>, left: f32) -> Form<S> {
        let [a, b, c] = paint.quadratic;
        let dy = rows - paint.mean[1];
        let linear = dy * b;
        // The pixel nearest to the peak of the row: there the exponent has the bits that blending
        // gives it, so that rows between whose pixels the splat falls are not touched.
        let column = dy
            .mul_add(f32x16::splat(simd, paint.slope), f32x16::splat(simd, paint.mean[0]))
            .max(f32x16::splat(simd, left))
            .min(f32x16::splat(simd, left + (BLOCK - 1) as f32));
        let peak = ((column + ROUND) - ROUND) - paint.mean[0];
        let along = f32x16::splat(simd, a).mul_add(peak, linear);
        Form { dy, square: dy * c, linear, peak, along }
    }

    /// The exponent at δx = 0.
    #[inline(always)]
    pub(super) fn base(&self, simd: S, log_opacity: f32) -> f32x16<S> {
        self.square.mul_add(self.dy, f32x16::splat(simd, log_opacity))
    }

    /// Rows in which α reaches 1/255 with this base, and few others.
    #[inline(always)]
    pub(super) fn touched(&self, simd: S, paint: &Paint, base: f32x16<S>) -> u32 {
        let largest = self.along.mul_add(self.peak, base);
        !(largest.simd_lt(f32x16::splat(simd, paint.row_threshold)).to_bitmask() as u32)
    }
}

/// The exponent of one splat on the 16 rows of a block: `(a δx + linear) δx + base`.
pub(super) struct Lines {
    pub(super) base: Line,
    pub(super) linear: Line,
    /// Rows that can reach α = 1/255.
    touched: u32,
}

impl Lines {
    #[inline(always)]
    pub(super) fn of<S: Simd>(simd: S, paint: &Paint, rows: f32x16<S>, left: f32) -> Lines {
        let form = Form::of(simd, paint, rows, left);
        let base = form.base(simd, paint.log_opacity);
        let touched = form.touched(simd, paint, base);
        Lines { base: Line::of(base), linear: Line::of(form.linear), touched }
    }
}

/// What is blended into a row.
pub(super) struct Brush {
    pub(super) tint: Tint,
    /// Depth rank of the splat.
    pub(super) rank: u32,
}

/// The effect of a splat on a row.
pub(super) struct RowOutcome {
    /// Whether α reached 1/255 in any pixel (only for [`Taped`]).
    hit: bool,
    /// Pixels whose colour it goes into: not those that stop at it (only for [`Tallied`]).
    pixels: u32,
    /// The sum of its weights in them (only for [`Dominance`]).
    weight: f32,
    /// Whether any pixel stops here.
    pub(super) stops: bool,
}

/// α of exponents, 0 where they blend nothing; not yet clamped.
#[inline(always)]
pub(super) fn alpha_of<S: Simd>(simd: S, power: f32x16<S>, log_opacity: f32) -> f32x16<S> {
    let threshold = f32x16::splat(simd, LOG2_ALPHA_MIN);
    let hit = power.simd_ge(threshold) & power.simd_le(f32x16::splat(simd, log_opacity));
    hit.select(exp2(simd, power.max(threshold)), f32x16::splat(simd, 0.0))
}

/// Blends one splat into row `y`, with the alphas of the block.
#[inline(always)]
pub(super) fn blend_row<S: Simd, R: Record>(
    simd: S,
    _record: R,
    block: &mut Block,
    y: usize,
    brush: &Brush,
) -> RowOutcome {
    let zero = f32x16::splat(simd, 0.0);
    let alpha = f32x16::from_slice(simd, &block.alphas[y]).min(f32x16::splat(simd, ALPHA_MAX));
    let t = f32x16::from_slice(simd, &block.transmittance[y]);
    let hit = alpha.simd_gt(zero) & t.simd_gt(zero);
    let mut weight = hit.select(alpha * t, zero);
    if R::COUNT {
        let n = u32x16::from_slice(simd, &block.blended[y]);
        hit.select(n + 1, n).store_slice(&mut block.blended[y]);
    }
    let left = t - weight;
    let stops = hit & left.simd_lt(f32x16::splat(simd, TRANSMITTANCE_MIN));
    weight = stops.select(zero, weight);
    let left = stops.select(-t, left);
    left.store_slice(&mut block.transmittance[y]);
    for channel in 0..3 {
        let sum = f32x16::from_slice(simd, &block.colour[channel][y]);
        weight.mul_add(brush.tint.colour[channel], sum).store_slice(&mut block.colour[channel][y]);
    }
    if R::DOMINANCE {
        let best = f32x16::from_slice(simd, &block.heaviest[y]);
        let heavier = weight.simd_gt(best);
        heavier.select(weight, best).store_slice(&mut block.heaviest[y]);
        let owner = u32x16::from_slice(simd, &block.heaviest_rank[y]);
        heavier
            .select(u32x16::splat(simd, brush.rank), owner)
            .store_slice(&mut block.heaviest_rank[y]);
    }
    let pixels = if R::PIXELS { (hit & !stops).to_bitmask().count_ones() } else { 0 };
    let weight = if R::WEIGHTS { <[f32; BLOCK]>::from(weight).iter().sum() } else { 0.0 };
    RowOutcome { hit: R::HITS && hit.any_true(), pixels, weight, stops: stops.any_true() }
}
