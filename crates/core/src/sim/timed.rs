//! A frame on a machine before prices: one timing can be priced by several energy tables.

use super::{
    CycleReport, FrameReport, InvariantViolated, Label, ModelReport, SimError, StageBytes, check,
    regions,
};
use crate::flow::{FlowOutcome, FrameTask, Task};
use crate::kernel::{FrameTiming, UnitCycles};
use crate::stage::{DRAM_READ, DRAM_WRITE, hardware, stage};
use powergs_base::quantity::Hertz;
use powergs_energy::action::{ActionCounts, Phase};
use powergs_energy::hardware::Does;
use powergs_energy::{Activity, Prices};
use powergs_frame::scene::ShDegree;
use powergs_frame::splat::Counters;

/// A frame on a machine: counts and times, everything except costs.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// The SH degree that the frame counts as.
    pub sh_degree: ShDegree,
    /// Workload counters under the machine's geometry.
    pub counters: Counters,
    /// Clock of the machine.
    pub clock: Hertz,
    /// What the frame is.
    pub task: Task,
    /// Cycles from its begin to its end.
    pub latency: u64,
    /// What came out, with the cycles of clocks.
    pub outcome: FlowOutcome,
}

/// Takes a frame through a machine, and checks every account except energy.
///
/// # Errors
/// [`SimError`]: a frame that the machine cannot run, or a defect of the simulator.
pub fn time(task: &FrameTask<'_>) -> Result<Timed, SimError> {
    let FrameTask { frame, machine, work, .. } = *task;
    let flow = machine.flow();
    flow.fits(task)?;
    let mut outcome = flow.run(task, None)?;
    check::traffic(frame, &outcome)?;
    check::timing(frame, &outcome.timing, machine)?;
    for (action, does) in hardware().actions() {
        let (unit, is_idle) = match does {
            Does::Clock(unit) => (unit, false),
            Does::IdleClock(unit) => (unit, true),
            _ => continue,
        };
        let Some(cycles) = outcome.timing.unit(unit) else { continue };
        let awake = cycles.busy + cycles.stalls.iter().sum::<u64>();
        let n = if is_idle { cycles.idle } else { awake };
        outcome.actions.charge(stage(unit).phase, action, n);
    }
    check::done(frame, &outcome.actions, machine)?;
    let (sh_degree, counters) = (work.sh_degree(), *work.counters());
    let (clock, task) = (machine.clock, flow.task(machine));
    let latency = outcome.timing.frame.saturating_mul(flow.under_way(machine));
    Ok(Timed { sh_degree, counters, clock, task, latency, outcome })
}

/// The report of a timed frame, with the prices of its machine or of another energy table for it.
/// Colours are priced for the SH degree of the frame.
///
/// # Errors
/// [`InvariantViolated`]: a defect of the simulator.
pub fn priced(
    label: Label,
    timed: &Timed,
    prices: &Prices,
) -> Result<FrameReport, InvariantViolated> {
    let prices = &prices.of_degree(timed.sh_degree);
    let outcome = &timed.outcome;
    let activity = Activity {
        actions: &outcome.actions,
        // By way of milliseconds: recorded results have this rounding.
        seconds: outcome.timing.frame as f64 / timed.clock.0 * 1e3 * 1e-3,
        idle: &idle(&outcome.timing),
        dram: outcome.timing.dram.commands,
    };
    let report = FrameReport {
        frame: label.frame,
        name: label.name,
        eye: label.eye,
        eyes: 1,
        sh_degree: label.sh_degree,
        counters: timed.counters,
        stages: Phase::WORK.map(|stage| stage_bytes(stage, &outcome.actions)),
        energy: prices.breakdown(&activity),
        actions: outcome.actions.clone(),
        standby: prices.standby(&activity),
        area: prices.area.clone(),
        phy_standby_w: prices.phy_standby_w,
        display_w: label.display_w.filter(|_| timed.task.is_shown()),
        model: ModelReport::Cycle(Box::new(CycleReport {
            timing: outcome.timing.clone(),
            clock: timed.clock,
            task: timed.task,
            latency: timed.latency,
            executed_evaluations: outcome.executed_evaluations,
            live_evaluations: outcome.live_evaluations,
            unwritten_bytes: outcome.unwritten_bytes,
            measured: outcome.measured.clone(),
            fovea: regions::priced(timed, prices),
        })),
    };
    check::energy(&report, prices)?;
    Ok(report)
}

impl FrameReport {
    /// Power at a display rate as other prices of its machine have it, watts: its counts and times
    /// are the same. With the prices that it was made with it is what
    /// [`FrameReport::power_display_rate_w`] says, but for rounding. `None` in the `paper` model,
    /// which counts no actions.
    pub fn power_with_w(&self, prices: &Prices, fps: f64) -> Option<f64> {
        let timing = self.timing()?;
        let seconds = self.frame_time_s()?;
        let activity = Activity {
            actions: &self.actions,
            seconds,
            idle: &idle(timing),
            dram: timing.dram.commands,
        };
        let prices = prices.of_degree(self.colour_degree());
        let work = prices.breakdown(&activity).dynamic().0 * 1e-12 * self.displayed_fps(fps);
        let standby = prices.standby(&activity).at_rate(seconds, self.displayed_fps(fps));
        Some(work + standby.iter().sum::<f64>())
    }
}

/// Share of the frame for which the units of each kind had no work, in the order of their numbers.
fn idle(timing: &FrameTiming) -> Vec<f64> {
    let share = |unit: &UnitCycles| {
        let cycles = timing.frame as f64 * f64::from(unit.instances);
        if cycles > 0.0 { unit.idle as f64 / cycles } else { 0.0 }
    };
    hardware().units().map(|(id, _)| timing.unit(id).map_or(0.0, share)).collect()
}

fn stage_bytes(stage: Phase, actions: &ActionCounts) -> StageBytes {
    let sram = |does| matches!(does, Does::SramRead(_) | Does::SramWrite(_));
    let all = hardware().actions().filter(|(_, does)| sram(*does));
    StageBytes {
        read: actions.count(stage, DRAM_READ),
        write: actions.count(stage, DRAM_WRITE),
        sram: all.map(|(action, _)| actions.count(stage, action)).sum(),
        flops: 0,
    }
}
