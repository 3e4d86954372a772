//! Gradients (`training`, `gradients`; A146): a frame is a step of training.
//!
//! Each core has a gradient unit. With `gradients.behind` it takes a tile as soon as it is
//! rendered, from what its rendering units leave of each blend on chip, and rendering units wait
//! where they are two tiles ahead. Else the loss of the whole picture comes first, and then lists,
//! features and pixels are read once more and α is evaluated again. What a tile has for a Gaussian
//! is added to a sum in a cache that all cores share; a sum that is not there is fetched from
//! memory for another one. Gradients by parameters and the update follow
//! ([`steps`]).

use std::ops::Range;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::layout::AccessPattern;
use super::resolved::ResolvedUnits;
use super::vru::{ALPHA, FEATURE};
use super::{FrameContext, STREAMS, TileWise};
use crate::flow::steps::{self, StepPart, SteppedGaussians, TRAINING, TrainingSpec};
use crate::kernel::blocks::{BlockMove, BlockStream, MovedBlock};
use crate::kernel::stream::{StreamId, reads, writes};
use crate::kernel::{MemoKey, memory};
use crate::machine::check::{Found, RECORD_MAX, SIZE_MAX};
use crate::machine::{BufferSpec, Exclusion, KeyValues, Machine, Optional, Ports};
use crate::stage::{
    Bias, DRAM_READ, DRAM_WRITE, Measured, StageDecl, StatDecl, buffer, buffer_id, counted, double,
    omit, part, share, sram_read, sram_write, stage_id, work, work_id,
};
use crate::workload::cache::{CacheShape, SumCache};
use crate::workload::lanes::LaneMap;
use crate::workload::order::{TileOrder, tiles};
use crate::workload::{FrameWorkload, Geometry, TileWork};
use powergs_base::quantity::Bytes;
use powergs_dram::AddressRange;
use powergs_energy::action::{ActionCounts, ActionId, BufferId, Memory, Phase, StageId};

/// The `[gradients]` table: the units that find gradients by what was blended, and add them up.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct GradientsSpec {
    /// Whether a tile's gradients are found as soon as it is rendered, from α and transmittance of
    /// each blend, which are kept; else when the loss of the picture is known, with α evaluated
    /// again.
    pub behind: bool,
    /// Pixels of a core whose gradients by a Gaussian are worked on at a time; each takes
    /// `training.interval`.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "lanes"))]
    pub lanes: u32,
    /// Cycles of a core for what a tile has for a Gaussian, to be added to its sum.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "cycles"))]
    pub sum_cycles: u32,
    /// Operations of a core in a cycle for loss, gradients by parameters and update.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "operations/cycle"))]
    pub operations_per_cycle: u32,
    /// What is kept of a blend: α, transmittance, colour behind.
    pub kept: Bytes,
    /// Pixels of a tile that go forward and back together: of so many blends are kept.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "pixels"))]
    pub pixels: u32,
    /// Sums that a core has in flight from memory at a time: further ones wait for as long as
    /// an idle memory takes to answer.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "sums"))]
    pub misses: u32,
    /// Ways of a set of the cache of sums.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "ways"))]
    pub ways: u32,
    /// On chip: what is kept of two such groups of each core; what does not fit goes through the
    /// memory.
    pub buffer: BufferSpec,
    /// On chip: sums of Gaussians, for all cores; 0 B for none, and every addition goes through
    /// the memory. A core has its share of the accesses that the banks make in a cycle.
    pub cache: BufferSpec,
}

impl Default for GradientsSpec {
    /// What there is where the file says only the interval of the training (A146).
    fn default() -> GradientsSpec {
        let buffer = |kib: u64| BufferSpec {
            capacity: Bytes(kib << 10),
            word: Bytes(16),
            banks: 4,
            ports: Ports::ReadOrWrite,
        };
        GradientsSpec {
            behind: false,
            lanes: 16,
            sum_cycles: 1,
            operations_per_cycle: 128,
            kept: Bytes(16),
            pixels: 256,
            misses: 16,
            ways: 4,
            buffer: buffer(32),
            cache: buffer(32),
        }
    }
}

/// What gradient units declare.
pub const GRADIENTS: StageDecl = StageDecl {
    units: Some(|m| if trains(m) { m.tiles().vru.cores } else { 0 }),
    has_numbers: true,
    works: &[
        work("gradient-pixel", 60, "Gradients of one pixel by a Gaussian, all nine.")
            .a_cycle(lanes),
        work("gradient-sum", 9, "What a tile has for a Gaussian added to its sum.").a_cycle(sums),
        work("simt-operation", 1, "One operation of loss, gradients or update.")
            .a_cycle(operations),
    ],
    buffers: &[
        buffer("gradient_kept", "gradients.buffer", |m| {
            memory(m, |spec| spec.buffer.shared(m.tiles().vru.cores))
        })
        .full(),
        buffer("gradient_sums", "gradients.cache", |m| {
            let has_cache = m.of_type::<GradientsSpec>().has_cache();
            let memory = memory(m, |spec| spec.cache.shared(1));
            if has_cache { memory } else { Memory { bank: Bytes(0), banks: 0, ..memory } }
        })
        .full(),
    ],
    streams: &[
        reads(
            "reverse-in",
            "pictures, lists and features in reverse, and sums of gradients",
            &["results", "pixels", "gradients"],
            ["features", "lists"],
        )
        .scattered(),
        writes("gradients", "gradients by pixels, and sums", ["pixels", "results"]),
        reads(
            "step-in",
            "Gaussians, their gradients and moments",
            &["gradients"],
            ["records", "survivors"],
        )
        .of(Phase::Preprocessing),
        writes("step-out", "the same, updated", ["results", "pixels"]).of(Phase::Preprocessing),
    ],
    parts: &[
        part("lanes", "Lanes over the cycles of each: `training.interval`.", lanes),
        part("operations", "Operations a cycle: `gradients.operations-per-cycle`.", operations),
        part("sums", "Sums a cycle: the inverse of `gradients.sum-cycles`.", sums),
        part("misses", "Sums on their way: `gradients.misses`.", |m| {
            m.of_type::<GradientsSpec>().misses.into()
        }),
        part("ways", "Tags that are compared for a sum: `gradients.ways`.", |m| {
            m.of_type::<GradientsSpec>().ways.into()
        }),
    ],
    stats: &[&steps::LOSS, &steps::REVERSE, &steps::CHAIN, &steps::UPDATE, &SUM_HITS],
    also_waits: &["features"],
    after: Some("vru"),
    input: "tiles from rendering units",
    doubles: &[
        double("gradients.lanes", &["gradients.lanes"], &["A146"]),
        double("gradients.cache", &["gradients.cache.capacity"], &["A146"]),
        double("gradients.misses", &["gradients.misses"], &["A146"]),
    ],
    omits: &[
        omit("two cores that add to the sum of one Gaussian at once", Bias::Optimistic, "A146")
            .by("training.interval > 0", trains),
        omit(
            "densification: Gaussians that are cloned, split and removed",
            Bias::Optimistic,
            "A146",
        )
        .by("training.densify = 0", |m| trains(m) && m.of_type::<TrainingSpec>().densify == 0),
    ],
    behind: &["A146"],
    optional: OPTIONAL,
    excludes: EXCLUDES,
    check: Some(check),
    ..StageDecl::new(
        "gru",
        "gradient units (GRU)",
        Phase::Rendering,
        "Gradients of pixels by the Gaussians that they blend, added up for each Gaussian; then \
         gradients by parameters and their update. Keys: `training`, `gradients`.",
    )
};

fn trains(m: &Machine) -> bool {
    m.of_type::<TrainingSpec>().interval > 0
}

fn lanes(m: &Machine) -> f64 {
    let cycles = m.of_type::<TrainingSpec>().interval.max(1);
    f64::from(m.of_type::<GradientsSpec>().lanes) / f64::from(cycles)
}

fn operations(m: &Machine) -> f64 {
    m.of_type::<GradientsSpec>().operations_per_cycle.into()
}

fn sums(m: &Machine) -> f64 {
    f64::from(m.of_type::<GradientsSpec>().sum_cycles.max(1)).recip()
}

fn memory(m: &Machine, of: impl Fn(&GradientsSpec) -> Memory) -> Memory {
    let memory = of(m.of_type());
    match trains(m) {
        true => memory,
        false => Memory { bank: Bytes(0), banks: 0, ..memory },
    }
}

/// The units.
pub const GRU: StageId = stage_id("gru");
const GRADIENT: ActionId = work_id("gradient-pixel");
const OPERATION: ActionId = work_id("simt-operation");
const SUM: ActionId = work_id("gradient-sum");
const KEPT: BufferId = buffer_id("gradient_kept");
const SUMS: BufferId = buffer_id("gradient_sums");

const REVERSE: [StreamId; 2] = [STREAMS.id("reverse-in"), STREAMS.id("gradients")];
const PARAMETERS: [StreamId; 2] = [STREAMS.id("step-in"), STREAMS.id("step-out")];

/// What a part of a step reads and writes.
pub(super) const fn streams(part: StepPart) -> [StreamId; 2] {
    match part {
        StepPart::Loss | StepPart::Reverse => REVERSE,
        StepPart::Chain | StepPart::Update => PARAMETERS,
    }
}

/// What the sums of a frame depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SumKey {
    geometry: Geometry,
    order: TileOrder,
    shape: CacheShape,
}

impl MemoKey for SumKey {
    type Value = FrameSums;
    const MOST: usize = 8;
}

impl SumKey {
    /// Of a machine; `None` where it does not train.
    pub fn of(machine: &TileWise) -> Option<SumKey> {
        let (t, g) = (&machine.training, &machine.gradients);
        let shape = CacheShape::new(g.cache.capacity, t.record, g.ways);
        let (geometry, order) = (machine.geometry, machine.schedule.order);
        (t.interval > 0).then_some(SumKey { geometry, order, shape })
    }
}

/// The sums of a tile.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TileSums {
    /// Gaussians that a pixel of it blends.
    pub met: u64,
    /// Those whose sums are fetched, and those that leave for them: positions in
    /// [`FrameSums::moved`].
    pub moved: [Range<u32>; 2],
}

/// The sums of the Gaussians of a frame.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FrameSums {
    /// Tile by tile, row by row.
    pub tiles: Vec<TileSums>,
    /// Slots of Gaussians whose sums are fetched, and of those whose sums are written.
    pub moved: [Vec<u32>; 2],
    /// Gaussians with a sum.
    pub touched: u64,
    /// Sums that are in the cache at the end.
    pub left: u64,
}

impl GradientsSpec {
    /// Whether there is a cache of sums.
    pub fn has_cache(&self) -> bool {
        self.cache.capacity.0 > 0
    }

    /// Cycles of a core for additions to sums of `record` bytes, when all cores have their
    /// share of the banks: a sum is read and written back.
    fn through_banks(&self, additions: u64, record: u64, cores: u64) -> u64 {
        let accesses = match self.cache.ports {
            Ports::ReadOrWrite => 2,
            Ports::ReadAndWrite => 1,
        };
        let words = additions * record.div_ceil(self.cache.word.0.max(1)) * accesses;
        (words * cores).div_ceil(u64::from(self.cache.banks.max(1)))
    }
}

/// Additions to sums in the cache.
pub const ADDITIONS: StatDecl = counted("step.additions", "");
/// Those of them whose sum it has.
pub const FOUND_SUMS: StatDecl = counted("step.found_sums", "");
const SUM_HITS: StatDecl = share(
    "step.sum_hit_frac",
    &FOUND_SUMS,
    &[&ADDITIONS],
    "Share of the additions to sums of Gaussians whose sum is in the cache, 0 to 1.",
);

impl FrameSums {
    /// What is reported of additions, and of those of them whose sum the cache has.
    pub fn measured(&self) -> Measured {
        let additions: u64 = self.tiles.iter().map(|tile| tile.met).sum();
        let found = additions - self.moved[0].len() as u64;
        Measured::of(&[(&ADDITIONS, additions), (&FOUND_SUMS, found)])
    }

    /// Adds up a frame, tiles in the order of the schedule, each from the back.
    pub fn new(workload: &FrameWorkload, key: &SumKey) -> FrameSums {
        let all = 0..workload.tiles.len();
        let met: Vec<Vec<u32>> = all.into_par_iter().map(|tile| met(workload, tile)).collect();
        let records = workload.slot.iter().filter(|slot| **slot != u32::MAX).count();
        let mut cache = SumCache::new(key.shape, records);
        let mut sums = FrameSums::default();
        sums.tiles.resize(workload.tiles.len(), TileSums::default());
        // One tile after the other: all cores share the cache, and what it holds depends on their
        // order.
        for tile in tiles(workload.tiles_x, workload.tiles_y, key.order) {
            let before = [0, 1].map(|way: usize| sums.moved[way].len() as u32);
            let own = &met[tile as usize];
            for &slot in own {
                let added = cache.add(slot);
                sums.touched += u64::from(added.is_first);
                sums.moved[0].extend(added.is_fetched.then_some(slot));
                sums.moved[1].extend(added.leaves);
            }
            let moved = [0, 1].map(|way: usize| before[way]..sums.moved[way].len() as u32);
            sums.tiles[tile as usize] = TileSums { met: own.len() as u64, moved };
        }
        sums.left = cache.held();
        sums
    }
}

/// Slots of the Gaussians that pixels of a tile blend, from the back.
fn met(workload: &FrameWorkload, tile: usize) -> Vec<u32> {
    let work = &workload.tiles[tile];
    let map = LaneMap::new(workload, tile);
    let last = map.all_stops().max().unwrap_or(0).min(work.entries);
    let list = workload.list_of(work);
    let is_met = |at: &u32| {
        let mut blends = false;
        map.blends(*at, |_, _| blends = true);
        blends
    };
    let slot = |at: u32| workload.slot[list[at as usize] as usize];
    (0..last).rev().filter(is_met).map(slot).collect()
}

/// Pairs of a tile that have gradients: the entry that stops a pixel is counted with the blends,
/// and leaves nothing.
fn gradients(tile: &TileWork) -> u64 {
    tile.blends - u64::from(tile.stopped)
}

/// The gradient units of a machine.
#[derive(Debug, Clone)]
pub struct GradientUnits {
    /// What a step is.
    pub training: TrainingSpec,
    /// The units.
    pub spec: GradientsSpec,
    /// Cycles in which an idle memory answers.
    pub answer: u64,
}

impl GradientUnits {
    /// Of a machine; `None` where it does not train.
    pub(super) fn of(machine: &Machine) -> Option<GradientUnits> {
        let m = machine.tiles();
        (m.training.interval > 0).then(|| GradientUnits {
            training: m.training.clone(),
            spec: m.gradients.clone(),
            answer: memory::answers_in(&machine.memory()),
        })
    }
}

/// What the gradient units of a machine do in a frame.
pub(super) struct GradientWork<'a> {
    workload: &'a FrameWorkload,
    training: TrainingSpec,
    spec: GradientsSpec,
    /// Cycles in which an idle memory answers.
    answer: u64,
    sums: &'a FrameSums,
    gaussians: SteppedGaussians,
    cores: usize,
    /// Bytes of a list entry, of its features, and of a pixel.
    entry: u64,
    feature: u64,
    pixel: u64,
}

impl<'a> GradientWork<'a> {
    /// Of a frame; `None` on machines that do not train.
    pub(super) fn new(
        workload: &'a FrameWorkload,
        units: &ResolvedUnits,
        context: &FrameContext<'a>,
    ) -> Option<GradientWork<'a>> {
        let (sums, resolved) = (context.sums?, units.gradients.as_ref()?);
        let GradientUnits { training, spec, answer } = resolved;
        let record = &units.ccu.record;
        let geometry = record.position.0 + record.geometry.0;
        Some(GradientWork {
            workload,
            training: training.clone(),
            spec: spec.clone(),
            answer: *answer,
            sums,
            gaussians: SteppedGaussians {
                points: workload.counters.points,
                visible: workload.slot.iter().filter(|slot| **slot != u32::MAX).count() as u64,
                sums: sums.touched,
                stored: [geometry, geometry + record.colour.0],
                numbers: SteppedGaussians::numbers_of(workload.sh_degree),
            },
            cores: units.vru.spec.cores as usize,
            entry: units.ccu.entry,
            feature: record.feature.0,
            pixel: record.pixel.0,
        })
    }

    /// Cores of the machine.
    pub(super) fn cores(&self) -> usize {
        self.cores
    }

    /// Whether tiles are taken as soon as they are rendered.
    pub(super) fn is_behind(&self) -> bool {
        self.spec.behind
    }

    /// Items of a unit of a part in a cycle.
    pub(super) fn rate(&self, part: StepPart) -> u64 {
        match part {
            StepPart::Reverse => 1,
            _ => self.spec.operations_per_cycle.into(),
        }
    }

    /// What is kept of the blends of a tile and does not fit.
    fn spilled(&self, tile: &TileWork) -> u64 {
        // Two groups are kept at a time: one goes forward, the other back (A146).
        let room = self.spec.buffer.capacity.0 / self.cores as u64 / 2;
        // Blends are taken to be spread evenly over the groups.
        let groups = u64::from(tile.pixels.div_ceil(self.spec.pixels)).max(1);
        (gradients(tile) * self.spec.kept.0).saturating_sub(groups * room)
    }

    /// Bytes of lists, pixels and what is kept that a tile reads one after the other; those of
    /// features and sums lie apart.
    fn run(&self, tile: &TileWork) -> u64 {
        match self.spec.behind {
            true => u64::from(tile.pixels) * self.pixel + self.spilled(tile),
            false => {
                let (loaded, pixels) = (u64::from(tile.loaded), u64::from(tile.pixels));
                loaded * self.entry + pixels * self.training.state.0
            }
        }
    }

    /// Features that a tile reads once more.
    fn features(&self, tile: &TileWork) -> u64 {
        if self.spec.behind { 0 } else { tile.loaded.into() }
    }

    /// A tile in reverse; its items are cycles.
    pub(super) fn tile(&self, tile: u32) -> MovedBlock {
        let (work, sums) = (&self.workload.tiles[tile as usize], &self.sums.tiles[tile as usize]);
        let loss = match self.spec.behind {
            true => u64::from(work.pixels) * u64::from(self.training.loss),
            false => 0,
        };
        let lanes = self.pairs(work) * u64::from(self.training.interval);
        let record = self.training.record.0;
        let fetched = sums.moved[0].len() as u64;
        let banks = match self.spec.has_cache() {
            true => self.spec.through_banks(sums.met, record, self.cores as u64),
            false => 0,
        };
        let cycles = lanes
            .div_ceil(u64::from(self.spec.lanes))
            .max(sums.met * u64::from(self.spec.sum_cycles))
            .max(banks)
            // A core has that many in flight, each for as long as the memory takes.
            .max((fetched * self.answer).div_ceil(u64::from(self.spec.misses)))
            .max(loss.div_ceil(u64::from(self.spec.operations_per_cycle)));
        let [fetched, left] = [0, 1].map(|way: usize| sums.moved[way].len() as u64 * record);
        // Written while the tile is rendered, and read again with the rest of its `run`.
        let spilled = if self.spec.behind { self.spilled(work) } else { 0 };
        MovedBlock {
            items: cycles,
            read: self.run(work) + self.features(work) * self.feature + fetched,
            write: spilled + left,
        }
    }

    /// Pairs of a pixel and a Gaussian that lanes take of a tile.
    fn pairs(&self, tile: &TileWork) -> u64 {
        if self.spec.behind { gradients(tile) } else { tile.alpha_evaluations }
    }

    /// What a tile reads or writes lies here; its bytes from `run` on are of these.
    pub(super) fn pattern(&self, tile: u32, ask: BlockMove, run: AddressRange) -> AccessPattern {
        let work = &self.workload.tiles[tile as usize];
        let sums = self.sums.tiles[tile as usize].moved[ask.way].clone();
        let record = self.training.record.0;
        let features = if ask.way == 0 { self.features(work) } else { 0 };
        let apart = features * self.feature + sums.len() as u64 * record;
        AccessPattern::Gradients {
            run: AddressRange { bytes: run.bytes - apart, ..run },
            list: (u64::from(work.list_start), features),
            way: ask.way,
            sums: (sums.start, sums.end),
        }
    }

    /// What the units of a part do, block by block; tiles in reverse are not here.
    pub(super) fn blocks(&self, part: StepPart) -> Vec<Vec<MovedBlock>> {
        let mut blocks = match part {
            StepPart::Loss | StepPart::Reverse => vec![Vec::new(); self.cores],
            StepPart::Chain => self.training.chain(&self.gaussians, self.cores),
            StepPart::Update => self.training.update(&self.gaussians, self.cores),
        };
        match part {
            StepPart::Loss if !self.spec.behind => {
                for (i, tile) in self.workload.tiles.iter().enumerate() {
                    let pixels = u64::from(tile.pixels);
                    blocks[i % self.cores].push(MovedBlock {
                        items: pixels * u64::from(self.training.loss),
                        read: 2 * pixels * self.pixel,
                        write: pixels * self.training.state.0,
                    });
                }
            }
            StepPart::Chain => {
                // What the cache has goes to memory, where all sums are then.
                let write = self.sums.left * self.training.record.0;
                blocks[0].insert(0, MovedBlock { write, ..MovedBlock::default() });
            }
            _ => {}
        }
        blocks
    }

    /// All tiles in reverse.
    fn tiles(&self) -> Vec<MovedBlock> {
        (0..self.workload.tiles.len() as u32).map(|tile| self.tile(tile)).collect()
    }

    /// Bytes that a part reads and writes.
    pub(super) fn bytes(&self, part: StepPart) -> [u64; 2] {
        match part {
            StepPart::Reverse => BlockStream::bytes(&self.tiles()),
            _ => BlockStream::bytes(&self.blocks(part).concat()),
        }
    }

    /// Bytes of a sum.
    pub(super) fn record(&self) -> u64 {
        self.training.record.0
    }

    /// Sums that are fetched and written.
    pub(super) fn moved(&self) -> &'a [Vec<u32>; 2] {
        &self.sums.moved
    }

    /// α that are evaluated again.
    pub(super) fn again(&self) -> u64 {
        match self.spec.behind {
            true => 0,
            false => self.workload.tiles.iter().map(|tile| tile.alpha_evaluations).sum(),
        }
    }

    /// Charges what they do.
    pub(super) fn charge(&self, all: &mut ActionCounts) {
        let record = self.training.record.0;
        let sum = |of: fn(&TileWork) -> u64| self.workload.tiles.iter().map(of).sum::<u64>();
        let (blends, pixels) = (sum(gradients), sum(|tile| tile.pixels.into()));
        let met: u64 = self.sums.tiles.iter().map(|tile| tile.met).sum();
        let [fetched, left] = [0, 1].map(|way: usize| self.sums.moved[way].len() as u64);
        let stage = Phase::Rendering;
        all.charge(stage, GRADIENT, blends);
        all.charge(stage, ALPHA, self.again());
        all.charge(stage, SUM, met);
        all.charge(stage, OPERATION, pixels * u64::from(self.training.loss));
        if self.spec.has_cache() {
            all.charge(stage, sram_read(SUMS), (met + left + self.sums.left) * record);
            all.charge(stage, sram_write(SUMS), (met + fetched) * record);
        }
        let features = sum(|tile| tile.loaded.into());
        let (kept, features) = match self.spec.behind {
            true => (blends * self.spec.kept.0 + pixels * (self.pixel + self.training.state.0), 0),
            false => (
                features * self.entry + pixels * (2 * self.pixel + self.training.state.0),
                features * self.feature,
            ),
        };
        for (buffer, bytes) in [(KEPT, kept), (FEATURE, features)] {
            all.charge(stage, sram_read(buffer), bytes);
            all.charge(stage, sram_write(buffer), bytes);
        }
        for part in StepPart::ALL {
            let [read, write] = self.bytes(part);
            all.charge(part.phase(), DRAM_READ, read);
            all.charge(part.phase(), DRAM_WRITE, write);
        }
        for part in [StepPart::Chain, StepPart::Update] {
            let blocks = self.blocks(part).concat();
            let operations = blocks.iter().map(|block| block.items).sum();
            // What comes from memory and goes there passes through their buffers.
            let bytes = BlockStream::bytes(&blocks).into_iter().sum();
            all.charge(part.phase(), OPERATION, operations);
            all.charge(part.phase(), sram_read(KEPT), bytes);
            all.charge(part.phase(), sram_write(KEPT), bytes);
        }
    }
}

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[
    TRAINING,
    Optional {
        what: "gradient units",
        switch: "training.interval",
        keys: &["gradients"],
        with: &["training.interval=2", "gradients.behind=true"],
        is_there: |m| m.of_type::<TrainingSpec>().interval > 0,
    },
];

/// What its choices exclude.
pub(super) const EXCLUDES: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Not("training.interval", &["0"]),
        off: "0",
        other: KeyValues::Not("stereo.impl", &["separate"]),
        instead: "separate",
        because: "a step has one view",
    },
    Exclusion {
        choice: KeyValues::Not("training.interval", &["0"]),
        off: "0",
        other: KeyValues::Not("pixels.impl", &["all", "sampled"]),
        instead: "all",
        because: "pixels without blends have no gradients",
    },
    Exclusion {
        choice: KeyValues::Not("training.interval", &["0"]),
        off: "0",
        other: KeyValues::Is("schedule.overlap", &["frames"]),
        instead: "tiles",
        because: "a step begins with what the one before has updated",
    },
    Exclusion {
        choice: KeyValues::Not("training.interval", &["0"]),
        off: "0",
        other: KeyValues::Is("gsu.impl", &["update", "none", "last", "shared"]),
        instead: "split",
        because: "a step goes through lists of its own, in depth order",
    },
    Exclusion {
        choice: KeyValues::Not("training.interval", &["0"]),
        off: "0",
        other: KeyValues::Is("vru.termination", &["none"]),
        instead: "subtile",
        because: "gradients need an order",
    },
];

/// Steps of training.
pub(super) fn check(machine: &Machine, found: &mut Found) {
    let m = machine.tiles();
    let (t, g) = (&m.training, &m.gradients);
    if t.interval == 0 {
        return;
    }
    let sizes =
        [("training.state", t.state), ("training.record", t.record), ("gradients.kept", g.kept)];
    for (key, bytes) in sizes {
        if !(1..=RECORD_MAX.0).contains(&bytes.0) {
            found.add(key, format!("`{key}` = {bytes} must be from 1 B to {RECORD_MAX}"));
        }
    }
    let buffers = [
        ("gradients.buffer.capacity", "gradients.buffer.word", &g.buffer),
        ("gradients.cache.capacity", "gradients.cache.word", &g.cache),
    ];
    for (capacity, word, buffer) in buffers {
        // Without a cache there are no sums on chip.
        let least = u64::from(capacity != "gradients.cache.capacity");
        if !(least..=SIZE_MAX.0).contains(&buffer.capacity.0) {
            let message =
                format!("`{capacity}` = {} must be from {least} B to {SIZE_MAX}", buffer.capacity);
            found.add(capacity, message);
        } else if buffer.capacity.0 > 0 && !(1..=buffer.capacity.0).contains(&buffer.word.0) {
            let message = format!(
                "`{word}` = {} must be from 1 B to the capacity, {}",
                buffer.word, buffer.capacity
            );
            found.add(word, message);
        }
    }
}
