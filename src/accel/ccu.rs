//! Culling and Conversion Unit (CCU): culls, projects and intersects the Gaussians of the scene.
//!
//! Timing rule: a record enters every `initiation_interval` cycles. A splat with box tests holds
//! the entry until its tests are issued, `intersection_units` a cycle; since a frame knows how many
//! splats are tested and how many tests there are, but not which splat has how many, a batch takes
//! `(records - tested) II + max(tested II, ceil(tests / intersection_units))` cycles (A21). Results
//! leave `latency` cycles after the last record has entered; the next batch may enter meanwhile.
//!
//! Memory rule: a batch is `batch` records, or as many as fit half of the unit's input buffer (A3).
//! The record is read as `fetch` says. With `everything` a batch is one read; with the
//! other two its positions are read first, and the rest of the survivors when they have arrived:
//! the depth test is made on the fly and costs no time of its own (A22).
//!
//! Source: `gscore` as re-modelled by `nerarch-sim` (four units, 128 cycles); the interval and the
//! number of test units are not published.

use super::bank::Banks;
use super::batch::Batch;
use super::divide::Divisor;
use super::machine::{CcuSpec, Fetch, RecordSpec};
use super::unit::Unit;
use crate::action::{Action, ActionCounts, Buffer, Stage};

/// The unit.
#[derive(Debug, Clone)]
pub struct Ccu {
    /// The `[ccu]` table.
    pub spec: CcuSpec,
    /// Bytes of the records.
    pub record: RecordSpec,
    /// Records of a batch: `spec.batch`, or as many as fit half of the unit's input buffer.
    pub batch: u32,
    /// Banks of its share of the input buffer.
    pub input: Banks,
    /// Banks of its share of the tile-list buffer.
    pub output: Banks,
    /// Bytes that the first read takes of every record, and the second of every survivor.
    reads: (u64, u64),
    /// Box tests a cycle.
    tests: Divisor,
}

impl Ccu {
    /// A unit with `share` bytes of the input buffer: two batches fit, so that one is read while
    /// the other is converted.
    pub fn new(
        spec: CcuSpec,
        record: RecordSpec,
        share: u64,
        (input, output): (Banks, Banks),
    ) -> Self {
        let (position, rest) = (record.position.0, record.geometry.0 + record.colour.0);
        let reads = match spec.fetch {
            Fetch::Everything => (position + rest, 0),
            Fetch::GeometryFirst => (position, rest),
            Fetch::LazyColour => (position, record.geometry.0),
        };
        let tests = Divisor::new(u64::from(spec.intersection_units));
        let mut ccu = Self { spec, record, batch: 1, input, output, reads, tests };
        let most = (share / 2) / ccu.reserved().max(1);
        ccu.batch = ccu.spec.batch.min(u32::try_from(most).unwrap_or(u32::MAX)).max(1);
        ccu
    }

    /// Bytes of the first read of a batch.
    pub fn first_read(&self, batch: &Batch) -> u64 {
        batch.records * self.reads.0
    }

    /// Bytes of the second read, which knows the survivors.
    pub fn second_read(&self, batch: &Batch) -> u64 {
        batch.survivors * self.reads.1
    }

    /// Bytes that a batch writes: projected splats and list entries.
    pub fn written(&self, batch: &Batch) -> u64 {
        batch.splats * self.record.projected.0 + batch.pairs * self.record.list_entry.0
    }

    /// Words of the input buffer that a batch fills: records lie back to back.
    fn input_words(&self, batch: &Batch) -> u64 {
        self.input.words(self.first_read(batch)) + self.input.words(self.second_read(batch))
    }

    /// Words of the tile-list buffer that a batch fills.
    fn output_words(&self, batch: &Batch) -> u64 {
        self.output.words(batch.splats * self.record.projected.0)
            + self.output.words(batch.pairs * self.record.list_entry.0)
    }

    /// Room that a batch reserves in the input buffer: that of a full batch of survivors, because
    /// the read is issued before anybody knows.
    #[inline]
    pub fn reserved(&self) -> u64 {
        u64::from(self.batch) * (self.reads.0 + self.reads.1)
    }

    /// [`Unit::cycles`] and [`Unit::bank_stalls`] of a batch. Records stream through both buffers
    /// while the next ones arrive.
    #[inline]
    pub fn times(&self, batch: &Batch) -> (u64, u64) {
        let cycles = self.cycles(batch);
        let (input, output) = (self.input_words(batch), self.output_words(batch));
        let stalls = self.input.excess(input, input, cycles);
        (cycles, stalls.max(self.output.excess(output, output, cycles)))
    }
}

impl Unit for Ccu {
    type Work = Batch;
    const NAME: &'static str = "ccu";

    #[inline]
    fn cycles(&self, batch: &Batch) -> u64 {
        let interval = u64::from(self.spec.initiation_interval);
        let tested = batch.prepared.min(batch.records);
        let tests = self.tests.div_ceil(batch.tests);
        ((batch.records - tested) * interval + (tested * interval).max(tests)).max(1)
    }

    fn bank_stalls(&self, batch: &Batch) -> u64 {
        self.times(batch).1
    }

    fn charge(&self, batch: &Batch, actions: &mut ActionCounts) {
        let stage = Stage::Preprocessing;
        actions.charge(stage, Action::Cull, batch.records);
        actions.charge(stage, Action::Project, batch.survivors);
        actions.charge(stage, Action::ObbPrepare, batch.prepared);
        actions.charge(stage, Action::ObbTest, batch.tests);
        if self.spec.fetch != Fetch::LazyColour {
            actions.charge(stage, Action::ShColour, batch.survivors);
        }
        let read = self.input_words(batch) * self.input.word();
        actions.charge(stage, Action::SramWrite(Buffer::GaussianIn), read);
        actions.charge(stage, Action::SramRead(Buffer::GaussianIn), read);
        let written = self.output_words(batch) * self.output.word();
        actions.charge(stage, Action::SramWrite(Buffer::TileList), written);
        actions.charge(stage, Action::SramRead(Buffer::TileList), written);
    }
}
