//! Accounts that must close in every run. One that does not is a defect, never a warning.

use super::{FrameReport, InvariantViolated};
use crate::flow::FlowOutcome;
use crate::kernel::FrameTiming;
use crate::machine::Machine;
use crate::stage::{DRAM_READ, DRAM_WRITE, hardware, stage};
use powergs_energy::Prices;
use powergs_energy::action::{ActionCounts, Phase, StageId};
use powergs_energy::hardware::Does;

/// Relative tolerance of sums of energies: they are added in different orders.
const ENERGY_TOLERANCE: f64 = 1e-9;

/// Relative tolerance of the DRAM rate: the bus keeps 32 fractional bits of its ticks per byte.
const RATE_TOLERANCE: f64 = 1e-6;

/// DRAM bytes charged from the frame's totals equal the bytes that the DRAM served, by stage and
/// in total.
///
/// # Errors
/// [`InvariantViolated::Traffic`] for the first stage whose bytes differ, or for the total.
pub fn traffic(frame: usize, outcome: &FlowOutcome) -> Result<(), InvariantViolated> {
    let (actions, timing) = (&outcome.actions, &outcome.timing);
    let broken = |stage, charged: (u64, u64), served: (u64, u64)| InvariantViolated::Traffic {
        frame,
        stage,
        charged: format!("{}, {}", charged.0, charged.1),
        served: format!("{}, {}", served.0, served.1),
    };
    for (stage, by_stage) in Phase::WORK.into_iter().zip(outcome.served.stages) {
        let count = |action| actions.count(stage, action);
        let charged = (count(DRAM_READ), count(DRAM_WRITE));
        let served = (by_stage.read, by_stage.write);
        if charged != served {
            return Err(broken(stage.name(), charged, served));
        }
    }
    let total = |action| actions.total(action);
    let charged = (total(DRAM_READ), total(DRAM_WRITE));
    let served = (timing.dram.read_bytes, timing.dram.write_bytes);
    if charged == served { Ok(()) } else { Err(broken("total", charged, served)) }
}

/// Everything that is counted is done by something that the machine has: work by units, accesses by
/// buffers. What nothing does would have no price, and would be left out of the energy.
///
/// # Errors
/// [`InvariantViolated::Undone`] for the first action that nothing does.
pub fn done(
    frame: usize,
    actions: &ActionCounts,
    machine: &Machine,
) -> Result<(), InvariantViolated> {
    let (hardware, inventory) = (hardware(), machine.inventory());
    let has = |stage: StageId| inventory.units[stage.index()] > 0;
    let is_done = |does| match does {
        Does::Work(declares, work) => hardware.doers(declares, work.key).any(has),
        Does::Clock(stage) | Does::IdleClock(stage) => has(stage),
        Does::SramRead(buffer) | Does::SramWrite(buffer) => {
            inventory.memories[buffer.index()].banks > 0
        }
        Does::DramRead | Does::DramWrite => true,
    };
    let mut undone = hardware.actions().filter(|(_, does)| !is_done(*does));
    match undone.find(|(action, _)| actions.total(*action) > 0) {
        None => Ok(()),
        Some((action, _)) => Err(InvariantViolated::Undone {
            frame,
            action: hardware.key(action),
            count: actions.total(action),
            machine: machine.name.clone(),
        }),
    }
}

/// Cycles of every unit add up to the frame; requests are all served; the DRAM keeps to its rate.
///
/// # Errors
/// [`InvariantViolated::Cycles`], [`InvariantViolated::Requests`] or
/// [`InvariantViolated::Bandwidth`], whichever comes first.
pub fn timing(
    frame: usize,
    timing: &FrameTiming,
    machine: &Machine,
) -> Result<(), InvariantViolated> {
    for unit in &timing.units {
        let accounted = unit.busy + unit.stalls.iter().sum::<u64>() + unit.idle;
        let expected = u64::from(unit.instances) * timing.frame;
        if accounted != expected {
            let unit = stage(unit.unit).key;
            return Err(InvariantViolated::Cycles { frame, unit, accounted, expected });
        }
    }
    let dram = &timing.dram;
    if dram.requests_issued != dram.requests_served {
        let (issued, served) = (dram.requests_issued, dram.requests_served);
        return Err(InvariantViolated::Requests { frame, issued, served });
    }
    let seconds = timing.frame as f64 / machine.clock.0;
    let (rate, bytes) = match (&dram.commands, &machine.device) {
        (Some(commands), Some(device)) => {
            let bursts: u64 = commands.stages.iter().map(|s| s.reads + s.writes).sum();
            (device.peak_gb_s() * 1e9, bursts * commands.burst_bytes)
        }
        _ => {
            let left = 1.0 - machine.memory().others_share();
            let rate = machine.dram_peak().0 * machine.dram.efficiency * left;
            (rate, dram.read_bytes + dram.write_bytes)
        }
    };
    if bytes as f64 > rate * seconds * (1.0 + RATE_TOLERANCE) || dram.busy_cycles > timing.frame {
        return Err(InvariantViolated::Bandwidth { frame, bytes, seconds, rate });
    }
    Ok(())
}

/// Actions x prices, DRAM commands x prices and standby watts x time add up to the total of the
/// breakdown.
///
/// # Errors
/// [`InvariantViolated::Energy`].
pub fn energy(report: &FrameReport, prices: &Prices) -> Result<(), InvariantViolated> {
    let priced = |(a, _)| report.actions.total(a) as f64 * prices.of(a).0;
    let work: f64 = hardware().actions().map(priced).sum();
    let commands = report.timing().and_then(|t| t.dram.commands.as_ref());
    let commands = commands.map_or(0.0, |c| prices.commands(&c.total()).0);
    let standby: f64 = report.standby.running_w.iter().sum();
    let time = standby * report.frame_time_s().unwrap_or(0.0);
    let (parts, total) = (work + commands + time * 1e12, report.energy.total().0);
    if (parts - total).abs() <= ENERGY_TOLERANCE * total.abs().max(parts.abs()) {
        return Ok(());
    }
    Err(InvariantViolated::Energy { frame: report.frame, parts, total })
}
