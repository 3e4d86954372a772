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
    /// Bounds of clusters that are read in place of records; `first` then is the first of them.
    pub clusters: u64,
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
    /// The whole frame as one batch for each pass, of which `pairs` pairs are written, with
    /// clusters of so many Gaussians.
    pub fn passes(
        workload: &FrameWorkload,
        pairs: u64,
        lists: Option<&ListWrites>,
        clusters: u32,
    ) -> Vec<Batch> {
        let passes: &[Pass] = match lists {
            Some(lists) if lists.counts_first() => &[Pass::Count, Pass::Scatter],
            Some(_) | None => &[Pass::Whole],
        };
        let mut whole = Batch::whole(workload, pairs);
        if let Some(clusters) = Clusters::of(workload, clusters) {
            (whole.records, whole.clusters) = (clusters.live_records(), clusters.count());
        }
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

/// Runs of Gaussians in storage order whose bounds are tested first.
#[derive(Debug, Clone, Copy)]
struct Clusters<'a> {
    storage: &'a [StoragePrefix],
    /// Gaussians of one.
    size: u64,
    records: u64,
}

impl<'a> Clusters<'a> {
    /// `None` without clusters, and in scenes of which it is not known who survives where.
    fn of(workload: &'a FrameWorkload, size: u32) -> Option<Clusters<'a>> {
        let (storage, records) = (&workload.storage[..], workload.counters.points);
        let size = u64::from(size);
        (size > 0 && !storage.is_empty()).then_some(Clusters { storage, size, records })
    }

    fn count(&self) -> u64 {
        self.records.div_ceil(self.size)
    }

    /// Whether a Gaussian of a cluster survives: of no other are records read.
    fn is_live(&self, cluster: u64) -> bool {
        // Counters are known after whole blocks only; clusters are multiples of these.
        let blocks = self.size / STORAGE_BLOCK;
        let survivors = |block: u64| match block {
            0 => 0,
            block => self.storage[(block as usize).min(self.storage.len()) - 1].survivors,
        };
        survivors(cluster * blocks) < survivors((cluster + 1) * blocks)
    }

    /// Where a cluster ends.
    fn end(&self, cluster: u64) -> u64 {
        ((cluster + 1) * self.size).min(self.records)
    }

    fn live_records(&self) -> u64 {
        let live = (0..self.count()).filter(|&cluster| self.is_live(cluster));
        live.map(|cluster| self.end(cluster) - cluster * self.size).sum()
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
    clusters: Option<Clusters<'a>>,
    /// Bounds of a batch of them.
    tests: u64,
    /// Clusters that are tested.
    tested: u64,
    /// Behind the last cluster of which records are read; behind all without clusters.
    live_end: u64,
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
            clusters: None,
            tests: 0,
            tested: 0,
            live_end: total.records,
        }
    }

    /// With clusters of `size` Gaussians, of which `tests` are tested in a batch.
    pub fn with_clusters(self, workload: &'a FrameWorkload, size: u32, tests: u64) -> Self {
        let clusters = Clusters::of(workload, size);
        // Behind the last live cluster no records are read, and no batch is made of them.
        let live_end = clusters.map_or(self.live_end, |all| {
            let last = (0..all.count()).rev().find(|&cluster| all.is_live(cluster));
            last.map_or(0, |cluster| all.end(cluster))
        });
        Self { clusters, tests: tests.max(1), live_end, ..self }
    }

    /// Tests bounds until the next record is known that is read; the batch of them, if there is one
    /// to test. Afterwards `at` is that record, or behind all.
    fn test(&mut self) -> Option<Batch> {
        let clusters = self.clusters?;
        while self.at < self.total.records {
            let cluster = self.at / clusters.size;
            // The second pass reads converted splats, and tests no bounds again.
            if cluster >= self.tested && self.pass != Pass::Scatter {
                let first = self.tested;
                let n = self.tests.min(clusters.count() - first);
                self.tested += n;
                return Some(Batch { first, clusters: n, pass: self.pass, ..Batch::default() });
            }
            if clusters.is_live(cluster) {
                return None;
            }
            self.at = clusters.end(cluster);
        }
        None
    }

    /// Whether nothing of the records from `at` on is read, and no bounds are left to test.
    fn is_at_end(&self) -> bool {
        let all_tested = |clusters: Clusters| self.tested >= clusters.count();
        let is_tested = self.pass == Pass::Scatter || self.clusters.is_none_or(all_tested);
        is_tested && self.at >= self.live_end
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
        // Not all pairs are written (updated lists, lists of later frames): the same share of each
        // batch is.
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
        if let Some(tested) = self.test() {
            self.is_done = self.is_at_end();
            return Some(tested);
        }
        let first = self.at;
        // A batch ends with its cluster, because the next one may not be read.
        let run = self.clusters.map_or(self.total.records, |all| all.end(first / all.size));
        let end = (first + self.batch).min(run);
        let t = &self.total;
        let until = if end < t.records {
            self.until(end)
        } else {
            [t.survivors, t.prepared, t.tests, t.splats, t.pairs, t.lookups]
        };
        let [survivors, prepared, tests, splats, pairs, lookups] =
            std::array::from_fn(|i| until[i] - self.before[i]);
        let [.., first_splat, first_pair, _] = self.before;
        (self.at, self.before) = (end, until);
        self.is_done = self.is_at_end();
        // What is left on chip is written with the last record that is read.
        let behind = if end >= self.live_end { self.total.records } else { end };
        let lists = self.lists.map(|lists| lists.part(self.pass == Pass::Count, first, behind));
        Some(Batch {
            first,
            records: end - first,
            clusters: 0,
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
