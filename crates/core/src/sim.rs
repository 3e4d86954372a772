//! Where what happened, when, and what it cost meet: one frame on one machine gives one
//! [`FrameReport`].

pub mod check;
pub mod cost;
pub mod frames;
pub mod measured;
pub mod paper;
pub mod regions;
pub mod statistics;
pub mod timed;

use crate::accel::{FrameTiming, Machine};
use crate::action::ActionCounts;
use crate::energy::{Area, EnergyBreakdown, Prices, Standby};
use crate::workload::FrameWorkload;
use powergs_frame::fovea::LEVELS;
use powergs_frame::splat::{Counters, FoveaCounters};

pub use check::Breach;
pub use measured::{Lists, Measured, observed};
pub use regions::RegionReport;
pub use timed::{Timed, priced, time, time_again};

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

/// How well the sorted lists of a frame are sorted, measured with the machine's keys.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OrderSummary {
    /// Pairs of neighbours in all sorted lists.
    pub neighbours: u64,
    /// Neighbours in the wrong order of depth.
    pub out_of_order: u64,
    /// Neighbours with equal keys and different depths.
    pub equal_keys: u64,
    /// Pairs of one list, neighbours or not, in the wrong order.
    pub inversions: u64,
}

/// What the feature cache did in a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CacheSummary {
    /// Feature records found.
    pub hits: u64,
    /// Feature records read from DRAM.
    pub misses: u64,
}

/// What a frame took over from the order of the frame before.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReuseSummary {
    /// List entries that the frame before had too.
    pub kept: u64,
    /// List entries that it had not.
    pub added: u64,
    /// Entries of the frame before that are gone.
    pub gone: u64,
    /// Neighbours out of order because an old order was kept.
    pub out_of_order: u64,
}

/// What only foveated frames have.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FoveaSummary {
    /// Gaze, shares of width and height.
    pub gaze: [f32; 2],
    /// Tiles.
    pub tiles: u64,
    /// Tiles that blend two levels.
    pub blending_tiles: u64,
    /// Further counters.
    pub counters: FoveaCounters,
}

impl FoveaSummary {
    /// Of a binned frame; `None` for plain ones.
    pub fn of(workload: &FrameWorkload) -> Option<FoveaSummary> {
        let fovea = workload.fovea.as_ref()?;
        Some(FoveaSummary {
            gaze: fovea.looking.gaze,
            tiles: workload.tiles.len() as u64,
            blending_tiles: fovea.blending_tiles,
            counters: fovea.counters,
        })
    }
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
    /// Those of them whose pixel has not stopped; `cycle` only.
    pub live_evaluations: Option<u64>,
    /// Bytes and FLOPs by stage, order of `Stage::WORK`.
    pub stages: [StageBytes; 3],
    /// Action counts; empty in the `paper` model.
    pub actions: ActionCounts,
    /// Energy of the frame. Standby parts are for the frame's own time.
    pub energy: EnergyBreakdown,
    /// Power that is paid for time.
    pub standby: Standby,
    /// Area of the chip by block, where the energy table knows it.
    pub area: Option<Area>,
    /// When everything happened; `None` in the `paper` model.
    pub timing: Option<FrameTiming>,
    /// Clock, hertz, with `timing`.
    pub clock_hz: Option<f64>,
    /// The order of the lists, where it was checked.
    pub order: Option<OrderSummary>,
    /// The feature cache, where the machine has one.
    pub cache: Option<CacheSummary>,
    /// Sort reuse, where the machine does it.
    pub reuse: Option<ReuseSummary>,
    /// What only foveated frames have.
    pub fovea: Option<FoveaSummary>,
    /// R1 to R4 of a foveated frame; `cycle` only.
    pub regions: Option<[RegionReport; LEVELS]>,
    /// Display power of the frame's image, watts, where the trace carries the image means.
    pub display_w: Option<f64>,
}

/// What a report says about its frame without simulating it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Label {
    /// Position in the trace.
    pub frame: usize,
    /// Name of the view.
    pub name: String,
    /// Display power of the frame's image, watts, where it is known.
    pub display_w: Option<f64>,
}

impl FrameReport {
    /// Time of the frame, seconds; `None` in the `paper` model.
    pub fn frame_time_s(&self) -> Option<f64> {
        Some(self.timing.as_ref()?.frame as f64 / self.clock_hz?)
    }

    /// Frames per second when frames run back to back; `None` without a time.
    pub fn achieved_fps(&self) -> Option<f64> {
        self.frame_time_s().filter(|&s| s > 0.0).map(f64::recip)
    }

    /// Energy of the frame x achieved frames per second, watts.
    pub fn power_full_rate_w(&self) -> Option<f64> {
        Some(self.energy.total().0 * 1e-12 * self.achieved_fps()?)
    }

    /// Power at a display rate, watts: the work of `fps` frames a second, and what is paid for time
    /// during frames and between them.
    pub fn power_display_rate_w(&self, fps: f64) -> f64 {
        self.energy.dynamic().0 * 1e-12 * fps + self.standby_w(fps).iter().sum::<f64>()
    }

    /// Power that is paid for time at a display rate, watts: leakage, DRAM background, DRAM
    /// refresh.
    pub fn standby_w(&self, fps: f64) -> [f64; 3] {
        self.standby.at_rate(self.frame_time_s().unwrap_or(0.0), fps)
    }

    /// Whether the frame takes longer than a period of the display.
    pub fn misses_deadline(&self, fps: f64) -> bool {
        self.frame_time_s().is_some_and(|seconds| seconds > fps.recip())
    }
}

/// Simulates one frame on one machine (`cycle` model) as if it were the first of its trace, and
/// checks that every account closes.
///
/// # Errors
/// A [`Breach`] is a defect of the simulator, or a workload of another geometry.
pub fn simulate(
    label: Label,
    workload: &FrameWorkload,
    machine: &Machine,
    prices: &Prices,
) -> Result<FrameReport, Breach> {
    check::fits(workload, machine)?;
    simulate_measured(label, workload, &Measured::needed(workload, machine), machine, prices)
}

/// As [`simulate`], with what was measured of the frame before.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_measured(
    label: Label,
    workload: &FrameWorkload,
    measured: &Measured,
    machine: &Machine,
    prices: &Prices,
) -> Result<FrameReport, Breach> {
    let timed = time(label.frame, workload, measured, machine)?;
    priced(label, &timed, prices)
}
