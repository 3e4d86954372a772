//! The accelerator: units say how long and how often, the pipeline says when.
//!
//! Nothing here knows a joule or a file. [`replay`] takes a binned frame through one machine.

pub mod batch;
pub mod bsu;
pub mod buffer;
pub mod ccu;
pub mod design;
pub mod dram;
pub mod machine;
pub mod pipeline;
pub mod qsu;
pub mod timeline;
pub mod traffic;
pub mod unit;
pub mod vru;

use crate::action::ActionCounts;
use crate::workload::FrameWorkload;

pub use design::Design;
pub use machine::Machine;
pub use traffic::Traffic;
pub use unit::Unit;

use timeline::Observer;

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
    /// Time for which the data bus moved data, in whole cycles (rounded up).
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

/// One frame on one machine: when, how often, and what crossed the DRAM interface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replay {
    /// When everything happened.
    pub timing: FrameTiming,
    /// How often everything happened, counted from the frame's totals and not from its timing.
    pub actions: ActionCounts,
    /// What the DRAM served.
    pub served: Traffic,
}

/// Takes `workload` through `machine`.
///
/// # Panics
/// When the workload was binned with another geometry than the machine's, or when the machine is
/// one that no check lets through (a unit count, width or interval of zero).
pub fn replay(workload: &FrameWorkload, machine: &Machine) -> Replay {
    replay_observed(workload, machine, &mut ())
}

/// As [`replay`], and tells `observer` what every unit did when.
pub fn replay_observed(
    workload: &FrameWorkload,
    machine: &Machine,
    observer: &mut impl Observer,
) -> Replay {
    assert_eq!(workload.geometry, machine.geometry, "a workload runs on machines of its geometry");
    let design = Design::new(machine);
    let (timing, served) = pipeline::run(workload, &design, observer);
    Replay { timing, actions: traffic::actions(workload, &design), served }
}
