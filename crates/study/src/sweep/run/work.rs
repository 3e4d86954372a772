//! The work of a sweep: trace by trace, every frame prepared once for all that need the same of it
//! and every machine timed on it.

use std::sync::Mutex;

use rayon::prelude::*;

use super::folder::SweepFolder;
use super::opened::{Designs, OpenedSweep};
use super::plan::Plan;
use super::running::Running;
use super::shared::SharedResults;
use super::traces::SweepTrace;
use super::watch::SweepWatch;
use crate::sweep::record::Record;
use powergs_core::kernel::Halt;
use powergs_core::run::{RunError, Window};

/// Machines that are taken through the windows of a trace together, where its frames do not fit
/// into memory at once.
const BLOCK: usize = 8192;

/// Where results are kept.
pub struct ResultSink<'a, 's> {
    /// The folder of the sweep.
    pub folder: &'a mut SweepFolder<'s>,
    /// What sweeps share.
    pub shared: &'a mut SharedResults,
}

impl ResultSink<'_, '_> {
    fn append(&mut self, key: u128, record: &Record) -> Result<(), RunError> {
        self.folder.records.append(key, record)?;
        self.shared.append(key, record)
    }

    /// Whether a result is known; what sweeps share is copied.
    fn knows(&mut self, key: u128) -> Result<bool, RunError> {
        if self.folder.records.has(key) {
            return Ok(true);
        }
        let Some(record) = self.shared.get(key)? else { return Ok(false) };
        self.folder.records.append(key, &record)?;
        Ok(true)
    }
}

/// Simulates what is not known yet of some machines of a plan, with at most `memory` bytes of
/// binned frames (one frame at least). Returns whether everything is done; not after a
/// cancellation.
///
/// A simulation that fails gives failed records of its designs; the others go on.
///
/// # Errors
/// [`RunError::Input`]: a trace that cannot be read; [`RunError::Output`]: a store that cannot be
/// written.
pub fn work(
    sweep: &mut OpenedSweep<'_>,
    plan: &Plan,
    machines: &[Vec<u32>],
    sink: ResultSink<'_, '_>,
    memory: usize,
    watch: &dyn SweepWatch,
) -> Result<bool, RunError> {
    watch.working(sweep.frames() as u64 * machines.len() as u64, &sweep.objectives);
    let OpenedSweep { designs, traces, file, .. } = sweep;
    let mut work = RunWork { designs, plan, display_fps: file.display_fps, sink, memory, watch };
    for trace in traces {
        let of = |machine: &Vec<u32>| plan.designs[machine[0] as usize].work;
        // The plan has machines in the order of what they need of a frame.
        for machines in machines.chunk_by(|a, b| of(a) == of(b)) {
            let missing = work.missing(machines, trace)?;
            if !missing.is_empty() && !work.with_same_work(&missing, trace)? {
                return Ok(false);
            }
        }
    }
    work.sink.folder.records.sync()?;
    Ok(!watch.is_cancelled())
}

/// Everything that the work needs.
struct RunWork<'a, 's, 'f> {
    designs: &'a Designs,
    plan: &'a Plan,
    display_fps: f64,
    sink: ResultSink<'s, 'f>,
    memory: usize,
    watch: &'a dyn SweepWatch,
}

impl RunWork<'_, '_, '_> {
    /// The machines with a result that is not known.
    fn missing<'m>(
        &mut self,
        machines: &'m [Vec<u32>],
        trace: &SweepTrace<'_>,
    ) -> Result<Vec<&'m [u32]>, RunError> {
        let frames = trace.frames.range().len() as u64;
        let mut missing = Vec::new();
        for machine in machines {
            let mut all = true;
            for &design in machine {
                for table in 0..self.plan.tables {
                    let key = self.plan.key(design as usize, table, trace.hash);
                    all &= self.sink.knows(key)?;
                }
            }
            match all {
                true => self.watch.known(frames),
                false => missing.push(machine.as_slice()),
            }
        }
        Ok(missing)
    }

    /// Takes machines that need the same of a frame through a trace.
    fn with_same_work(
        &mut self,
        machines: &[&[u32]],
        trace: &mut SweepTrace<'_>,
    ) -> Result<bool, RunError> {
        let (plan, watch, memory) = (self.plan, self.watch, self.memory);
        let key = &plan.works[plan.designs[machines[0][0] as usize].work as usize];
        let SweepTrace { frames, hash, .. } = trace;
        let range = frames.range();
        let crew = Crew {
            plan,
            trace: *hash,
            designs: self.designs,
            display_fps: self.display_fps,
            eyes: frames.eyes(),
            sink: Mutex::new(&mut self.sink),
            watch,
        };
        let mut window = Window::bin(&mut **frames, key, range.start, memory)?;
        // With all frames in memory a machine goes through at one go and is kept at once.
        if window.is_whole {
            machines.par_iter().try_for_each(|machine| crew.through_all(machine, &window))?;
            return Ok(!watch.is_cancelled());
        }
        for block in machines.chunks(BLOCK) {
            // The first block finds the first window made.
            if window.start != range.start {
                window = Window::bin(&mut **frames, key, range.start, memory)?;
            }
            let mut running: Vec<Running> = block.par_iter().map(|m| crew.running(m)).collect();
            loop {
                running.par_iter_mut().for_each(|r| crew.through(r, &window));
                if watch.is_cancelled() {
                    return Ok(false);
                }
                if window.end == range.end {
                    break;
                }
                window = Window::bin(&mut **frames, key, window.end, memory)?;
            }
            block.iter().zip(running).try_for_each(|(machine, r)| crew.keep(machine, r))?;
        }
        Ok(true)
    }
}

/// What all machines with the same work on one trace share.
struct Crew<'a, 's, 'f, 'r> {
    plan: &'a Plan,
    /// Hash of the trace.
    trace: u128,
    designs: &'a Designs,
    display_fps: f64,
    /// Views that make a frame.
    eyes: usize,
    sink: Mutex<&'r mut ResultSink<'s, 'f>>,
    watch: &'a dyn SweepWatch,
}

impl Crew<'_, '_, '_, '_> {
    fn running(&self, machine: &[u32]) -> Running {
        let design = |&i: &u32| {
            let design = self.designs.design(self.plan.designs[i as usize].point);
            design.expect("it was a design when it was planned")
        };
        Running::new(machine.iter().map(design).collect(), self.eyes)
    }

    /// A machine through a window; does nothing after a cancellation.
    fn through(&self, running: &mut Running, window: &Window) {
        if !self.watch.is_cancelled() {
            let is_due = || self.watch.is_cancelled();
            running.frames(window, self.display_fps, Halt::when(&is_due));
            self.watch.simulated(window.frames.len() as u64);
        }
    }

    /// A machine through all frames, and its results kept.
    fn through_all(&self, machine: &[u32], window: &Window) -> Result<(), RunError> {
        if self.watch.is_cancelled() {
            return Ok(());
        }
        let mut running = self.running(machine);
        let is_due = || self.watch.is_cancelled();
        running.frames(window, self.display_fps, Halt::when(&is_due));
        if running.is_halted() {
            return Ok(());
        }
        self.watch.simulated(window.frames.len() as u64);
        self.keep(machine, running)
    }

    fn keep(&self, machine: &[u32], running: Running) -> Result<(), RunError> {
        let records = running.finish();
        records.iter().for_each(|record| self.watch.result(record));
        let mut sink = self.sink.lock().expect("no panic while it is held");
        let tables = self.plan.tables;
        for (k, record) in records.iter().enumerate() {
            let key = self.plan.key(machine[k / tables] as usize, k % tables, self.trace);
            sink.append(key, record)?;
        }
        Ok(())
    }
}
