//! Blending of one block in two levels at once (`powergs.md` §6.4).
//!
//! A list is traversed once. The exponent of a splat is evaluated once, and the opacity of each
//! level is added to it. Every pixel of either block has the same bits as if its level were blended
//! alone.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use super::super::blend::{
    BATCH, BLOCK, Block, Brush, Entry, Form, Line, Paint, Record, Tint, alpha_of, blend_row,
};
use super::paints::OfLevel;

/// Where two levels are blended: the blocks, and the paints of the first level.
pub(super) struct Pair<'a> {
    /// Blocks of the first and the second level.
    pub blocks: [&'a mut Block; 2],
    /// Paints of the first level.
    pub paints: OfLevel<'a>,
}

impl Pair<'_> {
    #[inline(always)]
    fn is_open(&self) -> bool {
        self.blocks[0].alive | self.blocks[1].alive != 0
    }
}

/// Blends `entries` into both blocks. Stops are positions in `entries` for either.
#[simd]
pub(super) fn blend_pair<S: Simd, R: Record>(
    simd: S,
    record: R,
    pair: &mut Pair<'_>,
    entries: &[Entry],
) {
    let mut near = [Paint::default(); BATCH];
    let mut next = [Tint::NOTHING; BATCH];
    for (batch, entries) in entries.chunks(BATCH).enumerate() {
        pair.paints.fetch_two(entries, &mut near, &mut next);
        let entries = entries.iter().zip(near.iter().zip(&next));
        blend_batch(simd, record, pair, batch * BATCH, entries);
        if !pair.is_open() {
            return;
        }
    }
}

/// Blends up to [`BATCH`] entries; `from` is the position of the first one.
#[inline(always)]
fn blend_batch<'a, S: Simd, R: Record>(
    simd: S,
    record: R,
    pair: &mut Pair<'_>,
    from: usize,
    entries: impl Iterator<Item = (&'a Entry, (&'a Paint, &'a Tint))>,
) {
    let iota: f32x16<S> = f32x16::from_fn(simd, |i| i as f32);
    let [left, top] = pair.blocks[0].origin;
    let (columns, rows) = (iota + left, iota + top);
    for (at, (entry, (paint, second))) in entries.enumerate() {
        let form = Form::of(simd, paint, rows, left);
        let base = [form.base(simd, paint.log_opacity), form.base(simd, second.log_opacity)];
        let touched = [
            form.touched(simd, paint, base[0]) & pair.blocks[0].alive,
            form.touched(simd, paint, base[1]) & pair.blocks[1].alive,
        ];
        let mut either = touched[0] | touched[1];
        if either == 0 {
            continue;
        }
        let (linear, bases) = (Line::of(form.linear), base.map(Line::of));
        let dx = columns - paint.mean[0];
        let rank = entry.rank;
        let brushes = [Brush { tint: paint.tint(), rank }, Brush { tint: *second, rank }];
        // Exponentials first: they wait for nothing, so that many are in flight.
        while either != 0 {
            let y = either.trailing_zeros() as usize & (BLOCK - 1);
            either &= either - 1;
            let slope = f32x16::splat(simd, paint.quadratic[0]).mul_add(dx, linear.at(simd, y));
            for k in 0..2 {
                if touched[k] >> y & 1 == 1 {
                    let power = slope.mul_add(dx, bases[k].at(simd, y));
                    let alpha = alpha_of(simd, power, brushes[k].tint.log_opacity);
                    alpha.store_slice(&mut pair.blocks[k].alphas[y]);
                }
            }
        }
        for ((block, mut rows), brush) in pair.blocks.iter_mut().zip(touched).zip(&brushes) {
            let mut stop_rows = 0;
            while rows != 0 {
                let y = rows.trailing_zeros() as usize & (BLOCK - 1);
                rows &= rows - 1;
                let row = blend_row(simd, record, block, y, brush);
                stop_rows |= u32::from(row.stops) << y;
            }
            if stop_rows != 0 {
                block.note_stops::<S, R>(simd, stop_rows, (from + at) as u32);
            }
        }
        if !pair.is_open() {
            return;
        }
    }
}
