//! Where what happened, when, and what it cost meet: one frame on one machine gives one
//! [`FrameReport`].

pub mod check;
pub mod cost;
pub mod frames;
pub mod measured;
pub mod paper;
pub mod statistics;

use crate::accel::{self, DramCommands, FrameTiming, Machine, UnitCycles};
use crate::action::{Action, ActionCounts, Stage};
use crate::energy::{Activity, Area, DramWork, EnergyBreakdown, Prices, StageWork, Standby};
use crate::quantity::Cycles;
use crate::splat::Counters;
use crate::workload::FrameWorkload;

pub use check::Breach;
pub use measured::{Lists, Measured, observed};

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
    check::geometry(workload, machine)?;
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
    check::geometry(workload, machine)?;
    let replay = accel::replay_with(workload, machine, measured.given(), &mut ());
    let activity = Activity {
        actions: &replay.actions,
        seconds: Cycles(replay.timing.frame).milliseconds(machine.clock) * 1e-3,
        idle: idle(&replay.timing),
        dram: replay.timing.dram.commands.as_ref().map(dram_work),
    };
    let (energy, standby) = (prices.breakdown(&activity), prices.standby(&activity));
    let report = FrameReport {
        frame: label.frame,
        name: label.name,
        counters: workload.counters,
        alpha_evaluations_executed: Some(replay.actions.total(Action::Alpha)),
        live_evaluations: Some(
            workload.chunks.iter().map(|c| u64::from(c.skipping.live_evaluations)).sum(),
        ),
        stages: Stage::WORK.map(|stage| stage_bytes(stage, &replay.actions)),
        energy,
        actions: replay.actions,
        standby,
        area: prices.area,
        timing: Some(replay.timing),
        clock_hz: Some(machine.clock.0),
        order: measured.order,
        cache: measured.cache_summary(),
        reuse: measured.reuse_summary(),
        display_w: label.display_w,
    };
    check::traffic(&report, &replay.served)?;
    check::timing(&report, machine)?;
    check::energy(&report, prices)?;
    Ok(report)
}

/// Share of the frame for which the units of each kind had no work.
fn idle(timing: &FrameTiming) -> [f64; 4] {
    let share = |unit: &UnitCycles| {
        let cycles = timing.frame as f64 * f64::from(unit.instances);
        if cycles > 0.0 { unit.idle as f64 / cycles } else { 0.0 }
    };
    let find = |name: &str| timing.units.iter().find(|u| u.unit == name);
    Area::UNITS.map(|name| find(name).map_or(0.0, share))
}

/// The commands that cost energy.
fn dram_work(commands: &DramCommands) -> DramWork {
    let stages = commands.stages.map(|s| StageWork {
        reads: s.reads,
        writes: s.writes,
        activates: s.activates,
    });
    DramWork { stages, refreshes: commands.refreshes }
}

fn stage_bytes(stage: Stage, actions: &ActionCounts) -> StageBytes {
    let sram = |action: &Action| matches!(action, Action::SramRead(_) | Action::SramWrite(_));
    StageBytes {
        read: actions.count(stage, Action::DramRead),
        write: actions.count(stage, Action::DramWrite),
        sram: Action::all().iter().filter(|a| sram(a)).map(|&a| actions.count(stage, a)).sum(),
        flops: 0,
    }
}
