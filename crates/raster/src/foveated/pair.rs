//! Blending of one block in two levels at once (`powergs.md` §6.4).
//!
//! A list is traversed once, a batch for the first level and then for the second. Every pixel of
//! either block has the same bits as if its level were blended alone.

use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use super::super::blend::{BATCH, BlendBlock, BlendRecord, Paint, Tint, blend_batch};
use super::paints::OfLevel;

/// Where two levels are blended: the blocks, and the paints of the first level.
pub(super) struct FoveatedPair<'a> {
    /// Blocks of the first and the second level.
    pub blocks: [&'a mut BlendBlock; 2],
    /// Paints of the first level.
    pub paints: OfLevel<'a>,
}

impl FoveatedPair<'_> {
    #[inline(always)]
    fn is_open(&self) -> bool {
        self.blocks[0].alive | self.blocks[1].alive != 0
    }
}

/// Blends the splats of a list of ranks into both blocks. Stops are positions in it for either.
#[simd]
pub(super) fn blend_pair<S: Simd, R: BlendRecord>(
    simd: S,
    record: R,
    pair: &mut FoveatedPair<'_>,
    ranks: &[u32],
) {
    let mut near = [Paint::default(); BATCH];
    let mut next = [Tint::NOTHING; BATCH];
    for (batch, ranks) in ranks.chunks(BATCH).enumerate() {
        pair.paints.fetch_two(ranks, &mut near, &mut next);
        let at = batch * BATCH;
        let [first, second] = &mut pair.blocks;
        blend_batch(simd, record, first, at, ranks, &near, |at| near[at].tint());
        blend_batch(simd, record, second, at, ranks, &near, |at| next[at]);
        if !pair.is_open() {
            return;
        }
    }
}
