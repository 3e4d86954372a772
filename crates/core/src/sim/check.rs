//! Accounts that must close in every run. One that does not is a defect, never a warning.

use super::FrameReport;
use crate::flow::tile_wise::FeatureSource;
use crate::flow::tile_wise::{FrameReplay, RuleError};
use crate::kernel::FrameTiming;
use crate::machine::Machine;
use crate::stage::{DRAM_READ, DRAM_WRITE, hardware, stage};
use crate::workload::demand::Unbinnable;
use crate::workload::{FrameWorkload, Geometry, binning};
use powergs_base::budget::OverBudget;
use powergs_energy::Prices;
use powergs_energy::action::Phase;

/// Relative tolerance of sums of energies: they are added in different orders.
const ENERGY_TOLERANCE: f64 = 1e-9;

/// Relative tolerance of the DRAM rate: the bus keeps 32 fractional bits of its ticks per byte.
const RATE_TOLERANCE: f64 = 1e-6;

/// A frame that the machine cannot run, although nothing is wrong with either.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Incompatible {
    /// A workload on a machine of another geometry.
    #[error(
        "frame was binned for {workload:?}, the machine has {machine:?}; bin it again for this \
         machine"
    )]
    Geometry {
        /// Of the workload.
        workload: Geometry,
        /// Of the machine.
        machine: Geometry,
    },
    /// A foveated frame on a machine that cannot show it.
    #[error(
        "the frame is foveated, and machine `{machine}` has no accumulators for levels: set \
         `fovea.accumulators = 1` (two levels one after the other) or 2, take another machine \
         (`gscore`), or extract the trace without a gaze"
    )]
    Foveated {
        /// Name of the machine.
        machine: String,
    },
    /// More splats than the numbers in list entries can tell apart.
    #[error(
        "the frame has {splats} splats with a tile, and the lists of machine `{machine}` number \
         them with {bits} bits: set `record.id-bits` = {needed}, or `record.id-check` = false to \
         keep a published count of bytes",
        needed = 64 - (splats.max(&2) - 1).leading_zeros()
    )]
    Ids {
        /// Name of the machine.
        machine: String,
        /// Splats with at least one tile.
        splats: u64,
        /// `record.id-bits`.
        bits: u32,
    },
    /// Making the tile lists takes too much host memory.
    #[error(
        "the frame with the tile lists of machine `{machine}`, move by move, {over}, or set \
         `binning.method` = \"free\""
    )]
    Lists {
        /// Name of the machine.
        machine: String,
        /// What it takes.
        over: OverBudget,
    },
    /// A unit rule from outside of the crate broke its contract.
    #[error(transparent)]
    Rule(#[from] RuleError),
}

/// An account that did not close: a defect of the simulator.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InvariantViolated {
    /// Cycles of a unit do not add up.
    #[error(
        "internal error: frame {frame}: the {unit} accounts for {accounted} cycles of {expected}; \
         please report this"
    )]
    Cycles {
        /// The frame.
        frame: usize,
        /// The unit.
        unit: &'static str,
        /// Busy, stalled and idle cycles.
        accounted: u64,
        /// Instances x frame.
        expected: u64,
    },
    /// Bytes that the frame needs and bytes that the DRAM served differ.
    #[error(
        "internal error: frame {frame}: {stage} needs {charged} DRAM bytes (read, written), the \
         DRAM served {served}; please report this"
    )]
    Traffic {
        /// The frame.
        frame: usize,
        /// The stage, or `total`.
        stage: &'static str,
        /// Charged bytes, `read, written`.
        charged: String,
        /// Served bytes, `read, written`.
        served: String,
    },
    /// Requests were lost.
    #[error(
        "internal error: frame {frame}: {issued} DRAM requests issued, {served} served; please \
         report this"
    )]
    Requests {
        /// The frame.
        frame: usize,
        /// Issued.
        issued: u64,
        /// Served.
        served: u64,
    },
    /// The DRAM was faster than it can be.
    #[error(
        "internal error: frame {frame}: the DRAM moved {bytes} bytes in {seconds:.9} s, more than \
         its {rate:.3e} B/s; please report this"
    )]
    Bandwidth {
        /// The frame.
        frame: usize,
        /// Bytes moved.
        bytes: u64,
        /// Time of the frame.
        seconds: f64,
        /// Peak x efficiency, or the peak of the device, bytes per second.
        rate: f64,
    },
    /// More was read of a region than was written to it.
    #[error(
        "internal error: frame {frame}: {read} bytes of {region} are read and {written} were \
         written; please report this"
    )]
    Unwritten {
        /// The frame.
        frame: usize,
        /// The region of the memory.
        region: &'static str,
        /// Distinct bytes read.
        read: u64,
        /// Bytes written.
        written: u64,
    },
    /// Parts of the energy do not add up to the total.
    #[error(
        "internal error: frame {frame}: energy parts sum to {parts} pJ, the total is {total} pJ; \
         please report this"
    )]
    Energy {
        /// The frame.
        frame: usize,
        /// Actions x prices and time x watts.
        parts: f64,
        /// The total of the breakdown.
        total: f64,
    },
}

/// Why a frame has no report.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimError {
    /// The machine cannot run the frame.
    #[error(transparent)]
    Incompatible(#[from] Incompatible),
    /// A frame whose lists take more memory than is allowed.
    #[error(transparent)]
    Unbinnable(#[from] Unbinnable),
    /// A defect of the simulator.
    #[error(transparent)]
    Invariant(#[from] InvariantViolated),
}

/// A machine runs only workloads of its geometry, and foveated ones only if it can show two levels.
///
/// # Errors
/// [`Incompatible`].
pub(crate) fn fits(workload: &FrameWorkload, machine: &Machine) -> Result<(), Incompatible> {
    if workload.fovea.is_some() && machine.tiles().fovea.accumulators == 0 {
        return Err(Incompatible::Foveated { machine: machine.name.clone() });
    }
    let (splats, bits) = (workload.counters.intersecting_points, machine.tiles().record.id_bits);
    if machine.tiles().record.id_check && bits < 64 && splats > 1 << bits {
        return Err(Incompatible::Ids { machine: machine.name.clone(), splats, bits });
    }
    if workload.geometry == machine.tiles().geometry {
        return Ok(());
    }
    Err(Incompatible::Geometry { workload: workload.geometry, machine: machine.tiles().geometry })
}

/// Unit rules from outside of the crate kept to their contract.
///
/// # Errors
/// [`Incompatible::Rule`].
pub(crate) fn rules(replay: &FrameReplay) -> Result<(), Incompatible> {
    replay.rule_error.clone().map_or(Ok(()), |error| Err(error.into()))
}

/// DRAM bytes charged from the frame's totals equal the bytes that the DRAM served, by stage and
/// in total.
///
/// # Errors
/// [`InvariantViolated::Traffic`] for the first stage whose bytes differ, or for the total.
pub fn traffic(frame: usize, replay: &FrameReplay) -> Result<(), InvariantViolated> {
    let (actions, timing) = (&replay.actions, &replay.timing);
    let broken = |stage, charged: (u64, u64), served: (u64, u64)| InvariantViolated::Traffic {
        frame,
        stage,
        charged: format!("{}, {}", charged.0, charged.1),
        served: format!("{}, {}", served.0, served.1),
    };
    for (stage, by_stage) in Phase::WORK.into_iter().zip(replay.served.stages) {
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

/// What is read of the lists and of the features was written in this frame; the scene was uploaded
/// with the model, spilled keys are written before they are read, and lists that are reused come
/// from the frame before.
///
/// # Errors
/// [`InvariantViolated::Unwritten`].
pub(crate) fn written(
    frame: usize,
    workload: &FrameWorkload,
    machine: &Machine,
    replay: &FrameReplay,
    is_reused: bool,
) -> Result<(), InvariantViolated> {
    let (record, c) = (&machine.tiles().record, &workload.counters);
    let law = |region, read: u64, written: u64| {
        if read <= written {
            return Ok(());
        }
        Err(InvariantViolated::Unwritten { frame, region, read, written })
    };
    if !is_reused {
        let sorting = replay.served.stages[1];
        let lists = match machine.tiles().list_shape() {
            Some(shape) => {
                let entries = binning::entries(workload).into_iter().map(u64::from);
                entries.map(|n| shape.list_bytes(n)).sum()
            }
            None => c.tile_pairs * machine.tiles().list_entry(),
        };
        law("the lists", sorting.read.saturating_sub(sorting.write), lists)?;
    }
    if record.feature_source == FeatureSource::Nobody {
        return Ok(());
    }
    let features = c.intersecting_points * record.projected.0;
    law("the features", c.fetched_points * record.feature.0, features)
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
            let left = 1.0 - machine.second_master_share();
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
