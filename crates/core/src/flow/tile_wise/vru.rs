//! Volume Rendering Unit (VRU): blends the depth-sorted Gaussians of one tile, sub-tile by
//! sub-tile.
//!
//! Timing rule: a core has `units_per_core` units that hold `pixels_per_unit` pixels each and
//! rotate them through one pipeline, one pixel a cycle, so that the recurrence of transmittance
//! never stalls it. All units of a core work on the same (Gaussian, sub-tile) pair, which takes
//! `ceil(subtile² / (units pixels)) pixels` cycles: 4 for 8x8 pixels on 16 units of 2x2. With
//! sub-tile skipping only pairs whose bitmap bit is set are executed, and none after the last pixel
//! of a sub-tile has stopped. An entry takes at least one cycle to leave the feature buffer (A26).
//!
//! With `vru.impl = "parallel"` every sub-tile has its own share of the units and a queue in front
//! of it; with `"swap"` and `"scan"` all units take one sub-tile after the other, and the change
//! costs; what a chunk then takes is measured entry by entry ([`subtiles`]).
//!
//! A tile opens in a cycle (`rtl/vru.sv`; none with `vru.tile-overlap`). Its last chunk also drains
//! the pipeline, `latency` cycles, and finishes the pixels, one a cycle in each unit; the next tile
//! enters after that (A27). A tile without chunks opens and finishes its pixels.
//!
//! **Two levels.** In a foveated frame some tiles blend two levels. Their chunks bring colour and
//! opacity of the second one along, for the entries that it has. With `fovea.accumulators` = 2 both
//! levels are blended in the same slot; with 1 a pair that both levels need holds the units twice.
//! α differs between the levels by the opacity alone: one more of the 13 operations (A16).
//!
//! Source: `gscore`, `nerarch-sim` (64 units of 2x2 pixels, 192 cycles).

mod table;

use super::{BufferSpecs, RecordSpec};
use crate::flow::tile_wise::subtiles;
use crate::flow::tile_wise::subtiles::{ChunkRun, Discipline};
use crate::kernel::bank::Banks;
use crate::kernel::stream::{reads, writes};
use crate::kernel::unit::Unit;
use crate::machine::Machine;
use crate::stage::{
    Bias, From, StageDecl, Stall, WaitDecl, buffer, buffer_id, double, omit, part, sram_read,
    sram_write, stage_id, work, work_id,
};
use crate::workload::Geometry;
use crate::workload::lanes::test_units;
use crate::workload::{ChunkWork, PairWork, TileWork};
use powergs_energy::action::{ActionCounts, ActionId, BufferId, Phase, StageId};

pub use table::{FoveaSpec, Termination, VruImpl, VruSpec};

/// What the unit declares.
pub const VRU: StageDecl = StageDecl {
    units: Some(|m| {
        m.of_type::<VruSpec>().cores.saturating_mul(m.of_type::<VruSpec>().units_per_core)
    }),
    has_numbers: true,
    has_lanes: true,
    works: &[
        work("alpha", 13, "One α evaluated for one live pixel, whether or not it contributes.")
            .a_cycle(|_| 1.0),
        work(
            "stopped-pixel",
            13,
            "One slot of a pixel that has stopped, or is outside of the image, in a pair that is \
             worked on; the price of `alpha` without.",
        )
        .priced_as("alpha"),
        work("blend", 11, "One blend of a splat into one pixel.").a_cycle(|_| 1.0),
        work("weight", 12, "One weight made of a depth, where nobody sorts.").priced_as("alpha"),
        work("normalise", 4, "One pixel divided by the sum of its weights.")
            .priced_as("pixel-finish"),
        work("pixel-finish", 6, "One pixel finished: background added and written out."),
        work(
            "queue-entry",
            0,
            "One feature record pushed into a queue in front of rendering units, and taken out.",
        ),
    ],
    buffers: &[
        buffer("feature", "buffers.feature", |m| {
            m.of_type::<BufferSpecs>().feature.shared(m.of_type::<VruSpec>().cores)
        }),
        buffer("pixel_out", "buffers.pixel-out", |m| {
            m.of_type::<BufferSpecs>().pixel_out.shared(m.of_type::<VruSpec>().cores)
        }),
    ],
    streams: &[
        reads(
            "features",
            "features and colours of a chunk",
            &["results"],
            ["colours", "survivors"],
        )
        .scattered(),
        writes("pixels", "pixels of a tile", ["spill-out", "results"]),
    ],
    parts: &[
        part("blend", "Blends a cycle: accumulators / (1 + `vru.blend-stall`).", |m| {
            f64::from(m.of_type::<FoveaSpec>().accumulators.max(1))
                / (1.0 + f64::from(m.of_type::<VruSpec>().blend_stall))
        }),
        part(
            "pixels",
            "Bits of the pixels that are held: `vru.pixel-state` each, for every accumulator, \
             twice where tiles overlap, and twice where pixels are swapped.",
            pixel_bits,
        ),
        part(
            "recurrence",
            "`vru.entries-per-cycle` over `vru.recurrence`: a shorter loop through the \
             transmittance.",
            |m| {
                let vru = m.of_type::<VruSpec>();
                let entries = match vru.implementation {
                    VruImpl::Pixels => vru.entries_per_cycle,
                    _ => 1,
                };
                f64::from(entries) / f64::from(vru.recurrence)
            },
        ),
        part(
            "queue",
            "Bits of feature records: 152 of the one of a unit, and its share of the core's \
             queues.",
            |m| {
                let bits = 8.0 * m.of_type::<RecordSpec>().feature.0 as f64;
                let entries = f64::from(m.of_type::<VruSpec>().subtile_queue) * queues(m);
                RECORD_BITS + entries * bits / f64::from(m.of_type::<VruSpec>().units_per_core)
            },
        ),
    ],
    waits: &[
        WaitDecl {
            name: "features",
            what: "feature loads",
            short: "features from DRAM",
            because: "features or colours were in DRAM or on their way",
            symbol: 'f',
            from: From::Memory,
        },
        WaitDecl {
            name: "colours",
            what: "colours of chunks",
            short: "colours",
            because: "colour units had not evaluated the colours of a chunk that was there",
            symbol: 'c',
            from: From::Stage("colour"),
        },
    ],
    also_waits: &["list", "spill"],
    after: Some("bsu"),
    input: "sorted chunks from the GSU",
    doubles: &[
        double("vru.units-per-core", &["vru.units-per-core"], &["A84"]),
        double(
            "vru.cores, their buffers",
            &[
                "vru.cores",
                "buffers.sorting.capacity",
                "buffers.feature.capacity",
                "buffers.pixel-out.capacity",
            ],
            &["A84", "A29"],
        ),
        double("buffers.feature", &["buffers.feature.capacity"], &["A32"]),
    ],
    omits: &[
        omit("deeper prefetch while nobody knows that a tile is done", Bias::Either, "A30"),
        omit(
            "the change of all units of a core from one sub-tile to another: pixel state, features",
            Bias::Optimistic,
            "A86",
        )
        .by("vru.impl = \"serial\"", |m| m.of_type::<VruSpec>().implementation == VruImpl::Serial),
        omit(
            "the search for the live pixels of an entry, and their packing",
            Bias::Optimistic,
            "A130",
        )
        .by("vru.impl = \"pixels\" or \"quads\"", |m| {
            let units = m.of_type::<VruSpec>().implementation;
            matches!(units, VruImpl::Pixels | VruImpl::Quads)
        }),
        omit("pairs that begin before a stop is known", Bias::Optimistic, "A88")
            .by("vru.stop-latency = 0", |m| m.of_type::<VruSpec>().stop_latency == 0),
    ],
    behind: &["A84", "A27"],
    optional: table::OPTIONAL,
    excludes: table::EXCLUDES,
    check: Some(table::check),
    ..StageDecl::new(
        "vru",
        "volume rendering units (VRU)",
        Phase::Rendering,
        "Volume Rendering Unit: blends the sorted Gaussians of a tile into its pixels, \
         sub-tile by sub-tile. It is an array of volume rendering cores (VRC); `vru x64` \
         counts those of the whole machine. Keys: `vru`.",
    )
};

/// What test units and row generators declare: they stand between the feature buffer and the queues
/// of rendering units (`vru.impl` = `leaders`, `rows`), whose timing they are a part of.
pub const FRONTS: StageDecl = StageDecl {
    units: Some(|m| {
        let vru = m.of_type::<VruSpec>();
        let of_core = match vru.implementation {
            VruImpl::Leaders => test_units(m.of_type::<Geometry>().subtiles_per_side()),
            VruImpl::Rows => vru.units_per_core,
            _ => 0,
        };
        vru.cores.saturating_mul(of_core)
    }),
    within: Some("vru"),
    works: &[
        work("leader", 13, "One α evaluated at a leader pixel of a mini-tile.")
            .a_cycle(|m| match m.of_type::<VruSpec>().implementation {
                VruImpl::Leaders => f64::from(m.of_type::<VruSpec>().leaders_per_cycle),
                _ => 0.0,
            })
            .priced_as("alpha"),
        work("row", 13, "The ends of the ellipse of a Gaussian found in one row of pixels.")
            .a_cycle(|m| match m.of_type::<VruSpec>().implementation {
                VruImpl::Rows => 1.0,
                _ => 0.0,
            })
            .priced_as("alpha"),
    ],
    parts: &[part(
        "lanes",
        "Pixels that one looks at in a cycle: `vru.leaders-per-cycle`, or 1 of a row generator.",
        |m| match m.of_type::<VruSpec>().implementation {
            VruImpl::Leaders => f64::from(m.of_type::<VruSpec>().leaders_per_cycle),
            _ => 1.0,
        },
    )],
    behind: &["A128", "A129"],
    ..StageDecl::new(
        "fronts",
        "test units and row generators",
        Phase::Rendering,
        "In front of rendering units: leader tests of 2x2 mini-tiles (`vru.impl = \"leaders\"`), \
         or generators of rows (`\"rows\"`). Keys: `vru.leaders-per-cycle`, `vru.spiky-from`.",
    )
};

/// Bits of the record that a published unit holds: 19 B.
const RECORD_BITS: f64 = 152.0;

/// Queues of a core: one for each sub-tile, or one behind the scan (A89).
fn queues(m: &Machine) -> f64 {
    match m.of_type::<VruSpec>().implementation {
        VruImpl::Parallel | VruImpl::Leaders => f64::from(m.of_type::<Geometry>().subtiles()),
        VruImpl::Scan => 1.0,
        VruImpl::Rows => f64::from(m.of_type::<VruSpec>().units_per_core),
        _ => 0.0,
    }
}

/// Bits of the pixels that a unit holds. One whose next tile enters while the last one drains holds
/// two of each (A62), and so does one whose pixels are swapped while it works on others (A86).
/// Units that are divided over the sub-tiles hold all pixels of the tile.
fn pixel_bits(m: &Machine) -> f64 {
    let vru = &m.of_type::<VruSpec>();
    let copies = if vru.tile_overlap { 2.0 } else { 1.0 };
    let swapped = if m.tiles().state_bytes().0 > 0 { 2.0 } else { 1.0 };
    let share = m.of_type::<Geometry>().tile.pow(2).div_ceil(vru.units_per_core);
    let held = match vru.implementation {
        VruImpl::Serial | VruImpl::Swap | VruImpl::Scan => vru.pixels_per_unit,
        VruImpl::Parallel | VruImpl::Leaders => share.max(vru.pixels_per_unit),
        VruImpl::Rows | VruImpl::Quads | VruImpl::Pixels | VruImpl::Box => share,
    };
    let accumulators = f64::from(m.of_type::<FoveaSpec>().accumulators.max(1));
    f64::from(held) * accumulators * copies * swapped * (8.0 * vru.pixel_state.0 as f64)
}

/// Waits for features.
pub const FEATURES: Stall = Stall::of("features");
/// Waits for nothing but colours.
pub const COLOURS: Stall = Stall::of("colours");

/// An α of a live pixel.
pub const ALPHA: ActionId = work_id("alpha");
/// A slot of a pixel that has stopped.
pub const STOPPED_PIXEL: ActionId = work_id("stopped-pixel");
const BLEND: ActionId = work_id("blend");
/// A finished pixel, or as much for a colour of a further level.
pub const PIXEL_FINISH: ActionId = work_id("pixel-finish");
/// A weight of an entry.
const WEIGHT: ActionId = work_id("weight");
/// A pixel divided by the sum of its weights.
const NORMALISE: ActionId = work_id("normalise");
const QUEUE_ENTRY: ActionId = work_id("queue-entry");
/// Features of the chunk that is being rendered.
pub const FEATURE: BufferId = buffer_id("feature");
/// Finished pixels on their way to DRAM.
pub const PIXEL_OUT: BufferId = buffer_id("pixel_out");

/// A leader pixel of a mini-tile.
const LEADER: ActionId = work_id("leader");
/// A row of the ellipse of an entry.
const ROW: ActionId = work_id("row");

/// A chunk, and the tile that ends with it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Render {
    /// The chunk; without entries for a tile that has none.
    pub chunk: ChunkWork,
    /// What it takes, where units are followed through the sub-tiles.
    pub run: Option<ChunkRun>,
    /// The tile, with its last chunk.
    pub last: Option<TileWork>,
    /// Whether the pipeline drains behind it.
    pub drains: bool,
}

/// The rendering units of one core.
#[derive(Debug, Clone)]
pub struct Vru {
    /// The `[vru]` table.
    pub spec: VruSpec,
    /// Side of a sub-tile, pixels.
    pub subtile: u32,
    /// Bytes of an entry in the feature buffer.
    pub feature: u64,
    /// Bytes of a finished pixel.
    pub pixel: u64,
    /// The `[fovea]` table.
    pub fovea: FoveaSpec,
    /// Banks of the core's share of the feature buffer.
    pub features: Banks,
    /// Banks of the core's share of the pixel buffer.
    pub pixels: Banks,
    /// Sub-tiles of a tile.
    pub subtiles: u32,
    /// Words of the pixel state of a sub-tile in the pixel buffer; 0 where it stays in the units.
    pub swapped: u64,
    /// Weights that are made of depths in a cycle, where nobody sorts.
    pub weights: Option<u32>,
    /// How units go through sub-tiles; `None` where the counters of a chunk say everything.
    pub discipline: Option<Discipline>,
}

/// Cycles in which a tile opens (`rtl/vru.sv`).
const OPEN: u64 = 1;
/// Operations of an α; that of a second level takes one more.
const ALPHA_OPERATIONS: u64 = 13;
/// Finished pixels that take as many operations as mixing two levels: 25 over 6 (A16).
const MIX_AS_PIXELS: u64 = 4;

impl Vru {
    /// Bytes of a chunk in the feature buffer.
    pub(crate) fn chunk_bytes(&self, chunk: &ChunkWork) -> u64 {
        let second = u64::from(chunk.seconds) * self.fovea.feature.0;
        u64::from(chunk.entries) * self.feature + second
    }

    fn subtile_pixels(&self) -> u64 {
        u64::from(self.subtile).pow(2)
    }

    /// Groups of pixels of a sub-tile that its units take one after the other.
    fn rounds(&self) -> u64 {
        subtiles::rounds(&self.spec, self.subtiles, self.subtile.pow(2))
    }

    /// Cycles of one (Gaussian, sub-tile) pair of which all pixels are live.
    pub fn pair_cycles(&self) -> u64 {
        self.rounds() * u64::from(self.spec.pixels_per_unit.max(self.spec.recurrence))
    }

    /// (Gaussian, sub-tile) pairs that a chunk executes where stops are known at once.
    pub fn pairs(&self, chunk: &ChunkWork) -> u64 {
        let work = self.executed(chunk);
        u64::from(match self.spec.termination {
            Termination::Tile | Termination::None => work.tile_pairs,
            Termination::Subtile | Termination::Quad | Termination::Pixel => work.subtile_pairs,
        })
    }

    /// The pairs and pixels of a chunk that are executed.
    fn executed<'a>(&self, chunk: &'a ChunkWork) -> &'a PairWork {
        if self.spec.subtile_skipping { &chunk.skipping } else { &chunk.unskipped }
    }

    /// Cycles in which the units of a core evaluate α. Units that stop pixel by pixel rotate
    /// through live pixels only, but never faster than `recurrence`. Where units are followed
    /// through the sub-tiles, pairs of two levels lengthen a chunk in proportion.
    fn blend_cycles(&self, work: &Render) -> u64 {
        let chunk = &work.chunk;
        if let Some(run) = &work.run {
            let again = match self.fovea.accumulators {
                2 => 0,
                _ => run.cycles * u64::from(self.executed(chunk).both_pairs),
            };
            return run.cycles + again.div_ceil(run.pairs.max(1));
        }
        let pairs = self.pairs(chunk);
        let slots = match self.spec.termination {
            Termination::Pixel => {
                let least = pairs * u64::from(self.spec.recurrence);
                u64::from(self.executed(chunk).pixel_slots).max(least) * self.rounds()
            }
            _ => pairs * self.pair_cycles(),
        };
        let again = match self.fovea.accumulators {
            2 => 0,
            _ => u64::from(self.executed(chunk).both_pairs) * self.pair_cycles(),
        };
        // An entry takes a cycle to leave the feature buffer, even where no sub-tile wants it
        // (A26).
        (slots + again).max(u64::from(chunk.entries))
    }

    /// Cycles in which the weights of the entries of a chunk are made of their depths.
    fn weighing_cycles(&self, chunk: &ChunkWork) -> u64 {
        self.weights.map_or(0, |rate| u64::from(chunk.entries.div_ceil(rate)))
    }

    /// Cycles in which the pixels of a tile leave, behind a last chunk that takes so long. Sums are
    /// divided beside the next tile where that may enter.
    fn finish_cycles(&self, tile: &TileWork, blending: u64) -> u64 {
        let pixels = u64::from(tile.pixels.div_ceil(self.spec.units_per_core));
        match (self.weights, self.spec.tile_overlap) {
            (None, _) => pixels,
            (Some(_), overlaps) => {
                let divided = u64::from(tile.pixels.div_ceil(self.spec.divisions_per_cycle));
                pixels.max(divided.saturating_sub(if overlaps { blending } else { 0 }))
            }
        }
    }

    /// Cycles of `cycles` that pass while the queues of the chunk before are emptied: none of them
    /// where its units have been idle for so long.
    pub(crate) fn backlog(&self, work: &Render) -> u64 {
        work.run.map_or(0, |run| run.cycles - run.alone)
    }

    /// α evaluations that a chunk executes. Pixels and quads that have stopped know it themselves
    /// and evaluate nothing in vain.
    fn alphas(&self, work: &Render) -> u64 {
        let executed = self.executed(&work.chunk);
        if let Some(reach) = work.run.and_then(|run| run.reach) {
            return reach.slots;
        }
        match self.spec.termination {
            Termination::Pixel => u64::from(executed.live_evaluations),
            Termination::Quad => u64::from(executed.quad_evaluations),
            Termination::Subtile | Termination::Tile | Termination::None => {
                let pairs = work.run.map_or_else(|| self.pairs(&work.chunk), |run| run.pairs);
                pairs * self.subtile_pixels()
            }
        }
    }

    /// Those of pixels that have not stopped.
    pub(crate) fn live(&self, work: &Render) -> u64 {
        let counted = || u64::from(self.executed(&work.chunk).live_evaluations);
        work.run.and_then(|run| run.reach).map_or_else(counted, |reach| reach.live)
    }

    /// Bytes that a tile leaves in the pixel buffer.
    pub fn pixel_bytes(&self, tile: &TileWork) -> u64 {
        u64::from(tile.pixels) * self.pixel
    }

    fn feature_words(&self, chunk: &ChunkWork) -> u64 {
        let second = self.fovea.feature.0;
        self.features.words_of_records(u64::from(chunk.entries), self.feature)
            + self.features.words_of_records(u64::from(chunk.seconds), second)
    }

    /// Words of features that a chunk reads: each entry once, or once for each scan that meets it.
    fn feature_reads(&self, work: &Render) -> u64 {
        let words = self.feature_words(&work.chunk);
        let Some(run) = &work.run else { return words };
        let entries = u64::from(work.chunk.entries).max(1);
        (words * run.reads).div_ceil(entries)
    }

    /// α evaluations of second levels, counted like those of first levels.
    fn second_alphas(&self, chunk: &ChunkWork) -> u64 {
        // The second level differs in opacity alone: one more of the 13 operations of an α (A16).
        let pairs = u64::from(self.executed(chunk).both_pairs);
        (pairs * self.subtile_pixels()).div_ceil(ALPHA_OPERATIONS)
    }

    /// Charges the feature words of a chunk that was fetched and is not rendered.
    pub(crate) fn charge_unused(&self, entries: u32, actions: &mut ActionCounts) {
        let words = self.features.words_of_records(u64::from(entries), self.feature);
        let bytes = words * self.features.word();
        actions.charge(Phase::Rendering, sram_write(FEATURE), bytes);
    }
}

impl Unit for Vru {
    type Work = Render;
    const STAGE: StageId = stage_id(VRU.key);

    fn cycles(&self, work: &Render) -> u64 {
        let units = u64::from(self.spec.units_per_core);
        let blending = self.blend_cycles(work) + self.weighing_cycles(&work.chunk);
        let finish = work.last.map_or(0, |tile| {
            // Two accumulators blend both levels in the same slot; one takes them in turn.
            let blends = match self.fovea.accumulators {
                2 => tile.blends.max(tile.blends_2),
                _ => tile.blends + tile.blends_2,
            };
            let stall = blends * u64::from(self.spec.blend_stall);
            let open = if self.spec.tile_overlap { 0 } else { OPEN };
            open + stall.div_ceil(units) + self.finish_cycles(&tile, blending)
        });
        let drain = if work.drains { u64::from(self.spec.latency) } else { 0 };
        (blending + finish + drain).max(1)
    }

    /// The features of a chunk are read once, while those of the next one arrive.
    fn bank_stalls(&self, work: &Render) -> u64 {
        let words = self.feature_words(&work.chunk);
        let read = self.feature_reads(work);
        let mut stalls = self.features.excess(read, words, self.blend_cycles(work));
        if let Some(tile) = &work.last {
            let words = self.pixels.words(self.pixel_bytes(tile));
            let blending = self.blend_cycles(work) + self.weighing_cycles(&work.chunk);
            let finish = self.finish_cycles(tile, blending);
            stalls += self.pixels.excess(0, words, finish);
        }
        stalls
    }

    fn charge(&self, work: &Render, actions: &mut ActionCounts) {
        let stage = Phase::Rendering;
        let alphas = self.alphas(work);
        let live = self.live(work).min(alphas);
        actions.charge(stage, ALPHA, live + self.second_alphas(&work.chunk));
        actions.charge(stage, STOPPED_PIXEL, alphas - live);
        if self.weights.is_some() {
            actions.charge(stage, WEIGHT, work.chunk.entries.into());
            let pixels = work.last.map_or(0, |tile| u64::from(tile.pixels));
            actions.charge(stage, NORMALISE, pixels);
        }
        let features = self.feature_words(&work.chunk) * self.features.word();
        actions.charge(stage, sram_write(FEATURE), features);
        let features = self.feature_reads(work) * self.features.word();
        actions.charge(stage, sram_read(FEATURE), features);
        if let Some(run) = &work.run {
            actions.charge(stage, QUEUE_ENTRY, run.queued);
            let looked_at = match self.spec.implementation {
                VruImpl::Rows => ROW,
                _ => LEADER,
            };
            actions.charge(stage, looked_at, run.front);
            let state = run.switches * self.swapped * self.pixels.word();
            actions.charge(stage, sram_write(PIXEL_OUT), state);
            actions.charge(stage, sram_read(PIXEL_OUT), state);
        }
        if let Some(tile) = &work.last {
            actions.charge(stage, BLEND, tile.blends + tile.blends_2);
            let finished = u64::from(tile.pixels) + MIX_AS_PIXELS * u64::from(tile.mixed);
            actions.charge(stage, PIXEL_FINISH, finished);
            let pixels = self.pixels.words(self.pixel_bytes(tile)) * self.pixels.word();
            actions.charge(stage, sram_write(PIXEL_OUT), pixels);
            actions.charge(stage, sram_read(PIXEL_OUT), pixels);
        }
    }
}
