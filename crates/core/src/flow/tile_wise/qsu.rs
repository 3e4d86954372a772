//! Quick Sorting Unit (QSU): splits a tile's list by depth until every part fits a chunk, or merges
//! its sorted chunks.
//!
//! Timing rule: one pass moves every key of the list past the pivots and splits it into
//! `pivots + 1` parts, so a list of n entries takes `ceil(log_{pivots+1}(n / chunk))` passes, none
//! when it fits a chunk. A pass takes `latency + changes + ceil(n / (units keys_per_cycle))`
//! cycles; the units of a core share every list (A23) and are accounted as one gang. `changes` is
//! the time in which pivots are written, one a cycle into each unit: a set for the whole list in
//! the first pass, and one for each part that is split again in a later one (`rtl/qsu.sv`; A112).
//!
//! Spill rule: the part of a list that does not fit the core's share of the sorting buffer is
//! written to DRAM and read back in every pass; a pass ends when both its keys and its spill are
//! done (A24).
//!
//! **Merging** (`gsu.impl = "merge"`; A126). First the BSUs sort every chunk of a list, one after
//! the other, whatever rendering will need of it; then `ceil(log_fan-in(chunks))` passes merge
//! `fan-in` parts at a time. A pass takes `latency + ceil(n / (units keys_per_cycle))` cycles and
//! spills as above; so does the pass of the BSUs where a merge follows. Chunks are in order then
//! and are sorted no more.
//!
//! Source: `gscore` (seven pivots, lists of more than 256 entries), `nerarch-sim` (one key a
//! cycle, 64 cycles), `powergs` for the number of passes.

use super::{BufferSpecs, VruSpec, gsu};
use crate::flow::tile_wise::{GsuSpec, Spill};
use crate::kernel::bank::Banks;
use crate::kernel::stream::{reads, writes};
use crate::kernel::unit::Unit;
use crate::stage::{
    Bias, From, StageDecl, Stall, WaitDecl, buffer, buffer_id, double, omit, part, sram_read,
    sram_write, stage_id, work, work_id,
};
use powergs_energy::action::{ActionCounts, ActionId, BufferId, Phase, StageId};

/// What the unit declares.
pub const QSU: StageDecl = StageDecl {
    units: Some(|m| match m.of_type::<GsuSpec>() {
        gsu if gsu.sorts() => m.of_type::<VruSpec>().cores * gsu.qsu_per_core,
        _ => 0,
    }),
    works: &[work("pivot-key", 0, "One key moved through a QSU in one pass: split or merged.")
        .comparing(|m| m.of_type::<GsuSpec>().comparisons())
        .a_cycle(|m| f64::from(m.of_type::<GsuSpec>().keys_per_cycle))],
    buffers: &[buffer("sorting", "buffers.sorting", |m| {
        m.of_type::<BufferSpecs>().sorting.shared(m.of_type::<VruSpec>().cores)
    })],
    streams: &[
        reads("lists", "lists of tiles", &["results", "kept-lists"], ["spill-in", "records"]),
        reads("depths", "depths of kept entries", &["results"], ["features", "survivors"])
            .scattered(),
        writes("kept-lists", "sorted lists for the next frame", ["spill-out", "pixels"]),
        writes("spill-out", "keys that do not fit the buffer", ["kept-lists", "pixels"]),
        reads("spill-in", "the same on their way back", &["spill-out"], ["lists", "records"]),
    ],
    parts: &[
        part(
            "pivots",
            "Pivots, or heads of other parts: a key is compared with all of them.",
            |m| f64::from(m.of_type::<GsuSpec>().comparisons()),
        ),
        part("comparators", "Comparators: pivots x keys a cycle.", |m| {
            f64::from(m.of_type::<GsuSpec>().comparisons())
                * f64::from(m.of_type::<GsuSpec>().keys_per_cycle)
        }),
    ],
    waits: &[
        WaitDecl {
            name: "list",
            what: "tile lists",
            short: "list of the tile",
            because: "the list of a tile was in DRAM or on its way",
            symbol: 'l',
            from: From::Memory,
        },
        WaitDecl {
            name: "spill",
            what: "spilled keys",
            short: "spilled keys",
            because: "keys that did not fit the sorting buffer were on their way",
            symbol: 's',
            from: From::Memory,
        },
    ],
    after: Some("ccu"),
    input: "tile lists from the CCU",
    doubles: &[
        double("gsu.qsu-per-core", &["gsu.qsu-per-core"], &["A23"]),
        double("buffers.sorting", &["buffers.sorting.capacity"], &["A24"]),
    ],
    omits: &[omit(
        "pivots that split a list unevenly and need another pass",
        Bias::Optimistic,
        "A23",
    )],
    behind: &["A23", "A24"],
    optional: gsu::OPTIONAL,
    excludes: gsu::EXCLUDES,
    ..StageDecl::new(
        "qsu",
        "quick sorting units (QSU)",
        Phase::Sorting,
        "Quick Sorting Unit of the GSU: splits a list at pivots into chunks that are \
         small enough to sort in one go. Keys: `gsu`.",
    )
};

/// Waits for a list.
pub const LIST: Stall = Stall::of("list");
/// Waits for keys that did not fit.
pub const SPILL: Stall = Stall::of("spill");

const PIVOT_KEY: ActionId = work_id("pivot-key");
/// Keys of the tile that is being sorted.
pub const SORTING: BufferId = buffer_id("sorting");

/// The keys that are sorted together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Keys {
    /// Keys in the sorting buffer.
    pub held: u64,
    /// Of these, keys that go through the passes: all, or the new ones where the order of the frame
    /// before is updated.
    pub sorted: u64,
    /// Passes.
    pub passes: u32,
    /// Passes before these.
    pub before: u32,
    /// Whether chunks come in order: the BSUs sort them all before the passes, which merge them, or
    /// no order is needed.
    pub merged: bool,
}

impl Keys {
    /// Times that keys are written to DRAM and read back, as far as they are.
    pub fn round_trips(&self) -> u64 {
        u64::from(self.passes) + u64::from(self.merged && self.passes > 0)
    }
}

/// The quick sorting units of one core.
#[derive(Debug, Clone)]
pub struct Qsu {
    /// The `[gsu]` table.
    pub spec: GsuSpec,
    /// Entries of a chunk.
    pub chunk: u64,
    /// Bytes of a key.
    pub key: u64,
    /// Bytes of a depth.
    pub depth: u64,
    /// The core's share of the sorting buffer, bytes.
    pub share: u64,
    /// Its banks.
    pub banks: Banks,
}

impl Qsu {
    /// Passes until every part of a list fits a chunk, if pivots split evenly; or until all chunks
    /// are one part. None where nobody sorts.
    pub fn passes(&self, entries: u64) -> u32 {
        // Wide, because the last step may take the reach far beyond the entries.
        let parts = u128::from(self.spec.comparisons()) + 1;
        let mut reach = u128::from(self.chunk);
        let mut passes = 0;
        while self.spec.sorts() && reach < u128::from(entries) {
            reach *= parts;
            passes += 1;
        }
        passes
    }

    /// Cycles of the pass over `keys` behind `pass` others, bank stalls excluded.
    pub fn pass_cycles(&self, keys: &Keys, pass: u32) -> u64 {
        let rate = u64::from(self.spec.qsu_per_core) * u64::from(self.spec.keys_per_cycle);
        // Heads of parts come with their keys.
        let pivots = if keys.merged { 0 } else { u64::from(self.spec.pivots) };
        // Parts that fit a chunk are not split again.
        let parts = (pivots + 1).saturating_pow(pass).min(keys.sorted / self.chunk.max(1)).max(1);
        let changes = parts.div_ceil(u64::from(self.spec.qsu_per_core)) * pivots;
        (u64::from(self.spec.qsu_latency) + changes + keys.sorted.div_ceil(rate)).max(1)
    }

    /// Further cycles of a pass, because its keys are dealt to banks at random.
    pub fn pass_stalls(&self, keys: &Keys, pass: u32) -> u64 {
        self.banks.excess_of_dealing(keys.sorted, self.key, self.pass_cycles(keys, pass))
    }

    /// Sums `of` over the passes.
    fn passes_of(keys: &Keys, of: impl Fn(u32) -> u64) -> u64 {
        (keys.before..keys.before + keys.passes).map(of).sum()
    }

    /// Bytes that the keys occupy in the sorting buffer.
    pub fn resident(&self, keys: &Keys) -> u64 {
        (keys.held * self.key).min(self.share)
    }

    /// Bytes that every pass writes to DRAM and reads back.
    pub fn overflow(&self, keys: &Keys) -> u64 {
        match self.spec.spill {
            Spill::All => keys.sorted * self.key,
            Spill::Overflow => (keys.held * self.key).saturating_sub(self.share),
        }
    }
}

impl Unit for Qsu {
    type Work = Keys;
    const STAGE: StageId = stage_id(QSU.key);

    /// All passes, without spill. Keys that need none pass in one cycle.
    fn cycles(&self, keys: &Keys) -> u64 {
        Self::passes_of(keys, |pass| self.pass_cycles(keys, pass)).max(1)
    }

    fn bank_stalls(&self, keys: &Keys) -> u64 {
        Self::passes_of(keys, |pass| self.pass_stalls(keys, pass))
    }

    /// Keys are written once when they arrive, and read and written once in every pass.
    fn charge(&self, keys: &Keys, actions: &mut ActionCounts) {
        let passes = u64::from(keys.passes);
        let bytes = |n: u64| self.banks.words(n * self.key) * self.banks.word();
        let (held, sorted) = (bytes(keys.held), bytes(keys.sorted));
        actions.charge(Phase::Sorting, PIVOT_KEY, keys.sorted * passes);
        actions.charge(Phase::Sorting, sram_write(SORTING), held + sorted * passes);
        actions.charge(Phase::Sorting, sram_read(SORTING), sorted * passes);
    }
}
