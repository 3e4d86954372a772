//! Bitonic Sorting Unit (BSU): sorts one chunk exactly, while the chunk before it is rendered.
//!
//! Timing rule: a bitonic network of width w takes w keys a cycle. A chunk of n keys is first cut
//! into `r = ceil(n / w)` rows that are sorted one a cycle; then `ceil(log2 r)` levels of two-way
//! merging follow, each streaming all rows through the network used as a merger, one row a cycle.
//! Every level drains before the next begins: `(levels + 1) (latency + ceil(r / units))` cycles
//! (A25; how GSCore merges 16 to 256 is not published).
//!
//! Compare-exchanges, s = log2 w: a sorted row costs `w/2 s (s+1)/2`, a merged row `w + w/2 s` (a
//! half-cleaner of 2w inputs that keeps w, then s stages).
//!
//! Source: `gscore` (16 inputs), `nerarch-sim` (4 cycles).

use super::machine::GsuSpec;
use super::unit::Unit;
use crate::action::{Action, ActionCounts, Buffer, Stage};
use crate::workload::ChunkWork;

/// The bitonic sorting units of one core.
#[derive(Debug, Clone)]
pub struct Bsu {
    /// The `[gsu]` table.
    pub spec: GsuSpec,
    /// Bytes of a key.
    pub key: u64,
}

impl Bsu {
    fn rows(&self, chunk: &ChunkWork) -> u64 {
        u64::from(chunk.entries.div_ceil(self.spec.bsu_width)).max(1)
    }

    /// Levels of merging.
    pub fn levels(&self, chunk: &ChunkWork) -> u64 {
        u64::from(self.rows(chunk).next_power_of_two().ilog2())
    }

    /// Compare-exchanges of a chunk.
    pub fn compare_exchanges(&self, chunk: &ChunkWork) -> u64 {
        let w = u64::from(self.spec.bsu_width);
        let s = u64::from(self.spec.bsu_width.next_power_of_two().ilog2());
        let (sorted, merged) = (w * s * (s + 1) / 4, w + w * s / 2);
        self.rows(chunk) * (sorted + self.levels(chunk) * merged)
    }
}

impl Unit for Bsu {
    type Work = ChunkWork;
    const NAME: &'static str = "bsu";

    fn cycles(&self, chunk: &ChunkWork) -> u64 {
        let row_time = self.rows(chunk).div_ceil(u64::from(self.spec.bsu_per_core));
        (self.levels(chunk) + 1) * (u64::from(self.spec.bsu_latency) + row_time).max(1)
    }

    /// Every level reads and writes every key; the feature fetch reads each once more.
    fn charge(&self, chunk: &ChunkWork, actions: &mut ActionCounts) {
        let bytes = u64::from(chunk.entries) * self.key;
        let levels = self.levels(chunk) + 1;
        actions.charge(Stage::Sorting, Action::CompareExchange, self.compare_exchanges(chunk));
        actions.charge(Stage::Sorting, Action::SramRead(Buffer::Sorting), bytes * (levels + 1));
        actions.charge(Stage::Sorting, Action::SramWrite(Buffer::Sorting), bytes * levels);
    }
}
