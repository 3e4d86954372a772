//! Bitonic Sorting Unit (BSU): sorts one chunk exactly, while the chunk before it is rendered.
//!
//! Timing rule: a bitonic network of width w takes w keys a cycle. A chunk of n keys is first cut
//! into `r = ceil(n / w)` rows that are sorted one a cycle; then `ceil(log2 r)` levels of two-way
//! merging follow, each streaming the lists that have a partner through the network used as a
//! merger, one row a cycle; the last list of an odd number stays where it is. Every level drains
//! before the next begins: `latency + ceil(rows / units)` cycles each (A25; how GSCore merges 16 to
//! 256 is not published).
//!
//! Compare-exchanges, s = log2 w: a sorted row costs `w/2 s (s+1)/2`, a merged row `w + w/2 s` (a
//! half-cleaner of 2w inputs that keeps w, then s stages).
//!
//! Source: `gscore` (16 inputs), `nerarch-sim` (4 cycles).

use super::VruSpec;
use crate::flow::tile_wise::GsuSpec;
use crate::flow::tile_wise::qsu::SORTING;
use crate::kernel::bank::Banks;
use crate::kernel::unit::Unit;
use crate::stage::{StageDecl, double, part, sram_read, sram_write, stage_id, work, work_id};
use powergs_energy::action::{ActionCounts, ActionId, Phase, StageId};

/// What the unit declares.
pub const BSU: StageDecl = StageDecl {
    units: Some(|m| match m.of_type::<GsuSpec>() {
        gsu if gsu.sorts() => m.of_type::<VruSpec>().cores * gsu.bsu_per_core,
        _ => 0,
    }),
    works: &[
        work("compare-exchange", 0, "One compare-exchange of a BSU.")
            .comparing(|_| 1)
            .a_cycle(|m| network(m.of_type::<GsuSpec>().bsu_width) as f64),
        work(
            "sorted-row",
            0,
            "One row that a BSU sorts, where compare-exchanges are free; nothing without.",
        )
        .made_of("compare-exchange")
        .a_cycle(|_| 1.0),
        work(
            "merged-row",
            0,
            "One row that a BSU merges from two lists, where compare-exchanges are free; nothing \
             without.",
        )
        .made_of("compare-exchange")
        .a_cycle(|_| 1.0),
    ],
    parts: &[
        part("network", "Compare-exchanges of the network: w/4 log2 w (log2 w + 1).", |m| {
            network(m.of_type::<GsuSpec>().bsu_width) as f64
        }),
        part(
            "queue",
            "Bits of what a core has asked for: 128 for each of `gsu.queue` lists, 64 for each of \
             `vru.speculation` chunks, over the BSUs of the core.",
            |m| {
                let lists = f64::from(m.of_type::<GsuSpec>().queue) * LIST_BITS;
                let chunks = f64::from(m.of_type::<VruSpec>().speculation) * CHUNK_BITS;
                (lists + chunks) / f64::from(m.of_type::<GsuSpec>().bsu_per_core)
            },
        ),
    ],
    also_waits: &["list", "spill"],
    after: Some("qsu"),
    input: "parts from the QSU",
    doubles: &[double("gsu.bsu-per-core", &["gsu.bsu-per-core"], &["A25"])],
    behind: &["A25"],
    ..StageDecl::new(
        "bsu",
        "bitonic sorting units (BSU)",
        Phase::Sorting,
        "Bitonic Sorting Unit of the GSU: sorts the rows of a chunk in a network of \
         comparators. Keys: `gsu`.",
    )
};

/// Bits that describe a list: address, length, tile.
const LIST_BITS: f64 = 128.0;
/// Bits that describe a chunk.
const CHUNK_BITS: f64 = 64.0;

const COMPARE_EXCHANGE: ActionId = work_id("compare-exchange");
const SORTED_ROW: ActionId = work_id("sorted-row");
const MERGED_ROW: ActionId = work_id("merged-row");

/// The sort that must precede the rendering of a chunk.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sort {
    /// Keys sorted precisely, chunk by chunk.
    pub keys: u64,
    /// Keys of a sort group's list that are scanned to select those of one tile.
    pub filtered: u64,
}

/// The bitonic sorting units of one core.
#[derive(Debug, Clone)]
pub struct Bsu {
    /// The `[gsu]` table.
    pub spec: GsuSpec,
    /// Entries of a chunk.
    pub chunk: u64,
    /// Bytes of a key.
    pub key: u64,
    /// Banks of the core's share of the sorting buffer.
    pub banks: Banks,
}

/// Compare-exchanges of a bitonic network of `width` inputs.
pub fn network(width: u32) -> u64 {
    let stages = u64::from(width.next_power_of_two().ilog2());
    u64::from(width) * stages * (stages + 1) / 4
}

impl Bsu {
    fn rows(&self, keys: u64) -> u64 {
        keys.div_ceil(u64::from(self.spec.bsu_width)).max(1)
    }

    /// Levels of merging of a chunk of `keys`.
    pub(crate) fn levels(&self, keys: u64) -> u64 {
        u64::from(self.rows(keys).next_power_of_two().ilog2())
    }

    /// Rows that each level of merging streams, of a chunk of `keys`: level `l` merges pairs of
    /// lists of 2^l rows, and the last list of an odd number has no partner.
    fn merged(&self, keys: u64) -> impl Iterator<Item = u64> {
        let rows = self.rows(keys);
        (0..self.levels(keys)).map(move |level| {
            let lists = rows.div_ceil(1 << level);
            if lists % 2 == 1 { (lists - 1) << level } else { rows }
        })
    }

    /// Rows of a chunk of `keys` that are sorted, and that are merged in all levels.
    pub fn chunk_rows(&self, keys: u64) -> [u64; 2] {
        [self.rows(keys), self.merged(keys).sum()]
    }

    /// Compare-exchanges of so many rows that are sorted, and merged.
    pub fn compare_exchanges(&self, [sorted, merged]: [u64; 2]) -> u64 {
        let w = u64::from(self.spec.bsu_width);
        let s = u64::from(self.spec.bsu_width.next_power_of_two().ilog2());
        sorted * network(self.spec.bsu_width) + merged * (w + w * s / 2)
    }

    fn chunk_cycles(&self, keys: u64) -> u64 {
        let (latency, units) =
            (u64::from(self.spec.bsu_latency), u64::from(self.spec.bsu_per_core));
        let time = |rows: u64| (latency + rows.div_ceil(units)).max(1);
        time(self.rows(keys)) + self.merged(keys).map(time).sum::<u64>()
    }

    /// Words of a chunk that are read, and written, in all levels: keys that stay are not.
    fn chunk_words(&self, keys: u64) -> u64 {
        let row = u64::from(self.spec.bsu_width);
        let merged =
            self.merged(keys).map(|rows| self.banks.words((rows * row).min(keys) * self.key));
        self.banks.words(keys * self.key) + merged.sum::<u64>()
    }

    /// Sums `of` over the chunks of `sort`.
    fn chunks(&self, sort: &Sort, of: impl Fn(u64) -> u64) -> u64 {
        let (whole, rest) = (sort.keys / self.chunk, sort.keys % self.chunk);
        let all = if whole > 0 { whole * of(self.chunk) } else { 0 };
        all + if rest > 0 { of(rest) } else { 0 }
    }

    /// Words that are looked through.
    fn filtered_words(&self, sort: &Sort) -> u64 {
        self.banks.words(sort.filtered * self.key)
    }
}

impl Unit for Bsu {
    type Work = Sort;
    const STAGE: StageId = stage_id(BSU.key);

    /// Keys of a group are looked through a row at a time (A80).
    fn cycles(&self, sort: &Sort) -> u64 {
        let sorting = self.chunks(sort, |keys| self.chunk_cycles(keys));
        let filtering = sort.filtered.div_ceil(u64::from(self.spec.bsu_width));
        (sorting + filtering).max(1)
    }

    fn bank_stalls(&self, sort: &Sort) -> u64 {
        let words = self.chunks(sort, |keys| self.chunk_words(keys));
        self.banks.excess(words + self.filtered_words(sort), words, self.cycles(sort))
    }

    /// Every level reads and writes the keys that it moves; the feature fetch reads each once more.
    fn charge(&self, sort: &Sort, actions: &mut ActionCounts) {
        let word = self.banks.word();
        let rows = [0, 1].map(|kind| self.chunks(sort, |keys| self.chunk_rows(keys)[kind]));
        let moved = self.chunks(sort, |keys| self.chunk_words(keys)) * word;
        let fetched = self.chunks(sort, |keys| self.banks.words(keys * self.key)) * word;
        let read = moved + fetched + self.filtered_words(sort) * word;
        let exchanges = self.compare_exchanges(rows);
        actions.charge(Phase::Sorting, COMPARE_EXCHANGE, exchanges);
        actions.charge(Phase::Sorting, SORTED_ROW, rows[0]);
        actions.charge(Phase::Sorting, MERGED_ROW, rows[1]);
        actions.charge(Phase::Sorting, sram_read(SORTING), read);
        actions.charge(Phase::Sorting, sram_write(SORTING), moved);
    }
}
