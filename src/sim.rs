//! Where what happened, when, and what it cost meet: one frame on one machine gives one
//! [`FrameReport`].

pub mod statistics;

use crate::accel::FrameTiming;
use crate::action::ActionCounts;
use crate::energy::EnergyBreakdown;
use crate::splat::Counters;

/// Which model produced a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Closed-form counts of the published PowerGS model; has no time.
    Paper,
    /// The simulated machine.
    Cycle,
}

impl Model {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Model::Paper => "paper",
            Model::Cycle => "cycle",
        }
    }
}

/// DRAM bytes of one stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageBytes {
    /// Read.
    pub read: u64,
    /// Written.
    pub write: u64,
    /// Moved in or out of on-chip buffers.
    pub sram: u64,
    /// Floating-point operations (`paper` model; zero in `cycle`, which counts actions).
    pub flops: u64,
}

/// One frame, simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameReport {
    /// Position in the trace.
    pub frame: usize,
    /// Name of the view.
    pub name: String,
    /// Workload counters under the machine's geometry.
    pub counters: Counters,
    /// α evaluations that the machine executes (every pixel of a live sub-tile); `cycle` only.
    pub alpha_evaluations_executed: Option<u64>,
    /// Bytes and FLOPs by stage, order of `Stage::WORK`.
    pub stages: [StageBytes; 3],
    /// Action counts; empty in the `paper` model.
    pub actions: ActionCounts,
    /// Energy of the frame. Standby parts are for the frame's own time.
    pub energy: EnergyBreakdown,
    /// Power that is paid for time, watts: (leakage, DRAM background).
    pub standby_w: [f64; 2],
    /// When everything happened; `None` in the `paper` model.
    pub timing: Option<FrameTiming>,
    /// Clock, hertz, with `timing`.
    pub clock_hz: Option<f64>,
    /// Display power of the frame's image, watts, where the trace carries the image means.
    pub display_w: Option<f64>,
}
