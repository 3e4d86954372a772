//! What must hold before a frame runs, and after.

use super::{FeatureSource, FrameReplay};
use crate::flow::{FrameTask, Incompatible, InvariantViolated};
use crate::machine::Machine;
use crate::workload::{FrameWorkload, binning};

/// A machine runs only workloads of its geometry, and foveated ones only if it can show two levels;
/// what it does to make the lists of a frame fits into host memory.
///
/// # Errors
/// [`Incompatible`].
pub(super) fn fits(workload: &FrameWorkload, task: &FrameTask<'_>) -> Result<(), Incompatible> {
    let machine = task.machine;
    let (tiles, name) = (machine.tiles(), || machine.name.clone());
    if workload.fovea.is_some() && tiles.fovea.accumulators == 0 {
        return Err(Incompatible::Foveated { machine: name() });
    }
    let (splats, bits) = (workload.counters.intersecting_points, tiles.record.id_bits);
    if tiles.record.id_check && bits < 64 && splats > 1 << bits {
        return Err(Incompatible::Ids { machine: name(), splats, bits });
    }
    if workload.fovea.is_some() && tiles.training.interval > 0 {
        let why = "it is foveated, and a step of training has one level; extract the trace \
                   without a gaze, or set `training.interval` = 0";
        return Err(Incompatible::Other { machine: name(), why: why.into() });
    }
    tiles.shows(&machine.name, workload)?;
    if workload.geometry != tiles.geometry {
        let (workload, machine) = (workload.geometry, tiles.geometry);
        return Err(Incompatible::Geometry { workload, machine });
    }
    match tiles.list_shape().filter(|shape| task.memo.find(shape).is_none()) {
        Some(shape) => binning::demand(workload, &shape, task.budget)
            .map(drop)
            .map_err(|over| Incompatible::Lists { machine: name(), over }),
        None => Ok(()),
    }
}

/// What is read of the lists and of the features was written in this frame; the scene was uploaded
/// with the model, spilled keys are written before they are read, and lists that are reused come
/// from the frame before.
///
/// # Errors
/// [`InvariantViolated::Unwritten`].
pub(super) fn written(
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
        // Keys that were spilled were written in this stage, and are no reads of lists.
        law("the lists", sorting.read.saturating_sub(sorting.write), lists)?;
    }
    if record.feature_source == FeatureSource::Nobody {
        return Ok(());
    }
    let features = c.intersecting_points * record.projected.0;
    law("the features", c.fetched_points * record.feature.0, features)
}
