//! Culling and Conversion Unit (CCU): culls, projects and intersects the Gaussians of the scene.
//!
//! Timing rule: a unit has arithmetic for `operations-per-cycle` operations a cycle, and a record
//! enters in one cycle at least. The table `operations` says what a step takes: every record is
//! culled, survivors are projected, box axes are prepared for splats that are tested, and colours
//! are evaluated for those that `fetch` brings colours for (in proportion to the SH degree of the
//! scene). A batch takes `ceil(operations / operations-per-cycle)` cycles of arithmetic (A1), or
//! the longest of those of its engines where culling or colours have one of their own
//! (`cull-operations-per-cycle`, `colour-operations-per-cycle`; each takes whole batches). Box
//! tests have units of their own, `intersection_units` a cycle, and a splat holds the entry until
//! its tests are issued: `max(tested, ceil(tests / intersection_units))` cycles for all of a batch,
//! since a frame knows how many splats are tested and how many tests there are, but not which splat
//! has how many (A21). A batch takes the longer of its arithmetic and of its entry. Results leave
//! `latency` cycles after the last record has entered; the next batch may enter meanwhile.
//!
//! Memory rule: a batch is `batch` records, or as many as fit the unit's input buffer (A3). Its
//! record is read as `fetch` says, in up to three reads: something of all records, something of the
//! survivors when that has arrived, and something of the splats with a tile when that has arrived;
//! what decides between two reads is made on the fly and costs no time of its own (A22). A read
//! takes room for what it brings when it is issued. It is issued only if every older batch of the
//! unit, in order, can still get all that it may need from what is free and what the batches before
//! it give back: so no batch waits for a younger one (A36). The room of a batch is given back when
//! its last record has entered.
//!
//! **Lists.** A batch that must read something to write its entries (pointers that are not on chip,
//! bytes of a line that is written again) does so when its results leave, and writes when that has
//! arrived. Every pair reads and writes a pointer and writes a line in their buffers, whose banks a
//! batch waits for (A90). With two passes the first writes no entries; the second begins when all
//! is written and a sum over the tiles, one a cycle, is done. It reads what was written of every
//! splat with a tile, prepares its box and tests it again.
//!
//! **Codebook.** With `codebook.entries` a colour reads an entry, which has the table of its unit
//! for `ceil(words / banks)` cycles; the look-ups of a batch go on beside its arithmetic (A116).
//!
//! **Foveated frames.** A record has one byte more, its highest level, read with its geometry;
//! where colour is not fetched lazily, the records of the three further levels come with it. Before
//! its box tests a splat is tested against the level of every tile under its bounding square,
//! `fovea.level-tests` a cycle and beside the box tests; the levels are in a table of two bytes a
//! tile that is written once a frame, in no time (A16).
//!
//! Source: `gscore` as re-modelled by `nerarch-sim` (four units); what a unit does in a cycle and
//! the number of test units are not published.

mod table;

use super::BufferSpecs;
use crate::flow::tile_wise::batch::{Batch, Pass};
use crate::flow::tile_wise::colour;
use crate::flow::tile_wise::lists;
use crate::flow::tile_wise::vru;
use crate::flow::tile_wise::{CodebookSpec, FeatureSource, FoveaSpec, PixelsSpec, RecordSpec};
use crate::kernel::bank::Banks;
use crate::kernel::divide::Divisor;
use crate::kernel::stream::{reads, writes};
use crate::kernel::unit::Unit;
use crate::stage::{
    Bias, From, StageDecl, Stall, WaitDecl, buffer, buffer_id, double, omit, part, sram_read,
    sram_write, stage_id, work, work_id,
};
use powergs_energy::action::{ActionCounts, ActionId, BufferId, Phase, StageId};
use powergs_energy::flops::SH_COLOUR;
use powergs_frame::scene::ShDegree;

pub use table::{CcuOperations, CcuSpec, Fetch};

/// What the unit declares.
pub const CCU: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<CcuSpec>().units),
    works: &[
        work(
            "cull",
            47,
            "One Gaussian taken through cull and the part of projection that the cull needs.",
        )
        .a_cycle(|m| m.of_type::<CcuSpec>().gaussians_per_cycle()[0]),
        // 169 projection, 39 bounding box.
        work("project", 208, "One survivor projected to a 2D covariance, with its bounding box.")
            .a_cycle(|m| m.of_type::<CcuSpec>().gaussians_per_cycle()[1]),
        work("obb-prepare", 38, "Axes of the oriented box of one splat that needs box tests.")
            .a_cycle(|m| m.of_type::<CcuSpec>().gaussians_per_cycle()[1]),
        work("obb-test", 48, "One oriented-box-against-tile test.")
            .a_cycle(|m| f64::from(m.of_type::<CcuSpec>().intersection_units)),
        work("pixel-test", 13, "One α of a Gaussian at a pixel, before it comes into a list.")
            .a_cycle(|m| match m.of_type::<PixelsSpec>().filters() {
                true => f64::from(m.of_type::<CcuSpec>().intersection_units),
                false => 0.0,
            })
            .priced_as("alpha"),
        work(
            "sh-colour",
            SH_COLOUR[SH_COLOUR.len() - 1],
            "One view-dependent colour from spherical harmonics.",
        )
        .of_colour()
        .a_cycle(|m| match m.of_type::<CcuSpec>().fetch {
            Fetch::LazyColour => 0.0,
            Fetch::Everything | Fetch::GeometryFirst | Fetch::VisibleColour => {
                m.of_type::<CcuSpec>().gaussians_per_cycle()[2]
            }
        }),
    ],
    buffers: &[
        buffer("gaussian_in", "buffers.gaussian-in", |m| {
            m.of_type::<BufferSpecs>().gaussian_in.shared(m.of_type::<CcuSpec>().units)
        }),
        buffer("tile_list", "buffers.tile-list", |m| {
            m.of_type::<BufferSpecs>().tile_list.shared(m.of_type::<CcuSpec>().units)
        }),
    ],
    streams: &[
        // The first read of a batch.
        reads("records", "something of all records", &[], ["survivors", "colours"]),
        // The second.
        reads("survivors", "something of the survivors", &[], ["colours", "records"]).scattered(),
        // The third.
        reads("colours", "colours of splats", &[], ["survivors", "records"]).scattered(),
        reads(
            "read-back",
            "lists and pointers, before they are written",
            &["results"],
            ["features", "survivors"],
        )
        .scattered(),
        writes("results", "splats and list entries", ["pixels", "kept-lists"]),
    ],
    parts: &[
        part("operations", "Arithmetic of conversion; amount: operations a cycle.", |m| {
            m.of_type::<CcuSpec>().all_operations_per_cycle() as f64
        }),
        part("intersection-units", "Box tests a cycle.", |m| {
            f64::from(m.of_type::<CcuSpec>().intersection_units)
        }),
        part("level-tests", "Look-ups of tile levels a cycle.", |m| {
            // A machine that cannot show foveated frames has the published unit.
            if m.of_type::<FoveaSpec>().accumulators == 0 {
                1.0
            } else {
                f64::from(m.of_type::<FoveaSpec>().level_tests)
            }
        }),
        part(
            "batches",
            "Bits of the batches that are asked for: 64 and one for each record, `ccu.queue` \
             times.",
            |m| {
                f64::from(m.of_type::<CcuSpec>().queue)
                    * (REQUEST_BITS + f64::from(m.of_type::<CcuSpec>().batch))
            },
        ),
    ],
    waits: &[WaitDecl {
        name: "records",
        what: "records of Gaussians",
        short: "records from DRAM",
        because: "records of Gaussians were in DRAM or on their way",
        symbol: 'r',
        from: From::Memory,
    }],
    doubles: &[
        double(
            "ccu.units, their buffers",
            &["ccu.units", "buffers.gaussian-in.capacity", "buffers.tile-list.capacity"],
            &["A1"],
        ),
        double("ccu.intersection-units", &["ccu.intersection-units"], &["A2"]),
    ],
    omits: &[omit("box tests uneven within a batch of Gaussians", Bias::Optimistic, "A21")],
    behind: &["A1", "A2"],
    optional: table::OPTIONAL,
    excludes: table::EXCLUDES,
    check: Some(table::check),
    ..StageDecl::new(
        "ccu",
        "culling and conversion units (CCU)",
        Phase::Preprocessing,
        "Culling and Conversion Unit: reads the records of Gaussians, culls, projects to \
         the screen, tests which tiles each one overlaps and writes the list of every \
         tile (preprocessing). Keys: `ccu`.",
    )
};

/// Bits of a request of a unit: address, length, place in the input buffer.
const REQUEST_BITS: f64 = 64.0;

/// Waits for records.
pub const RECORDS: Stall = Stall::of("records");

const CULL: ActionId = work_id("cull");
const PROJECT: ActionId = work_id("project");
const OBB_PREPARE: ActionId = work_id("obb-prepare");
const OBB_TEST: ActionId = work_id("obb-test");
const PIXEL_TEST: ActionId = work_id("pixel-test");
/// A colour; colour units make them too.
pub const SH_COLOUR_WORK: ActionId = work_id("sh-colour");
/// Records on their way from DRAM to the unit.
pub const GAUSSIAN_IN: BufferId = buffer_id("gaussian_in");
/// Splats and list entries on their way from the unit to DRAM.
pub const TILE_LIST: BufferId = buffer_id("tile_list");

/// The unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Ccu {
    /// The `[ccu]` table.
    pub spec: CcuSpec,
    /// Bytes of the records.
    pub record: RecordSpec,
    /// Records of a batch: `spec.batch`, or as many as fit the unit's input buffer.
    pub batch: u32,
    /// Its codebook.
    pub codebook: CodebookSpec,
    /// Banks of its share of the input buffer.
    pub input: Banks,
    /// Banks of its share of the tile-list buffer.
    pub output: Banks,
    /// Banks of its shares of the pointers and of the lines of lists, where there are such.
    pub lists: [Option<Banks>; 2],
    /// Bytes of a pointer.
    pub pointer: u64,
    /// Whether its tests are those of pixels.
    pub filters: bool,
    /// Bytes that the first read takes of every record, the second of every survivor, and the third
    /// of every splat with a tile.
    reads: [u64; READS],
    /// Bytes of levels beside the geometry in the record of a foveated frame; 0 in plain frames.
    pub level_bytes: u64,
    /// Bytes of levels beside a colour that is read apart; 0 in plain frames.
    pub level_colour_bytes: u64,
    /// Bytes of a list entry.
    pub entry: u64,
    /// Bytes that are written of a splat; in foveated frames features of second levels too, where
    /// the unit writes features.
    pub projected: u64,
    /// Operations of a colour of the scene's SH degree.
    colour_operations: u64,
    /// Operations a cycle.
    rate: Divisor,
    /// Of the engines for culling and for colours alone, where there are such.
    own: [Option<Divisor>; 2],
    /// Box tests a cycle.
    tests: Divisor,
    /// Look-ups of tile levels a cycle.
    levels: Divisor,
}

/// Reads of a batch, at most.
pub const READS: usize = 3;

/// Bytes of a tile in the table of levels.
const LEVEL_ENTRY: u64 = 2;
/// Box tests that take as many operations as the level of a tile: 94 over 48 (A16).
const LEVEL_AS_TESTS: u64 = 2;

impl Ccu {
    /// A unit with `share` bytes of the input buffer, for scenes of a degree and list entries of
    /// so many bytes; with `fovea` for foveated frames.
    pub(crate) fn new(
        spec: CcuSpec,
        (record, codebook, degree, entry): (RecordSpec, CodebookSpec, ShDegree, u64),
        fovea: Option<FoveaSpec>,
        share: u64,
        input: Banks,
        output: Banks,
    ) -> Self {
        let levels = fovea.as_ref().map_or(0, |fovea| 3 * fovea.record.0);
        let highest = u64::from(fovea.is_some());
        let (level_bytes, level_colour_bytes) = match spec.fetch {
            Fetch::Everything | Fetch::GeometryFirst => (highest + levels, 0),
            Fetch::VisibleColour => (highest, levels),
            Fetch::LazyColour => (highest, 0),
        };
        let geometry = record.geometry.0 + level_bytes;
        let (position, colour) = (record.position.0, record.colour.0 + level_colour_bytes);
        let reads = match spec.fetch {
            Fetch::Everything => [position + geometry + colour, 0, 0],
            Fetch::GeometryFirst => [position, geometry + colour, 0],
            Fetch::VisibleColour => [position, geometry, colour],
            Fetch::LazyColour => [position, geometry, 0],
        };
        let seconds = fovea.as_ref().map_or(0, |fovea| fovea.feature.0);
        let projected = match record.feature_source {
            FeatureSource::Ccu => record.projected.0 + seconds,
            FeatureSource::Nobody => record.projected.0,
        };
        let tests = Divisor::new(u64::from(spec.intersection_units));
        let per_cycle = Divisor::new(fovea.map_or(1, |fovea| u64::from(fovea.level_tests)));
        let rate = Divisor::new(u64::from(spec.operations_per_cycle));
        let engine = |rate: u32| (rate > 0).then(|| Divisor::new(u64::from(rate)));
        let engines = [spec.cull_operations_per_cycle, spec.colour_operations_per_cycle];
        let own = match spec.fetch {
            Fetch::LazyColour => 0,
            Fetch::Everything | Fetch::GeometryFirst | Fetch::VisibleColour => {
                colour::operations(&spec, degree)
            }
        };
        let mut ccu = Self {
            spec,
            record,
            codebook,
            batch: 1,
            input,
            output,
            lists: [None; 2],
            pointer: 0,
            filters: false,
            reads,
            level_bytes,
            level_colour_bytes,
            entry,
            projected,
            colour_operations: own,
            rate,
            own: engines.map(engine),
            tests,
            levels: per_cycle,
        };
        // All that a record may need must fit: a batch of which everything is needed must be held
        // (A3).
        let most = share / reads.iter().sum::<u64>().max(1);
        ccu.batch = ccu.spec.batch.min(u32::try_from(most).unwrap_or(u32::MAX)).max(1);
        ccu
    }

    /// The unit with its shares of the pointers (of so many bytes) and of the lines of lists.
    pub(crate) fn with_lists(self, lists: [Option<Banks>; 2], pointer: u64) -> Self {
        Self { lists, pointer, ..self }
    }

    /// The unit with tests of pixels in place of those of boxes.
    pub(crate) fn with_filter(self, filters: bool) -> Self {
        Self { filters, ..self }
    }

    /// Bytes of a read of a batch: 0 to 2, see [`Ccu`].
    #[inline]
    pub fn read(&self, batch: &Batch, read: usize) -> u64 {
        match (batch.pass, read) {
            (Pass::Scatter, 0) => batch.splats * self.projected,
            (Pass::Scatter, _) => 0,
            (Pass::Whole | Pass::Count, 0) => {
                self.reads[0] * batch.records + self.spec.cluster.0 * batch.clusters
            }
            (Pass::Whole | Pass::Count, _) => {
                self.reads[read] * [batch.records, batch.survivors, batch.splats][read]
            }
        }
    }

    /// Bounds of clusters that are read in a batch: as many bytes as the positions of one.
    pub fn cluster_tests(&self) -> u64 {
        u64::from(self.batch) * self.reads[0] / self.spec.cluster.0.max(1)
    }

    /// The largest batch of a pass, as far as it is known before anything of it is read.
    pub fn largest(&self, pass: Pass) -> Batch {
        let records = u64::from(self.batch);
        let tests = self.spec.clusters > 0 && pass != Pass::Scatter;
        let bounds = if tests { self.spec.cluster.0 } else { 0 };
        // At least one bound is read at a time, even if it is larger than the positions of a batch.
        let records = records.max(bounds.div_ceil(self.reads[0].max(1)));
        let splats = if pass == Pass::Scatter { records } else { 0 };
        Batch { records, splats, pass, ..Batch::default() }
    }

    /// Bytes of all reads of a batch.
    pub fn read_bytes(&self, batch: &Batch) -> u64 {
        (0..READS).map(|read| self.read(batch, read)).sum()
    }

    /// Bytes that reads of a batch from `from` on may bring, when `known` reads have arrived: who
    /// survives is known with the first, who has a tile with the second.
    #[inline]
    pub fn may_read(&self, batch: &Batch, known: usize, from: usize) -> u64 {
        if batch.pass == Pass::Scatter {
            return 0;
        }
        let counts = [batch.records, batch.survivors, batch.splats];
        // What is not known yet may be as many as the last count that is.
        let most = counts.iter().skip(known).fold(0, |most, &n| n.max(most));
        let of = |read: usize| if read > known { most } else { counts[read] };
        (from..READS).map(|read| self.reads[read] * of(read)).sum()
    }

    /// Records of a batch whose colours are evaluated here.
    fn coloured(&self, batch: &Batch) -> u64 {
        match self.spec.fetch {
            Fetch::Everything | Fetch::GeometryFirst => batch.survivors,
            Fetch::VisibleColour => batch.splats,
            Fetch::LazyColour => 0,
        }
    }

    /// Colours of a batch that are looked up here.
    fn lookups_of(&self, batch: &Batch) -> u64 {
        if batch.pass == Pass::Scatter { 0 } else { self.coloured(batch) }
    }

    /// Operations of a batch without its box tests: of culling, projection and boxes, colours.
    fn operations(&self, batch: &Batch) -> [u64; 3] {
        let o = &self.spec.operations;
        let boxes = batch.prepared * u64::from(o.obb_prepare);
        if batch.pass == Pass::Scatter {
            return [0, boxes, 0];
        }
        [
            (batch.records + batch.clusters) * u64::from(o.cull),
            batch.survivors * u64::from(o.project) + boxes,
            self.coloured(batch) * self.colour_operations,
        ]
    }

    /// Cycles of the arithmetic of a batch: of the engine that takes the longest.
    fn arithmetic(&self, batch: &Batch) -> u64 {
        let [cull, project, colour] = self.operations(batch);
        let (mut shared, mut longest) = (project, 0);
        for (operations, own) in [cull, colour].into_iter().zip(self.own) {
            match own {
                Some(rate) => longest = longest.max(rate.div_ceil(operations)),
                None => shared += operations,
            }
        }
        longest.max(self.rate.div_ceil(shared))
    }

    /// Bytes of the results of a batch: projected splats, list entries.
    fn results(&self, batch: &Batch) -> [u64; 2] {
        let (splats, entries) = (batch.splats * self.projected, batch.pairs * self.entry);
        match batch.pass {
            Pass::Whole => [splats, entries],
            Pass::Count => [splats, 0],
            Pass::Scatter => [0, entries],
        }
    }

    /// Bytes that a batch has in the tile-list buffer.
    pub fn held(&self, batch: &Batch) -> u64 {
        self.results(batch).iter().sum()
    }

    /// Bytes that a batch writes to DRAM.
    pub fn written(&self, batch: &Batch) -> u64 {
        let [splats, entries] = self.results(batch);
        splats + batch.lists.map_or(entries, |lists| lists.write)
    }

    /// Bytes that a batch reads before it writes.
    pub fn read_back(&self, batch: &Batch) -> u64 {
        batch.lists.map_or(0, |lists| lists.read)
    }

    /// Words of the input buffer that a batch fills: records lie back to back.
    fn input_words(&self, batch: &Batch) -> u64 {
        (0..READS).map(|read| self.input.words(self.read(batch, read))).sum()
    }

    /// Words of the tile-list buffer that a batch fills.
    fn output_words(&self, batch: &Batch) -> u64 {
        self.results(batch).into_iter().map(|bytes| self.output.words(bytes)).sum()
    }

    /// Words that a batch reads and writes of the pointers and of the lines of lists.
    fn list_words(&self, batch: &Batch) -> [(Option<&Banks>, [u64; 2]); 2] {
        let [pointers, lines] = self.lists.each_ref().map(Option::as_ref);
        let pointed = pointers.map_or(0, |b| b.words_of_records(batch.pairs, self.pointer));
        // The pass that counts touches pointers alone.
        let lined = lines.filter(|_| batch.pass != Pass::Count).map_or([0; 2], |banks| {
            let leaving = batch.lists.map_or(0, |lists| lists.write);
            [banks.words(leaving), banks.words_of_records(batch.pairs, self.entry)]
        });
        [(pointers, [pointed; 2]), (lines, lined)]
    }

    /// Charges the sum over the counters of `tiles` tiles, between two passes.
    pub(crate) fn charge_sum(&self, tiles: u64, actions: &mut ActionCounts) {
        let Some(banks) = &self.lists[0] else { return };
        let bytes = banks.words_of_records(tiles, self.pointer) * banks.word();
        actions.charge(Phase::Preprocessing, sram_read(lists::POINTERS), bytes);
        actions.charge(Phase::Preprocessing, sram_write(lists::POINTERS), bytes);
    }

    /// Charges the table of levels of `tiles` tiles, once a frame.
    pub(crate) fn charge_levels(&self, tiles: u64, actions: &mut ActionCounts) {
        let stage = Phase::Preprocessing;
        let bytes = self.output.words(tiles * LEVEL_ENTRY) * self.output.word();
        actions.charge(stage, OBB_TEST, LEVEL_AS_TESTS * tiles);
        actions.charge(stage, sram_write(TILE_LIST), bytes);
    }
}

impl Unit for Ccu {
    type Work = Batch;
    const STAGE: StageId = stage_id(CCU.key);

    #[inline]
    fn cycles(&self, batch: &Batch) -> u64 {
        let tested = batch.prepared.min(batch.records);
        let tests = self.tests.div_ceil(batch.tests).max(self.levels.div_ceil(batch.lookups));
        let untested = if batch.pass == Pass::Scatter { 0 } else { batch.records - tested };
        // A tested splat holds the entry until its tests are issued, any other for a cycle (A21).
        let entry = untested + batch.clusters + tested.max(tests);
        entry
            .max(self.arithmetic(batch))
            .max(self.lookups_of(batch) * self.codebook.cycles())
            .max(1)
    }

    fn bank_stalls(&self, batch: &Batch) -> u64 {
        self.times(batch).1
    }

    /// Records stream through both buffers while the next ones arrive.
    #[inline]
    fn times(&self, batch: &Batch) -> (u64, u64) {
        let cycles = self.cycles(batch);
        let (input, output) = (self.input_words(batch), self.output_words(batch));
        let mut stalls = self.input.excess(input, input, cycles);
        stalls = stalls.max(self.output.excess(output, output, cycles));
        for (banks, [read, write]) in self.list_words(batch) {
            stalls = stalls.max(banks.map_or(0, |banks| banks.excess(read, write, cycles)));
        }
        (cycles, stalls)
    }

    fn charge(&self, batch: &Batch, actions: &mut ActionCounts) {
        let stage = Phase::Preprocessing;
        let converted = batch.pass != Pass::Scatter;
        if converted {
            actions.charge(stage, CULL, batch.records + batch.clusters);
            actions.charge(stage, PROJECT, batch.survivors);
        }
        actions.charge(stage, OBB_PREPARE, batch.prepared);
        let tested = if self.filters { PIXEL_TEST } else { OBB_TEST };
        actions.charge(stage, tested, batch.tests);
        let coloured = self.lookups_of(batch);
        actions.charge(stage, SH_COLOUR_WORK, coloured);
        let looked_up = self.codebook.bytes(coloured);
        actions.charge(stage, sram_read(colour::CODES), looked_up);
        // A single byte is the highest level alone: colours of further levels are then read by the
        // cores.
        if self.level_bytes > 1 || self.level_colour_bytes > 0 {
            actions.charge(stage, vru::PIXEL_FINISH, 3 * coloured);
        }
        if batch.lookups > 0 {
            let looked = self.output.words(batch.lookups * LEVEL_ENTRY) * self.output.word();
            actions.charge(stage, sram_read(TILE_LIST), looked);
        }
        let read = self.input_words(batch) * self.input.word();
        actions.charge(stage, sram_write(GAUSSIAN_IN), read);
        actions.charge(stage, sram_read(GAUSSIAN_IN), read);
        let written = self.output_words(batch) * self.output.word();
        actions.charge(stage, sram_write(TILE_LIST), written);
        actions.charge(stage, sram_read(TILE_LIST), written);
        let lists = [lists::POINTERS, lists::COMBINING].into_iter().zip(self.list_words(batch));
        for (buffer, (banks, [read, write])) in lists {
            let word = banks.map_or(0, Banks::word);
            actions.charge(stage, sram_read(buffer), read * word);
            actions.charge(stage, sram_write(buffer), write * word);
        }
    }
}
