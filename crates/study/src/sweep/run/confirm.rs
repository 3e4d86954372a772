//! Designs of a sweep once more, with the `banked` model of the DRAM in place of `calibrated`.
//!
//! Their results are kept beside those of the sweep. The model is part of what decides timing, so
//! results of either model have keys of their own: neither is ever taken for the other.

use std::collections::BTreeSet;
use std::mem;
use std::time::Instant;

use super::folder::Shard;
use super::opened::OpenedSweep;
use super::plan::Plan;
use super::results::{Planned, each_row};
use super::running::Running;
use super::watch::SweepWatch;
use super::work::{ResultSink, work};
use crate::sweep::table::Cell;
use powergs_base::format::counted;
use powergs_core::kernel::Halt;
use powergs_core::run::{RunError, Window};

/// Designs that are confirmed at most.
pub const CONFIRMED_MAX: u16 = 20;

/// Work that takes less is not announced, seconds.
const PATIENCE_S: f64 = 2.0;

/// So few machine-frames are not announced.
const FEW: usize = 4;

/// Designs that were simulated with `banked`.
pub struct ConfirmedFront {
    /// Them, the base machine first.
    pub plan: Plan,
    /// Their rows in the table of the sweep, in the order of the space.
    pub rows: Vec<Vec<Cell>>,
}

/// These points, and the base machine, as `banked` makes them. `None` after a cancellation.
///
/// # Errors
/// As [`work()`]; [`RunError::Internal`]: a sweep without [`OpenedSweep::banked`].
pub fn on_banked(
    sweep: &mut OpenedSweep<'_>,
    points: &BTreeSet<u64>,
    sink: ResultSink<'_, '_>,
    memory: usize,
    watch: &dyn SweepWatch,
) -> Result<Option<ConfirmedFront>, RunError> {
    let banked = sweep.banked.take();
    let banked = banked.ok_or_else(|| RunError::Internal("designs without `banked`".into()))?;
    // `work` takes the designs of the sweep, so for its time these are they.
    let calibrated = mem::replace(&mut sweep.designs, banked);
    let rows = simulated(sweep, points, sink, memory, watch);
    // Before any error is handed on: the sweep has its own designs again in any case.
    sweep.banked = Some(mem::replace(&mut sweep.designs, calibrated));
    rows
}

fn simulated(
    sweep: &mut OpenedSweep<'_>,
    points: &BTreeSet<u64>,
    sink: ResultSink<'_, '_>,
    memory: usize,
    watch: &dyn SweepWatch,
) -> Result<Option<ConfirmedFront>, RunError> {
    let points = points.iter().copied();
    let Some(plan) = Plan::of(&sweep.designs, points, watch) else { return Ok(None) };
    let machines = plan.machines(Shard::WHOLE);
    let ResultSink { folder, shared } = sink;
    announce(sweep, &plan, &machines, &ResultSink { folder, shared }, watch)?;
    let sink = ResultSink { folder, shared };
    if !work(sweep, &plan, &machines, sink, memory, watch)? {
        return Ok(None);
    }
    let mut rows = Vec::new();
    each_row(sweep, Planned::of(&plan), &mut folder.records, |row| {
        rows.push(row);
        Ok(())
    })?;
    Ok(Some(ConfirmedFront { plan, rows }))
}

/// Says how long it takes, from one frame of one machine that has no results yet, if that is long.
fn announce(
    sweep: &mut OpenedSweep<'_>,
    plan: &Plan,
    machines: &[Vec<u32>],
    sink: &ResultSink<'_, '_>,
    watch: &dyn SweepWatch,
) -> Result<(), RunError> {
    let mut to_do: Vec<(usize, u32)> = Vec::new();
    for (t, trace) in sweep.traces.iter().enumerate() {
        let is_new = |machine: &&Vec<u32>| {
            let key = plan.key(machine[0] as usize, 0, trace.hash);
            !sink.folder.records.has(key)
        };
        to_do.extend(machines.iter().filter(is_new).map(|machine| (t, machine[0])));
    }
    let frames_of = |t: usize| sweep.traces[t].frames.range().len();
    let machine_frames: usize = to_do.iter().map(|(t, _)| frames_of(*t)).sum();
    let Some(&(t, first)) = to_do.first().filter(|_| machine_frames > FEW) else { return Ok(()) };
    let planned = &plan.designs[first as usize];
    let Ok(design) = sweep.designs.design(planned.point) else { return Ok(()) };
    let machine = &design.machine;
    let (key, fps) = (machine.flow().work_key(machine), sweep.file.display_fps);
    let frames = &mut *sweep.traces[t].frames;
    let start = frames.range().start;
    let window = Window::bin(frames, &key, start, 1)?;
    let began = Instant::now();
    Running::new(vec![design], 1).frames(&window, fps, Halt::NEVER);
    let threads = rayon::current_num_threads().min(machines.len());
    let seconds = began.elapsed().as_secs_f64() * machine_frames as f64 / threads as f64;
    if seconds > PATIENCE_S {
        watch.note(&format!(
            "{} again with `banked`: {}, about {} on {}; --confirm 0 leaves it out",
            counted(machines.len(), "design"),
            counted(machine_frames, "machine-frame"),
            duration(seconds),
            counted(threads, "thread"),
        ));
    }
    Ok(())
}

/// A time for people.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
