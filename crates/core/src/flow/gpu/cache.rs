//! The L2 cache as a filter: what of the reads of the blending kernel goes on to the memory.
//!
//! Tiles are taken in their order, entry by entry, and lists pass through the cache beside the
//! Gaussians. What is in it is what came last (first in, first out): a Gaussian is found again as
//! long as fewer bytes than the cache has came in since.

use crate::kernel::memo::MemoKey;
use crate::workload::{FrameWorkload, Geometry};

/// Everything that decides what is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FilterKey {
    /// Bytes of the cache.
    pub capacity: u64,
    /// Bytes of an entry of a list.
    pub entry: u64,
    /// Bytes of a Gaussian, in whole sectors.
    pub feature: u64,
    /// How lists are gone through.
    pub reads: ListReads,
    /// Geometry of the workload.
    pub geometry: Geometry,
}

/// How the kernel goes through the list of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListReads {
    /// Until all pixels have stopped.
    UntilStop,
    /// To its end, whatever stops.
    Whole,
    /// All of it, from its end.
    Reverse,
}

impl MemoKey for FilterKey {
    type Value = Filtered;
    const MOST: usize = 64;
}

/// Reads of Gaussians by the blending kernel.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Filtered {
    /// Found in the cache.
    pub hits: u64,
    /// Read from the memory.
    pub misses: u64,
    /// The same tile by tile.
    pub by_tile: Vec<u32>,
}

impl Filtered {
    /// Goes through a frame.
    pub fn new(workload: &FrameWorkload, key: &FilterKey) -> Filtered {
        let mut came = vec![u64::MAX; workload.index.len()];
        let (mut bytes, mut found) = (0_u64, Filtered::default());
        for tile in &workload.tiles {
            let (list, before) = (workload.list_of(tile), found.misses);
            let read = match key.reads {
                ListReads::UntilStop => (tile.loaded as usize).min(list.len()),
                ListReads::Whole | ListReads::Reverse => list.len(),
            };
            let is_reverse = key.reads == ListReads::Reverse;
            for place in 0..read {
                let rank = list[if is_reverse { read - 1 - place } else { place }];
                bytes += key.entry;
                let came = &mut came[rank as usize];
                if *came != u64::MAX && bytes - *came < key.capacity {
                    found.hits += 1;
                } else {
                    found.misses += 1;
                    *came = bytes;
                    bytes += key.feature;
                }
            }
            found.by_tile.push((found.misses - before) as u32);
        }
        found
    }
}
