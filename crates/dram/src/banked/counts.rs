//! Counters of one channel.

use crate::stats::{CLASSES, Stats};

/// What was done for the bursts of one class.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ClassCounts {
    /// Read and write commands.
    pub columns: [u64; 2],
    /// Reads that were answered by a write that waited, writes that one absorbed.
    pub merged: [u64; 2],
    /// Bursts by the first command for them: column, activate, precharge.
    pub first: [u64; 3],
}

/// What a channel did.
#[derive(Debug, Clone, Default)]
pub(super) struct BankedCounts {
    pub classes: [ClassCounts; CLASSES],
    pub activates: u64,
    pub precharges: u64,
    pub precharges_all: u64,
    pub refreshes_all: u64,
    pub refreshes_bank: u64,
    pub clock_syncs: u64,
}

impl BankedCounts {
    /// Adds them to the activity of the memory, whose bursts have `burst_bytes`.
    pub(super) fn add_to(&self, stats: &mut Stats, burst_bytes: u64) {
        for (class, counts) in self.classes.iter().enumerate() {
            let [reads, writes] = counts.columns;
            stats.reads += reads;
            stats.writes += writes;
            for traffic in [&mut stats.total, &mut stats.classes[class]] {
                traffic.moved_bytes += (reads + writes) * burst_bytes;
                traffic.reads += reads;
                traffic.writes += writes;
                traffic.forwarded_reads += counts.merged[0];
                traffic.absorbed_writes += counts.merged[1];
                traffic.row_hits += counts.first[0];
                traffic.row_misses += counts.first[1];
                traffic.row_conflicts += counts.first[2];
            }
        }
        stats.activates += self.activates;
        stats.precharges += self.precharges;
        stats.precharges_all += self.precharges_all;
        stats.refreshes_all += self.refreshes_all;
        stats.refreshes_bank += self.refreshes_bank;
        stats.clock_syncs += self.clock_syncs;
    }
}
