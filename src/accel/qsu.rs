//! Quick Sorting Unit (QSU): splits a tile's list by depth until every part fits a chunk.
//!
//! Timing rule: one pass moves every key of the list past the pivots and splits it into
//! `pivots + 1` parts, so a list of n entries takes `ceil(log_{pivots+1}(n / chunk))` passes, none
//! when it fits a chunk. A pass takes `latency + ceil(n / (units keys_per_cycle))` cycles; the
//! units of a core share every list (A23) and are accounted as one gang.
//!
//! Spill rule: what of a list does not fit the core's share of the sorting buffer is written to
//! DRAM and read back in every pass; a pass ends when both its keys and its spill are done (A24).
//!
//! Source: `gscore` (seven pivots, lists of more than 256 entries), `nerarch-sim` (one key a
//! cycle, 64 cycles), `powergs` for the number of passes.

use super::machine::GsuSpec;
use super::unit::Unit;
use crate::action::{Action, ActionCounts, Buffer, Stage};

/// The list of one tile.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct List {
    /// Entries.
    pub entries: u64,
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
    /// The core's share of the sorting buffer, bytes.
    pub share: u64,
}

impl Qsu {
    /// Passes until every part fits a chunk, if pivots split evenly.
    pub fn passes(&self, list: List) -> u32 {
        let mut reach = u128::from(self.chunk);
        let mut passes = 0;
        while reach < u128::from(list.entries) {
            reach *= u128::from(self.spec.pivots) + 1;
            passes += 1;
        }
        passes
    }

    /// Cycles of one pass.
    pub fn pass_cycles(&self, list: List) -> u64 {
        let rate = u64::from(self.spec.qsu_per_core) * u64::from(self.spec.keys_per_cycle);
        (u64::from(self.spec.qsu_latency) + list.entries.div_ceil(rate)).max(1)
    }

    /// Room that the list takes in the sorting buffer.
    pub fn resident(&self, list: List) -> u64 {
        (list.entries * self.key).min(self.share)
    }

    /// Bytes that every pass writes to DRAM and reads back.
    pub fn overflow(&self, list: List) -> u64 {
        (list.entries * self.key).saturating_sub(self.share)
    }
}

impl Unit for Qsu {
    type Work = List;
    const NAME: &'static str = "qsu";

    /// All passes, without spill. A list that needs none passes in one cycle.
    fn cycles(&self, list: &List) -> u64 {
        (u64::from(self.passes(*list)) * self.pass_cycles(*list)).max(1)
    }

    /// Keys are written once when they arrive, and read and written once in every pass.
    fn charge(&self, list: &List, actions: &mut ActionCounts) {
        let passes = u64::from(self.passes(*list));
        let bytes = list.entries * self.key;
        actions.charge(Stage::Sorting, Action::PivotKey, list.entries * passes);
        actions.charge(Stage::Sorting, Action::SramWrite(Buffer::Sorting), bytes * (passes + 1));
        actions.charge(Stage::Sorting, Action::SramRead(Buffer::Sorting), bytes * passes);
    }
}
