//! Batches of scene records as the CCUs process them.
//!
//! A binned frame knows its counters after every block of 32 records in storage order
//! ([`FrameWorkload::storage`]); within a block they are spread evenly. The batch of the records
//! from `a` to `e` has seen exactly `X(e) - X(a)` of each counter X, so nothing is lost or
//! invented. A frame without these counters is one block.

use crate::workload::binning::{ListPart, ListWrites};
use crate::workload::{FrameWorkload, STORAGE_BLOCK, StoragePrefix};

/// What CCUs do with a batch.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Pass {
    /// Everything: convert, and write list entries.
    #[default]
    Whole,
    /// Convert, and count the entries of tiles.
    Count,
    /// Read what was converted, and write list entries.
    Scatter,
}

/// Consecutive records in storage order, with the counters of their splats.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Batch {
    /// First record.
    pub first: u64,
    /// Records read.
    pub records: u64,
    /// Of these, in front of the near plane.
    pub survivors: u64,
    /// Splats whose box axes are prepared.
    pub prepared: u64,
    /// Box tests.
    pub tests: u64,
    /// Splats with at least one tile.
    pub splats: u64,
    /// (splat, tile) pairs that are written to lists.
    pub pairs: u64,
    /// Look-ups of tile levels; 0 in plain frames.
    pub lookups: u64,
    /// Splats of earlier batches.
    pub first_splat: u64,
    /// Pairs of earlier batches.
    pub first_pair: u64,
    /// Which pass over the records it belongs to.
    pub pass: Pass,
    /// What moves between lists and chip for it; `None` where entries are written back to back.
    pub lists: Option<ListPart>,
}

impl Batch {
    /// The whole frame as one batch for each pass, of which `pairs` pairs are written.
    pub fn passes(workload: &FrameWorkload, pairs: u64, lists: Option<&ListWrites>) -> Vec<Batch> {
        let passes: &[Pass] = match lists {
            Some(lists) if lists.counts_first() => &[Pass::Count, Pass::Scatter],
            Some(_) | None => &[Pass::Whole],
        };
        let whole = Batch::whole(workload, pairs);
        let of = |&pass: &Pass| Batch {
            pass,
            lists: lists.map(|lists| lists.part(pass == Pass::Count, 0, u64::MAX)),
            ..whole
        };
        passes.iter().map(of).collect()
    }

    /// The whole frame as one batch, of which `pairs` pairs are written back to back.
    pub fn whole(workload: &FrameWorkload, pairs: u64) -> Self {
        let counters = &workload.counters;
        Batch {
            first: 0,
            records: counters.points,
            survivors: counters.survivors,
            prepared: counters.obb_prepared,
            tests: counters.obb_tests,
            splats: counters.intersecting_points,
            pairs,
            lookups: workload.fovea.as_ref().map_or(0, |fovea| fovea.counters.lookups),
            ..Batch::default()
        }
    }
}

/// Counters of the first records of a scene.
type BatchCounts = [u64; 6];

/// The batches of a frame, in order.
#[derive(Debug, Clone)]
pub struct Batches<'a> {
    storage: &'a [StoragePrefix],
    total: Batch,
    /// Pairs of the frame; `total.pairs` of them are written.
    pairs: u64,
    batch: u64,
    at: u64,
    before: BatchCounts,
    is_done: bool,
    pass: Pass,
    lists: Option<&'a ListWrites>,
}

impl<'a> Batches<'a> {
    /// Divides the records of a frame into batches of `batch` records; the last may be shorter and
    /// takes the rest of every counter. Of the frame's pairs, `pairs` are written to lists.
    pub fn new(workload: &'a FrameWorkload, batch: u32, pairs: u64) -> Self {
        let total = Batch::whole(workload, pairs);
        Self {
            storage: &workload.storage,
            total,
            pairs: workload.counters.tile_pairs,
            batch: u64::from(batch),
            at: 0,
            before: [0; 6],
            is_done: total == Batch::default(),
            pass: Pass::Whole,
            lists: None,
        }
    }

    /// The same batches in a pass that moves `lists`.
    pub fn with_lists(self, pass: Pass, lists: Option<&'a ListWrites>) -> Self {
        Self { pass, lists, ..self }
    }

    /// The pass over the records.
    pub(crate) fn pass(&self) -> Pass {
        self.pass
    }

    /// Whether there is another batch.
    pub(crate) fn is_empty(&self) -> bool {
        self.is_done
    }

    /// Counters of the first `end` records, `end` below all.
    #[inline]
    fn until(&self, end: u64) -> BatchCounts {
        let t = &self.total;
        if self.storage.is_empty() {
            let all = [t.survivors, t.prepared, t.tests, t.splats, t.pairs, t.lookups];
            return all.map(|x| part_of(x, end, t.records));
        }
        let (block, part) = ((end / STORAGE_BLOCK) as usize, end % STORAGE_BLOCK);
        let low =
            if block == 0 { BatchCounts::default() } else { counts(&self.storage[block - 1]) };
        let high = counts(&self.storage[block]);
        let left = t.records - block as u64 * STORAGE_BLOCK;
        let mut at = low;
        for (x, high) in at.iter_mut().zip(high) {
            // Nearly all blocks are whole: a shift instead of six divisions a batch.
            let growth = (high - *x) * part;
            *x += if left < STORAGE_BLOCK { growth / left } else { growth / STORAGE_BLOCK };
        }
        if t.pairs != self.pairs {
            // Lists with a margin may have pairs where the frame has none.
            at[4] = match self.pairs {
                0 => part_of(t.pairs, end, t.records),
                all => part_of(t.pairs, at[4], all),
            };
        }
        at
    }
}

#[inline]
fn counts(p: &StoragePrefix) -> BatchCounts {
    [p.survivors, p.prepared, p.tests, p.splats, p.pairs, p.lookups].map(u64::from)
}

/// `all * part / whole`, with a product of any size: the result is not above `all`.
#[inline]
fn part_of(all: u64, part: u64, whole: u64) -> u64 {
    match all.checked_mul(part) {
        Some(product) => product / whole,
        None => (u128::from(all) * u128::from(part) / u128::from(whole)) as u64,
    }
}

impl Iterator for Batches<'_> {
    type Item = Batch;

    #[inline]
    fn next(&mut self) -> Option<Batch> {
        if self.is_done {
            return None;
        }
        let (first, end) = (self.at, (self.at + self.batch).min(self.total.records));
        let t = &self.total;
        let until = if end < t.records {
            self.until(end)
        } else {
            [t.survivors, t.prepared, t.tests, t.splats, t.pairs, t.lookups]
        };
        let [survivors, prepared, tests, splats, pairs, lookups] =
            std::array::from_fn(|i| until[i] - self.before[i]);
        let [.., first_splat, first_pair, _] = self.before;
        (self.at, self.before, self.is_done) = (end, until, end >= self.total.records);
        let lists = self.lists.map(|lists| lists.part(self.pass == Pass::Count, first, end));
        Some(Batch {
            first,
            records: end - first,
            survivors,
            prepared,
            tests,
            splats,
            pairs,
            lookups,
            first_splat,
            first_pair,
            pass: self.pass,
            lists,
        })
    }
}
