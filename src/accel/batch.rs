//! Batches of records on their way through the CCUs.
//!
//! A trace counts survivors, box tests and pairs per frame, not per record, so they are spread
//! evenly over the records: the batch that ends after `e` of `P` records has seen exactly
//! `floor(X e / P)` of each counter X. Nothing is lost or invented.

use crate::workload::FrameWorkload;

/// Some records in storage order, and what they turn out to be.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Batch {
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
    /// (splat, tile) pairs.
    pub pairs: u64,
}

impl Batch {
    /// The whole frame as one batch.
    pub fn whole(workload: &FrameWorkload) -> Self {
        let counters = &workload.counters;
        Batch {
            records: counters.points,
            survivors: counters.survivors,
            prepared: counters.obb_prepared,
            tests: counters.obb_tests,
            splats: counters.intersecting_points,
            pairs: counters.tile_pairs,
        }
    }
}

/// One counter, spread over the records.
#[derive(Debug, Clone, Copy)]
struct Spread {
    quotient: u64,
    remainder: u64,
    carry: u64,
}

impl Spread {
    fn new(total: u64, batch: u64, records: u64) -> Self {
        let product = u128::from(total) * u128::from(batch);
        let records = u128::from(records.max(1));
        Self {
            quotient: (product / records) as u64,
            remainder: (product % records) as u64,
            carry: 0,
        }
    }

    fn next(&mut self, records: u64) -> u64 {
        self.carry += self.remainder;
        let over = u64::from(self.carry >= records);
        self.carry -= over * records;
        self.quotient + over
    }
}

/// The batches of a frame, in order.
#[derive(Debug, Clone)]
pub struct Batches {
    left: Batch,
    batch: u64,
    records: u64,
    spreads: [Spread; 5],
}

impl Batches {
    /// Cuts the records of a frame into batches of `batch`; the last may be shorter, and takes
    /// whatever is left of every counter.
    pub fn new(workload: &FrameWorkload, batch: u32) -> Self {
        let left = Batch::whole(workload);
        let (batch, records) = (u64::from(batch), left.records);
        let totals = [left.survivors, left.prepared, left.tests, left.splats, left.pairs];
        Self { left, batch, records, spreads: totals.map(|t| Spread::new(t, batch, records)) }
    }

    /// Whether there is another batch.
    pub fn is_empty(&self) -> bool {
        self.left == Batch::default()
    }
}

impl Iterator for Batches {
    type Item = Batch;

    fn next(&mut self) -> Option<Batch> {
        if self.left.records <= self.batch {
            let last = std::mem::take(&mut self.left);
            return (last != Batch::default()).then_some(last);
        }
        let [survivors, prepared, tests, splats, pairs] =
            std::array::from_fn(|i| self.spreads[i].next(self.records));
        let next = Batch { records: self.batch, survivors, prepared, tests, splats, pairs };
        self.left.records -= next.records;
        self.left.survivors -= survivors;
        self.left.prepared -= prepared;
        self.left.tests -= tests;
        self.left.splats -= splats;
        self.left.pairs -= pairs;
        Some(next)
    }
}
