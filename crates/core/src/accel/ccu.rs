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
//! **Foveated frames.** A record has one byte more, its highest level, read with its geometry;
//! where colour is not fetched lazily, the records of the three further levels come with it. Before
//! its box tests a splat is tested against the level of every tile under its bounding square,
//! `fovea.level-tests` a cycle and beside the box tests; the levels are in a table of two bytes a
//! tile that is written once a frame, in no time (A16).
//!
//! Source: `gscore` as re-modelled by `nerarch-sim` (four units, 128 cycles); the interval and the
//! number of test units are not published.

use super::bank::Banks;
use super::batch::Batch;
use super::divide::Divisor;
use super::machine::{CcuSpec, Fetch, FoveaSpec, RecordSpec};
use super::unit::Unit;
use crate::action::{Action, ActionCounts, Buffer, Stage, UnitKind};

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
    /// Bytes of levels in the record of a foveated frame; 0 in plain frames.
    pub level_bytes: u64,
    /// Box tests a cycle.
    tests: Divisor,
    /// Look-ups of tile levels a cycle.
    lookups: Divisor,
}

/// Bytes of a tile in the table of levels.
const LEVEL_ENTRY: u64 = 2;
/// Box tests that take as many operations as the level of a tile: 94 over 48 (A16).
const LEVEL_AS_TESTS: u64 = 2;

impl Ccu {
    /// A unit with `share` bytes of the input buffer, in which two batches fit: one is read while
    /// the other is converted. `fovea` is context for foveated frames.
    pub(crate) fn new(
        spec: CcuSpec,
        record: RecordSpec,
        fovea: Option<FoveaSpec>,
        share: u64,
        input: Banks,
        output: Banks,
    ) -> Self {
        let level_bytes = fovea.as_ref().map_or(0, |fovea| match spec.fetch {
            Fetch::Everything | Fetch::GeometryFirst => 1 + 3 * fovea.record.0,
            Fetch::LazyColour => 1,
        });
        let geometry = record.geometry.0 + level_bytes;
        let (position, rest) = (record.position.0, geometry + record.colour.0);
        let reads = match spec.fetch {
            Fetch::Everything => (position + rest, 0),
            Fetch::GeometryFirst => (position, rest),
            Fetch::LazyColour => (position, geometry),
        };
        let tests = Divisor::new(u64::from(spec.intersection_units));
        let lookups = Divisor::new(fovea.map_or(1, |fovea| u64::from(fovea.level_tests)));
        let mut ccu =
            Self { spec, record, batch: 1, input, output, reads, level_bytes, tests, lookups };
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

    /// Bytes that a batch allocates in the input buffer: those of a batch in which every record
    /// survives, because the allocation is made before culling.
    #[inline]
    pub fn reserved(&self) -> u64 {
        u64::from(self.batch) * (self.reads.0 + self.reads.1)
    }

    /// Charges the table of levels of `tiles` tiles, once a frame.
    pub(crate) fn charge_levels(&self, tiles: u64, actions: &mut ActionCounts) {
        let stage = Stage::Preprocessing;
        let bytes = self.output.words(tiles * LEVEL_ENTRY) * self.output.word();
        actions.charge(stage, Action::ObbTest, LEVEL_AS_TESTS * tiles);
        actions.charge(stage, Action::SramWrite(Buffer::TileList), bytes);
    }
}

impl Unit for Ccu {
    type Work = Batch;
    const NAME: &'static str = UnitKind::Ccu.name();

    #[inline]
    fn cycles(&self, batch: &Batch) -> u64 {
        let interval = u64::from(self.spec.initiation_interval);
        let tested = batch.prepared.min(batch.records);
        let tests = self.tests.div_ceil(batch.tests).max(self.lookups.div_ceil(batch.lookups));
        ((batch.records - tested) * interval + (tested * interval).max(tests)).max(1)
    }

    fn bank_stalls(&self, batch: &Batch) -> u64 {
        self.times(batch).1
    }

    /// Records stream through both buffers while the next ones arrive.
    #[inline]
    fn times(&self, batch: &Batch) -> (u64, u64) {
        let cycles = self.cycles(batch);
        let (input, output) = (self.input_words(batch), self.output_words(batch));
        let stalls = self.input.excess(input, input, cycles);
        (cycles, stalls.max(self.output.excess(output, output, cycles)))
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
        if self.level_bytes > 1 {
            actions.charge(stage, Action::PixelFinish, 3 * batch.survivors);
        }
        if batch.lookups > 0 {
            let looked = self.output.words(batch.lookups * LEVEL_ENTRY) * self.output.word();
            actions.charge(stage, Action::SramRead(Buffer::TileList), looked);
        }
        let read = self.input_words(batch) * self.input.word();
        actions.charge(stage, Action::SramWrite(Buffer::GaussianIn), read);
        actions.charge(stage, Action::SramRead(Buffer::GaussianIn), read);
        let written = self.output_words(batch) * self.output.word();
        actions.charge(stage, Action::SramWrite(Buffer::TileList), written);
        actions.charge(stage, Action::SramRead(Buffer::TileList), written);
    }
}
