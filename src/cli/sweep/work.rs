//! The work of a sweep: geometry by geometry, trace by trace, every frame binned once and every
//! machine timed on it.

use std::sync::Mutex;

use rayon::prelude::*;

use super::folder::SweepFolder;
use super::meter::Meter;
use super::opened::Opened;
use super::plan::Plan;
use super::running::Running;
use super::store::Store;
use super::traces::OpenedTrace;
use super::window::Window;
use crate::cli::{Context, Failure};
use powergs_core::run::Frames;
use powergs_study::sweep::design::Design;
use powergs_study::sweep::journal::Record;
use powergs_study::sweep::space::Space;

/// Machines that are taken through the windows of a trace together, where its frames do not fit
/// into memory at once.
const BLOCK: usize = 8192;

/// Everything that the work needs.
pub struct Work<'a> {
    /// The sweep.
    pub opened: &'a mut Opened,
    /// Its designs.
    pub plan: &'a Plan,
    /// Where results are kept.
    pub sink: Sink<'a>,
    /// Bytes for binned frames.
    pub memory: usize,
    /// What the user sees.
    pub meter: &'a Meter,
    /// Ctrl-C.
    pub context: &'a Context,
}

/// Where results are kept.
pub struct Sink<'a> {
    /// The folder of the sweep.
    pub folder: &'a mut SweepFolder,
    /// What sweeps share.
    pub store: &'a mut Store,
}

impl Sink<'_> {
    fn append(&mut self, key: u128, record: &Record) -> Result<(), Failure> {
        self.folder.records.append(key, record)?;
        self.store.append(key, record)
    }

    /// Whether a result is known; what the store knows is copied.
    fn knows(&mut self, key: u128) -> Result<bool, Failure> {
        if self.folder.records.index.place(key).is_some() {
            return Ok(true);
        }
        let Some(record) = self.store.get(key)? else { return Ok(false) };
        self.folder.records.append(key, &record)?;
        Ok(true)
    }
}

/// Does what is not done yet. Returns whether everything is done; not if the user broke off.
///
/// # Errors
/// Exit code 3: a trace that cannot be read; 2: a folder that cannot be written.
pub fn run(mut work: Work, machines: &[Vec<u32>]) -> Result<bool, Failure> {
    for trace in 0..work.opened.traces.len() {
        let of = |machine: &Vec<u32>| work.plan.designs[machine[0] as usize].geometry;
        for machines in machines.chunk_by(|a, b| of(a) == of(b)) {
            let missing = missing(&mut work, machines, trace)?;
            if !missing.is_empty() && !one_geometry(&mut work, &missing, trace)? {
                return Ok(false);
            }
        }
    }
    work.sink.folder.records.sync()?;
    Ok(!work.context.is_cancelled())
}

/// The machines with a result that is not known.
fn missing<'m>(
    work: &mut Work,
    machines: &'m [Vec<u32>],
    trace: usize,
) -> Result<Vec<&'m [u32]>, Failure> {
    let frames = work.opened.traces[trace].source.range().len() as u64;
    let hash = work.opened.traces[trace].hash;
    let mut missing = Vec::new();
    for machine in machines {
        let mut all = true;
        for &design in machine {
            for table in 0..work.plan.tables {
                let key = work.plan.key(design as usize, table, hash);
                all &= work.sink.knows(key)?;
            }
        }
        match all {
            true => work.meter.known(frames),
            false => missing.push(machine.as_slice()),
        }
    }
    Ok(missing)
}

/// Takes machines of one geometry through a trace.
fn one_geometry(work: &mut Work, machines: &[&[u32]], trace: usize) -> Result<bool, Failure> {
    let Work { opened, plan, sink, memory, meter, context } = work;
    let geometry = plan.geometries[plan.designs[machines[0][0] as usize].geometry as usize];
    let Opened { space, base, traces, display_fps, .. } = &mut **opened;
    let OpenedTrace { source, hash, .. } = &mut traces[trace];
    let range = source.range();
    let crew = Crew {
        plan,
        trace: *hash,
        space,
        base,
        display_fps: *display_fps,
        sink: Mutex::new(sink),
        meter,
        context,
    };
    let mut window = Window::bin(source, geometry, range.start, *memory)?;
    if window.is_whole {
        machines.par_iter().try_for_each(|machine| crew.through_all(machine, &window))?;
        return Ok(!context.is_cancelled());
    }
    for block in machines.chunks(BLOCK) {
        if window.start != range.start {
            window = Window::bin(source, geometry, range.start, *memory)?;
        }
        let mut running: Vec<Running> = block.par_iter().map(|m| crew.running(m)).collect();
        loop {
            running.par_iter_mut().for_each(|r| crew.through(r, &window));
            if context.is_cancelled() {
                return Ok(false);
            }
            if window.end == range.end {
                break;
            }
            window = Window::bin(source, geometry, window.end, *memory)?;
        }
        block.iter().zip(running).try_for_each(|(machine, r)| crew.keep(machine, r))?;
    }
    Ok(true)
}

/// What all machines of one geometry on one trace share.
struct Crew<'a, 's> {
    plan: &'a Plan,
    /// Hash of the trace.
    trace: u128,
    space: &'a Space,
    base: &'a Design,
    display_fps: f64,
    sink: Mutex<&'a mut Sink<'s>>,
    meter: &'a Meter,
    context: &'a Context,
}

impl Crew<'_, '_> {
    fn running(&self, machine: &[u32]) -> Running {
        let design = |&i: &u32| match self.plan.designs[i as usize].point {
            None => self.base.clone(),
            Some(point) => self.space.design(point).expect("it was a design when it was planned"),
        };
        Running::new(machine.iter().map(design).collect())
    }

    /// A machine through a window; does nothing once the user has broken off.
    fn through(&self, running: &mut Running, window: &Window) {
        if !self.context.is_cancelled() {
            running.frames(window, self.display_fps);
            self.meter.done(window.frames.len() as u64);
        }
    }

    /// A machine through all frames, and its results kept.
    fn through_all(&self, machine: &[u32], window: &Window) -> Result<(), Failure> {
        if self.context.is_cancelled() {
            return Ok(());
        }
        let mut running = self.running(machine);
        running.frames(window, self.display_fps);
        self.meter.done(window.frames.len() as u64);
        self.keep(machine, running)
    }

    fn keep(&self, machine: &[u32], running: Running) -> Result<(), Failure> {
        let records = running.finish();
        records.iter().for_each(|record| self.meter.best(record));
        let mut sink = self.sink.lock().expect("no panic while it is held");
        let tables = self.plan.tables;
        for (k, record) in records.iter().enumerate() {
            let key = self.plan.key(machine[k / tables] as usize, k % tables, self.trace);
            sink.append(key, record)?;
        }
        Ok(())
    }
}
