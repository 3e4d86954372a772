//! Splats in storage order: what each run of records of the scene turns out to be.
//!
//! Records of the scene lie in storage in the order of their index. One bit per record says whether
//! it has a tile; a block of [`STORAGE_BLOCK`] records is one word of these bits.

use rayon::prelude::*;

use super::{Cull, STORAGE_BLOCK, STORAGE_RECORDS_MAX, StoragePrefix};
use powergs_frame::splat::Splat;
use powergs_frame::splat::runs::Touch;
use powergs_frame::trace::Frame;

/// One bit per record of a block.
type Word = u32;

const _: () = assert!(STORAGE_BLOCK == Word::BITS as u64);

/// Where splats lie.
#[derive(Debug, Default)]
pub(crate) struct Storage {
    /// As [`FrameWorkload::slot`](super::FrameWorkload::slot).
    pub slot: Vec<u32>,
    /// As [`FrameWorkload::storage`](super::FrameWorkload::storage).
    pub prefix: Vec<StoragePrefix>,
}

impl Storage {
    /// Finds where the splats of `frame` lie, given the tiles that each touches, by rank.
    pub(crate) fn new(frame: &Frame, touches: &[Touch], cull: Cull) -> Storage {
        if frame.facts.points > STORAGE_RECORDS_MAX {
            return Storage { slot: sort_slots(frame, touches), prefix: Vec::new() };
        }
        let blocks = frame.facts.points.div_ceil(STORAGE_BLOCK) as usize;
        let mut with_tile: Vec<Word> = vec![0; blocks];
        let mut prefix = vec![StoragePrefix::default(); blocks];
        for (splat, touch) in frame.splats.iter().zip(touches) {
            let (block, bit) = place(splat);
            let own = &mut prefix[block];
            own.prepared += u32::from(touch.tests > 0);
            own.tests = own.tests.saturating_add(touch.tests);
            own.pairs += touch.tiles;
            own.lookups = own.lookups.saturating_add(touch.lookups);
            with_tile[block] |= Word::from(touch.tiles > 0) << bit;
        }
        for (own, bits) in prefix.iter_mut().zip(&with_tile) {
            own.splats = bits.count_ones();
        }
        match cull {
            Cull::Depth => count_survivors(frame, &mut prefix),
            Cull::Frustum => count_inside(frame, &mut prefix),
        }
        accumulate(&mut prefix);
        let slot = |(splat, touch): (&Splat, &Touch)| {
            let (block, bit) = place(splat);
            let earlier = (with_tile[block] & ((1 << bit) - 1)).count_ones();
            let before = if block == 0 { 0 } else { prefix[block - 1].splats };
            if touch.tiles > 0 { before + earlier } else { u32::MAX }
        };
        let slot = frame.splats.par_iter().zip(touches).map(slot).collect();
        Storage { slot, prefix }
    }
}

/// The slots without a table of the scene.
fn sort_slots(frame: &Frame, touches: &[Touch]) -> Vec<u32> {
    let with_tile = touches.iter().enumerate().filter(|(_, touch)| touch.tiles > 0);
    let mut ranks: Vec<usize> = with_tile.map(|(rank, _)| rank).collect();
    ranks.par_sort_unstable_by_key(|&rank| frame.splats[rank].index);
    let mut slots = vec![u32::MAX; touches.len()];
    for (slot, rank) in (0..).zip(ranks) {
        slots[rank] = slot;
    }
    slots
}

fn place(splat: &Splat) -> (usize, u32) {
    (splat.index as usize / STORAGE_BLOCK as usize, splat.index % Word::BITS)
}

/// Gaussians of each block that are inside the frustum, or shown: a margin that loses what is shown
/// would make another picture. Where the trace does not say which are inside, those that it shows
/// (A127).
fn count_inside(frame: &Frame, blocks: &mut [StoragePrefix]) {
    let mut inside: Vec<Word> = vec![0; blocks.len()];
    let bits = frame.frustum_bits.as_deref().unwrap_or_default();
    for (block, bytes) in inside.iter_mut().zip(bits.chunks(size_of::<Word>())) {
        let mut word = [0; size_of::<Word>()];
        word[..bytes.len()].copy_from_slice(bytes);
        *block = Word::from_le_bytes(word);
    }
    for splat in &frame.splats {
        let (block, bit) = place(splat);
        inside[block] |= 1 << bit;
    }
    for (own, bits) in blocks.iter_mut().zip(inside) {
        own.survivors = bits.count_ones();
    }
}

/// Survivors of each block. Where the trace does not say which records survive, those that it shows
/// do, and the others are spread evenly over the records that are left (A70).
fn count_survivors(frame: &Frame, blocks: &mut [StoragePrefix]) {
    if let Some(bits) = &frame.survivor_bits {
        for (own, bytes) in blocks.iter_mut().zip(bits.chunks(STORAGE_BLOCK as usize / 8)) {
            own.survivors = bytes.iter().map(|b| b.count_ones()).sum();
        }
        return;
    }
    for splat in &frame.splats {
        blocks[place(splat).0].survivors += 1;
    }
    let points = frame.facts.points;
    let visible = frame.splats.len() as u64;
    let others = u128::from(frame.facts.survivors.saturating_sub(visible));
    let places = u128::from(points.saturating_sub(visible).max(1));
    let (mut left, mut placed) = (0u64, 0u64);
    for (i, own) in (0u64..).zip(blocks) {
        let records = STORAGE_BLOCK.min(points - i * STORAGE_BLOCK);
        left += records - u64::from(own.survivors);
        let due = (u128::from(left) * others / places) as u64;
        own.survivors += (due - placed) as u32;
        placed = due;
    }
}

fn accumulate(blocks: &mut [StoragePrefix]) {
    let mut sum = StoragePrefix::default();
    for own in blocks {
        sum.survivors += own.survivors;
        sum.prepared += own.prepared;
        sum.tests = sum.tests.saturating_add(own.tests);
        sum.splats += own.splats;
        sum.pairs += own.pairs;
        sum.lookups = sum.lookups.saturating_add(own.lookups);
        *own = sum;
    }
}
