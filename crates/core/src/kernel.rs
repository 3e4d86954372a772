//! What every machine is made of: agents and their events, buffers and banks, the memory and its
//! timers, accounts of cycles.
//!
//! Nothing here knows a joule, a file or a dataflow.

pub mod agents;
pub mod bank;
pub mod blocks;
pub mod buffer;
pub mod calibration;
pub mod divide;
pub mod dram;
mod event_queue;
pub mod ledger;
pub mod masters;
pub mod memo;
pub mod memory;
pub mod spec;
mod stall;
pub mod stream;
pub mod timeline;
pub mod traffic;
pub mod unit;

use powergs_dram::DramCommands;
use powergs_energy::action::{BufferId, StageId};

pub use agents::{Agents, Halt, Halted, drive};
pub use calibration::Calibration;
pub use memo::{Memo, MemoKey};
pub use stall::Stall;
pub use unit::Unit;

/// Where the cycles of one kind of unit went, summed over its instances:
/// `busy + stalls + idle = instances * frame`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitCycles {
    /// Which kind.
    pub unit: StageId,
    /// How many of them the machine has.
    pub instances: u32,
    /// Cycles with work.
    pub busy: u64,
    /// Cycles with work that could not proceed, by [`Stall::index`].
    pub stalls: [u64; Stall::MOST],
    /// Cycles without work: before its phase, after its last item.
    pub idle: u64,
}

/// Activity of the shared DRAM in one frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DramUse {
    /// Bytes read.
    pub read_bytes: u64,
    /// Bytes written.
    pub write_bytes: u64,
    /// Requests issued by the units.
    pub requests_issued: u64,
    /// Requests served.
    pub requests_served: u64,
    /// Time for which the data bus moved data, in whole cycles (rounded up), for other masters too.
    pub busy_cycles: u64,
    /// Bytes that each of the other masters asked for and that were served: not among the others.
    pub master_bytes: [u64; masters::MASTERS.len()],
    /// Commands of the device; `None` in the `bandwidth` model, which knows none.
    pub commands: Option<DramCommands>,
}

impl DramUse {
    /// Bytes that the units asked for, read and written.
    pub fn requested_bytes(&self) -> u64 {
        self.read_bytes + self.write_bytes
    }
}

/// Occupancy and throughput of one buffer, all its shares together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferUse {
    /// Which.
    pub buffer: BufferId,
    /// Its size, bytes.
    pub capacity: u64,
    /// The most that it held, bytes.
    pub peak: u64,
    /// Sum over the cycles of the frame of the bytes that it held.
    pub byte_cycles: u128,
    /// Bytes that entered.
    pub filled: u64,
    /// Bytes that left because they had been used.
    pub consumed: u64,
    /// Bytes that left unused.
    pub discarded: u64,
}

/// A histogram with two bins an octave: bin 0 counts zeros, bin `k` values from `2^((k-1)/2)` up to
/// `2^(k/2)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Histogram {
    /// Counts.
    pub bins: [u32; Histogram::BINS],
}

impl Histogram {
    /// Bins: the last one holds everything from 2^31.5.
    pub const BINS: usize = 64;

    /// An empty histogram.
    pub const EMPTY: Histogram = Histogram { bins: [0; Self::BINS] };

    /// Adds one to the bin of `value`.
    pub fn count(&mut self, value: u64) {
        self.bins[Self::bin(value)] += 1;
    }

    /// The bin of a value: found with integers, so that no rounding of a logarithm moves it.
    pub fn bin(value: u64) -> usize {
        if value == 0 {
            return 0;
        }
        let octave = value.ilog2();
        // At or above 2^(octave + 1/2), that is value^2 >= 2^(2 octave + 1).
        let upper = u128::from(value) * u128::from(value) >= 1u128 << (2 * octave + 1);
        (1 + 2 * octave as usize + usize::from(upper)).min(Self::BINS - 1)
    }

    /// Adds the counts of `other`.
    pub(crate) fn add(&mut self, other: &Histogram) {
        self.bins.iter_mut().zip(other.bins).for_each(|(n, m)| *n += m);
    }

    /// The least value of a bin.
    pub fn least(bin: usize) -> f64 {
        if bin == 0 { 0.0 } else { ((bin - 1) as f64 * 0.5).exp2() }
    }
}

/// When everything in one frame happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameTiming {
    /// Length of the frame, cycles.
    pub frame: u64,
    /// Cycles until the last CCU was done.
    pub preprocessing_end: u64,
    /// Units of each kind that the machine has, in the order of their numbers.
    pub units: Vec<UnitCycles>,
    /// The DRAM.
    pub dram: DramUse,
    /// Buffers that fill and empty.
    pub buffers: Vec<BufferUse>,
    /// Cycles for which tiles (or merged tiles, or sort groups) held a core's renderer, from the
    /// first of their chunks to the last of their pixels.
    pub tile_cycles: Histogram,
}

impl FrameTiming {
    /// A buffer; `None` where the machine has no such buffer.
    pub fn buffer(&self, buffer: BufferId) -> Option<&BufferUse> {
        self.buffers.iter().find(|b| b.buffer == buffer)
    }

    /// Share of the frame in which the DRAM's data bus moved data, 0 to 1.
    pub fn dram_busy_frac(&self) -> f64 {
        if self.frame == 0 { 0.0 } else { self.dram.busy_cycles as f64 / self.frame as f64 }
    }

    /// The units of one kind; `None` where the machine has none.
    pub fn unit(&self, kind: StageId) -> Option<&UnitCycles> {
        self.units.iter().find(|units| units.unit == kind)
    }
}
