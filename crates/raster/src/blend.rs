//! Front-to-back blending of one 16x16 block of pixels (`powergs.md` §1.2).
//!
//! A row of 16 pixels is one vector. Per splat, one vector operation over the 16 *rows* finds which
//! of them can reach α = 1/255 at all; only those are evaluated. α is computed as an exponential of
//! base 2 with the opacity folded in: α = 2^p, p = A δx² + B δx δy + C δy² + log₂ o.
//!
//! Splats come in batches. Each row of pixels goes through the splats of a batch that can reach it,
//! with its state in registers. A stopped pixel has its transmittance with a minus sign: it takes
//! no part.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask16x32, mask32x16, u16x32, u32x16};
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
        // The more of the determinant cancels, the less exact is the peak of a row; a row that
        // reaches 1/255 must never be missed, one too many costs time only.
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
    /// Copies the paints of up to [`BATCH`] splats side by side. They are told by their ranks, or
    /// by other numbers if the palette and whoever reads the records agree.
    fn fetch(&self, ranks: &[u32], near: &mut [Paint; BATCH]);
}

impl Palette for &[Paint] {
    #[inline(always)]
    fn fetch(&self, ranks: &[u32], near: &mut [Paint; BATCH]) {
        for (paint, &rank) in near.iter_mut().zip(ranks) {
            *paint = self[rank as usize];
        }
    }
}

/// An entry that blends in a block, for the backward pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hit {
    /// Its position in the list of the tile.
    pub at: u32,
    /// Rows with a pixel in which α reaches 1/255 before it stops, one bit each.
    pub rows: u32,
}

/// One value per pixel of a block.
pub(super) type BlendRows = [[f32; BLOCK]; BLOCK];

/// One value per row of a block, where vectors of them are stored and loaded one by one: a store
/// across two cache lines cannot be forwarded.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct BlendLine([f32; BLOCK]);

impl BlendLine {
    #[inline(always)]
    pub(super) fn of<S: Simd>(values: f32x16<S>) -> BlendLine {
        BlendLine(values.into())
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
pub struct BlendBlock {
    /// Negative where the pixel stopped, 0 where it takes no part.
    transmittance: BlendRows,
    colour: [BlendRows; 3],
    /// Of the batch at hand.
    pub(super) strokes: Strokes,
    /// Entries with α ≥ 1/255 so far, the terminating one included.
    blended: [[u32; BLOCK]; BLOCK],
    heaviest: BlendRows,
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

impl Default for BlendBlock {
    fn default() -> Self {
        Self::new()
    }
}

impl BlendBlock {
    /// A block that takes no part yet.
    pub(crate) fn new() -> BlendBlock {
        BlendBlock {
            transmittance: [[0.0; BLOCK]; BLOCK],
            colour: [[[0.0; BLOCK]; BLOCK]; 3],
            strokes: Strokes::new(),
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
    pub(crate) fn reset<R: BlendRecord>(&mut self, x: u32, y: u32, width: usize, height: usize) {
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

    /// Row `y` of the image over `background`, by channel.
    #[inline(always)]
    pub(super) fn row<S: Simd>(
        &self,
        simd: S,
        y: usize,
        background: [f32; 3],
    ) -> [[f32; BLOCK]; 3] {
        let t = f32x16::from_slice(simd, &self.transmittance[y]).abs();
        [0, 1, 2].map(|c| (f32x16::from_slice(simd, &self.colour[c][y]) + t * background[c]).into())
    }

    /// Writes row `y` of the image over `background` to `out`.
    #[inline(always)]
    pub(crate) fn write_row<S: Simd>(
        &self,
        simd: S,
        y: usize,
        background: [f32; 3],
        out: &mut [[f32; 3]],
    ) {
        let [r, g, b] = self.row(simd, y, background);
        let pixel = |x: usize| [r[x], g[x], b[x]];
        // A whole row needs no loop.
        match <&mut [[f32; 3]; BLOCK]>::try_from(&mut *out) {
            Ok(row) => *row = std::array::from_fn(pixel),
            Err(_) => (0..).zip(out).for_each(|(x, out)| *out = pixel(x)),
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

    /// Finds the strokes of up to [`BATCH`] splats.
    #[inline(always)]
    fn set_strokes<S: Simd>(&mut self, simd: S, near: &[Paint], tint: impl Fn(usize) -> Tint) {
        let rows = f32x16::from_fn(simd, |i| i as f32) + self.origin[1];
        let (first, last) = self.open_columns(simd);
        let strokes = &mut self.strokes;
        strokes.touched = [0; BATCH];
        for (at, paint) in near.iter().enumerate() {
            let form = BlendForm::of(simd, paint, rows);
            let base = form.base(simd, tint(at).log_opacity);
            strokes.touched[at] = form.touched(simd, paint, base, first, last) as u16;
            strokes.base[at] = BlendLine::of(base);
            strokes.linear[at] = BlendLine::of(form.linear);
        }
    }

    /// The first and the last column of each row in which a pixel has not stopped.
    #[inline(always)]
    fn open_columns<S: Simd>(&self, simd: S) -> (f32x16<S>, f32x16<S>) {
        let (mut first, mut last) = ([0.0; BLOCK], [0.0; BLOCK]);
        for (y, row) in self.transmittance.iter().enumerate() {
            let open = f32x16::from_slice(simd, row).simd_gt(f32x16::splat(simd, 0.0));
            // Sentinels keep both counts defined where all pixels have stopped.
            let open = open.to_bitmask() as u32 | 1 << BLOCK;
            first[y] = open.trailing_zeros() as f32;
            last[y] = (open & !(1 << BLOCK) | 1).ilog2() as f32;
        }
        let origin = self.origin[0];
        (f32x16::simd_from(simd, first) + origin, f32x16::simd_from(simd, last) + origin)
    }

    /// Takes note of pixels of row `y` that list entry `at` stops.
    #[inline(always)]
    fn note_stops<S: Simd, R: BlendRecord>(
        &mut self,
        simd: S,
        y: usize,
        stops: mask32x16<S>,
        at: u32,
    ) {
        self.stopped |= 1 << y;
        if R::COUNT {
            let old = u32x16::from_slice(simd, &self.stop[y]);
            stops.select(u32x16::splat(simd, at), old).store_slice(&mut self.stop[y]);
        }
    }
}

/// What is recorded besides the image.
pub trait BlendRecord: Copy + Send + Sync {
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
impl BlendRecord for ImageOnly {
    const COUNT: bool = false;
    const DOMINANCE: bool = false;
    const HITS: bool = false;
}

/// The counters of a trace.
#[derive(Debug, Clone, Copy)]
pub struct BlendCounted;
impl BlendRecord for BlendCounted {
    const COUNT: bool = true;
    const DOMINANCE: bool = false;
    const HITS: bool = false;
}

/// The counters of a trace and those that pruning needs.
#[derive(Debug, Clone, Copy)]
pub struct Dominance;
impl BlendRecord for Dominance {
    const COUNT: bool = true;
    const DOMINANCE: bool = true;
    const HITS: bool = false;
    const WEIGHTS: bool = true;
}

/// The records of the backward pass.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taped;
impl BlendRecord for Taped {
    const COUNT: bool = false;
    const DOMINANCE: bool = false;
    const HITS: bool = true;
}

/// The pixels that each splat is blended into.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tallied;
impl BlendRecord for Tallied {
    const COUNT: bool = false;
    const DOMINANCE: bool = false;
    const HITS: bool = false;
    const PIXELS: bool = true;
}

/// Entries whose paints are brought together before they are blended, so that cache misses overlap.
pub(super) const BATCH: usize = 64;

/// Blends the splats of a list of ranks into `block`.
#[simd]
pub(super) fn blend<S: Simd, R: BlendRecord, P: Palette>(
    simd: S,
    record: R,
    block: &mut BlendBlock,
    ranks: &[u32],
    palette: P,
) {
    let mut near = [Paint::default(); BATCH];
    for (batch, ranks) in ranks.chunks(BATCH).enumerate() {
        palette.fetch(ranks, &mut near);
        blend_batch(simd, record, block, batch * BATCH, ranks, &near, |at| near[at].tint());
        if block.alive == 0 {
            return;
        }
    }
}

/// What is found out about each entry of a batch while its rows are blended.
struct Findings {
    /// Entries that reach α = 1/255 in each row, one bit each (only for [`Taped`]).
    hits: [u64; BLOCK],
    /// Pixels that each entry goes into: not those that stop at it (only for [`Tallied`]).
    pixels: [u32; BATCH],
    /// The sum of the weights of each entry (only for [`Dominance`]).
    weights: [f32; BATCH],
}

/// Blends up to [`BATCH`] entries; `first` is the position of the first one, `tint` says what each
/// blends. One row of pixels after the other, so that its state stays in registers.
#[inline(always)]
pub(super) fn blend_batch<S: Simd, R: BlendRecord>(
    simd: S,
    record: R,
    block: &mut BlendBlock,
    first: usize,
    ranks: &[u32],
    near: &[Paint; BATCH],
    tint: impl Fn(usize) -> Tint,
) {
    if block.alive == 0 {
        return;
    }
    block.set_strokes(simd, &near[..ranks.len()], &tint);
    let by_row = block.strokes.by_row(simd);
    let mut findings = Findings { hits: [0; BLOCK], pixels: [0; BATCH], weights: [0.0; BATCH] };
    let mut alive = block.alive;
    while alive != 0 {
        // The mask says to the compiler that the index is in range.
        let y = alive.trailing_zeros() as usize & (BLOCK - 1);
        alive &= alive - 1;
        if by_row[y] != 0 {
            let row = BlendRow { y, touching: by_row[y], first: first as u32 };
            blend_row(simd, record, block, row, (ranks, near), &tint, &mut findings);
        }
    }
    if R::HITS {
        let rows = by_entry(simd, &findings.hits);
        for (at, rows) in (first as u32..).zip(rows).filter(|(_, rows)| *rows != 0) {
            block.hits.push(Hit { at, rows: u32::from(rows) });
        }
    }
    for (at, &rank) in ranks.iter().enumerate() {
        if R::PIXELS && findings.pixels[at] != 0 {
            block.tally.push((rank, findings.pixels[at]));
        }
        if R::WEIGHTS && findings.weights[at] > 0.0 {
            block.tally.push((rank, (findings.weights[at] / WEIGHT_STEP) as u32));
        }
    }
}

/// The exponents of the splats of a batch on the rows of a block, `(a δx + linear) δx + base`, and
/// which rows they can reach.
#[derive(Debug, Clone)]
pub(super) struct Strokes {
    base: [BlendLine; BATCH],
    linear: [BlendLine; BATCH],
    /// Rows in which each can reach α = 1/255, one bit each.
    touched: [u16; BATCH],
}

impl Strokes {
    fn new() -> Strokes {
        let line = BlendLine([0.0; BLOCK]);
        Strokes { base: [line; BATCH], linear: [line; BATCH], touched: [0; BATCH] }
    }

    /// The entries that touch each row, one bit each.
    #[inline(always)]
    fn by_row<S: Simd>(&self, simd: S) -> [u64; BLOCK] {
        let (low, high) = self.touched.split_at(BATCH / 2);
        let (low, high) = (u16x32::from_slice(simd, low), u16x32::from_slice(simd, high));
        // A function of the standard library would be one without the instruction set.
        let mut entries = [0; BLOCK];
        for (y, entries) in entries.iter_mut().enumerate() {
            let bit = u16x32::splat(simd, 1 << y);
            let has = |rows: u16x32<S>| (rows & bit).simd_eq(bit).to_bitmask();
            *entries = has(low) | has(high) << (BATCH / 2);
        }
        entries
    }
}

/// The rows that have each entry, one bit each, of the entries that each row has.
#[inline(always)]
fn by_entry<S: Simd>(simd: S, by_row: &[u64; BLOCK]) -> [u16; BATCH] {
    let zero = u16x32::splat(simd, 0);
    let (mut low, mut high) = (zero, zero);
    for (y, entries) in by_row.iter().enumerate() {
        let bit = u16x32::splat(simd, 1 << y);
        let of = |bits: u64| mask16x32::from_bitmask(simd, bits).select(bit, zero);
        low |= of(entries & u64::from(u32::MAX));
        high |= of(entries >> (BATCH / 2));
    }
    let mut rows = [0; BATCH];
    low.store_slice(&mut rows[..BATCH / 2]);
    high.store_slice(&mut rows[BATCH / 2..]);
    rows
}

/// The exponent of one splat on the 16 rows of a block, as far as its opacity has no part in it.
struct BlendForm<S: Simd> {
    dy: f32x16<S>,
    /// C δy².
    square: f32x16<S>,
    /// B δy.
    linear: f32x16<S>,
}

impl<S: Simd> BlendForm<S> {
    #[inline(always)]
    fn of(_simd: S, paint: &Paint, rows: f32x16<S>) -> BlendForm<S> {
        let [_, b, c] = paint.quadratic;
        let dy = rows - paint.mean[1];
        BlendForm { dy, square: dy * c, linear: dy * b }
    }

    /// The exponent at δx = 0.
    #[inline(always)]
    fn base(&self, simd: S, log_opacity: f32) -> f32x16<S> {
        self.square.mul_add(self.dy, f32x16::splat(simd, log_opacity))
    }

    /// Rows in which α reaches 1/255 with this base between two columns each, and few others.
    #[inline(always)]
    fn touched(
        &self,
        simd: S,
        paint: &Paint,
        base: f32x16<S>,
        first: f32x16<S>,
        last: f32x16<S>,
    ) -> u32 {
        // The pixel nearest to the peak of the row: there the exponent has the bits that blending
        // gives it, so that rows between whose pixels the splat falls are not touched.
        let mean = f32x16::splat(simd, paint.mean[0]);
        let column = self.dy.mul_add(f32x16::splat(simd, paint.slope), mean).max(first).min(last);
        let peak = ((column + ROUND) - ROUND) - mean;
        let along = f32x16::splat(simd, paint.quadratic[0]).mul_add(peak, self.linear);
        let largest = along.mul_add(peak, base);
        !(largest.simd_lt(f32x16::splat(simd, paint.row_threshold)).to_bitmask() as u32)
    }
}

/// The exponent of one splat on the 16 rows of a block: `(a δx + linear) δx + base`.
pub(super) struct BlendLines {
    pub(super) base: BlendLine,
    pub(super) linear: BlendLine,
}

impl BlendLines {
    #[inline(always)]
    pub(super) fn of<S: Simd>(simd: S, paint: &Paint, rows: f32x16<S>) -> BlendLines {
        let form = BlendForm::of(simd, paint, rows);
        BlendLines {
            base: BlendLine::of(form.base(simd, paint.log_opacity)),
            linear: BlendLine::of(form.linear),
        }
    }
}

/// α of exponents, 0 where they blend nothing; not yet clamped.
#[inline(always)]
pub(super) fn alpha_of<S: Simd>(simd: S, power: f32x16<S>, log_opacity: f32) -> f32x16<S> {
    let threshold = f32x16::splat(simd, LOG2_ALPHA_MIN);
    let hit = power.simd_ge(threshold) & power.simd_le(f32x16::splat(simd, log_opacity));
    // What the power of two is outside of its range does not matter.
    hit.select(exp2(simd, power), f32x16::splat(simd, 0.0))
}

/// A row of a block and what is blended into it.
struct BlendRow {
    y: usize,
    /// The entries of the batch that touch it, one bit each; at least one.
    touching: u64,
    /// Position of the first entry of the batch.
    first: u32,
}

/// Blends the entries of a batch that touch a row.
/// That a pixel stops is rare enough for a branch.
#[inline(always)]
fn blend_row<S: Simd, R: BlendRecord>(
    simd: S,
    _record: R,
    block: &mut BlendBlock,
    BlendRow { y, touching, first }: BlendRow,
    (ranks, near): (&[u32], &[Paint; BATCH]),
    tint: impl Fn(usize) -> Tint,
    findings: &mut Findings,
) {
    let zero = f32x16::splat(simd, 0.0);
    let columns = f32x16::from_fn(simd, |i| i as f32) + block.origin[0];
    let mut t = f32x16::from_slice(simd, &block.transmittance[y]);
    // Nothing is as large as the threshold of a pixel that stopped.
    let never = f32x16::splat(simd, f32::INFINITY);
    let mut threshold = t.simd_gt(zero).select(f32x16::splat(simd, LOG2_ALPHA_MIN), never);
    let mut colour = [0, 1, 2].map(|c| f32x16::from_slice(simd, &block.colour[c][y]));
    // In single precision, which is exact, and adds in fewer steps where a mask says so.
    let mut blended = zero;
    let mut heaviest = f32x16::from_slice(simd, &block.heaviest[y]);
    let mut owner = u32x16::from_slice(simd, &block.heaviest_rank[y]);
    let (mut left, mut hits) = (touching, 0);
    while left != 0 {
        let at = left.trailing_zeros() as usize & (BATCH - 1);
        left &= left - 1;
        let (paint, tint) = (&near[at], tint(at));
        let dx = columns - paint.mean[0];
        let power = f32x16::splat(simd, paint.quadratic[0])
            .mul_add(dx, block.strokes.linear[at].at(simd, y))
            .mul_add(dx, block.strokes.base[at].at(simd, y));
        // Above the opacity the form would be positive: the reference skips such pixels, too.
        let hit = power.simd_ge(threshold) & power.simd_le(f32x16::splat(simd, tint.log_opacity));
        let alpha = exp2(simd, power);
        let colours = tint.colour.map(|channel| f32x16::splat(simd, channel));
        let mut weight = hit.select(alpha.min(f32x16::splat(simd, ALPHA_MAX)) * t, zero);
        let mut rest = t - weight;
        let stops = hit & rest.simd_lt(f32x16::splat(simd, TRANSMITTANCE_MIN));
        if R::COUNT {
            blended = hit.select(blended + 1.0, blended);
        }
        if R::HITS {
            hits |= u64::from(hit.any_true()) << at;
        }
        if R::PIXELS {
            findings.pixels[at] += (hit & !stops).to_bitmask().count_ones();
        }
        if stops.any_true() {
            threshold = stops.select(never, threshold);
            weight = stops.select(zero, weight);
            // The sign says that it has stopped. What the entry would have taken stays for the
            // background: as in the reference, it does not blend.
            rest = stops.select(-t, rest);
            block.note_stops::<S, R>(simd, y, stops, first + at as u32);
            if !threshold.simd_lt(never).any_true() {
                block.alive &= !(1 << y);
                left = 0;
            }
        }
        t = rest;
        for (sum, channel) in colour.iter_mut().zip(colours) {
            *sum = weight.mul_add(channel, *sum);
        }
        if R::DOMINANCE {
            // Strictly, so that of equal weights the nearest splat stays.
            let heavier = weight.simd_gt(heaviest);
            heaviest = heavier.select(weight, heaviest);
            owner = heavier.select(u32x16::splat(simd, ranks[at]), owner);
        }
        if R::WEIGHTS {
            findings.weights[at] += <[f32; BLOCK]>::from(weight).iter().sum::<f32>();
        }
    }
    t.store_slice(&mut block.transmittance[y]);
    for (sum, to) in colour.into_iter().zip(&mut block.colour) {
        sum.store_slice(&mut to[y]);
    }
    if R::COUNT {
        let before = u32x16::from_slice(simd, &block.blended[y]);
        (before + blended.to_int::<u32x16<S>>()).store_slice(&mut block.blended[y]);
    }
    if R::HITS {
        findings.hits[y] = hits;
    }
    if R::DOMINANCE {
        heaviest.store_slice(&mut block.heaviest[y]);
        owner.store_slice(&mut block.heaviest_rank[y]);
    }
}

/// Writes the lines of `block` over `background` to rows of `width` pixels in lines of `stride`.
#[simd]
pub(crate) fn write_block<S: Simd>(
    simd: S,
    block: &BlendBlock,
    background: [f32; 3],
    (width, height): (usize, usize),
    out: &mut [[f32; 3]],
    stride: usize,
) {
    for (y, line) in out.chunks_mut(stride).take(height).enumerate() {
        block.write_row(simd, y, background, &mut line[..width]);
    }
}
