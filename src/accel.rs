//! The accelerator: units say how long and how often, the pipeline says when.
//!
//! Nothing here knows a joule or a file.

pub mod machine;

pub use machine::Machine;

/// Why a unit could not work although it had work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stall {
    /// Its input is still in DRAM or on the way.
    Dram,
    /// The unit before it has not finished.
    Input,
    /// The buffer behind it is full.
    Output,
}

impl Stall {
    /// All causes, in report order.
    pub const ALL: [Stall; 3] = [Stall::Dram, Stall::Input, Stall::Output];

    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Stall::Dram => "dram",
            Stall::Input => "input",
            Stall::Output => "output",
        }
    }
}

/// Where the cycles of one kind of unit went, summed over its instances:
/// `busy + stalls + idle = instances * frame`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitCycles {
    /// Name of the unit: `ccu`, `qsu`, `bsu`, `vru`.
    pub unit: &'static str,
    /// How many of them the machine has.
    pub instances: u32,
    /// Cycles with work.
    pub busy: u64,
    /// Cycles with work that could not proceed, by cause (order of [`Stall::ALL`]).
    pub stalls: [u64; 3],
    /// Cycles without work: before its phase, after its last item.
    pub idle: u64,
}

/// What the shared DRAM did in one frame.
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
    /// Cycles in which the data bus moved data.
    pub busy_cycles: u64,
}

/// When everything in one frame happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameTiming {
    /// Length of the frame, cycles.
    pub frame: u64,
    /// Cycles until the last CCU was done.
    pub preprocessing_end: u64,
    /// Units in pipeline order.
    pub units: Vec<UnitCycles>,
    /// The DRAM.
    pub dram: DramUse,
}
