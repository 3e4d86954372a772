//! A sweep of one's own: axes over a system, without a sweep file.

use std::path::Path;
use std::sync::Arc;

use powergs_core::run::files::{DiskFiles, Files, RUN_KEY, is_yaml};
use powergs_core::run::{ConfigText, FileKind, Frames, RunError, Store, System};
use toml::Value;

use super::folder::{Existing, Shard, SweepFolder};
use super::opened::{Designs, OpenedSweep};
use super::plan::Plan;
use super::results::{Results, Tally};
use super::search::search;
use super::shared::SharedResults;
use super::traces::SweepTrace;
use super::watch::SweepWatch;
use super::work::{ResultSink, work};
use crate::sweep::file::{AxisSpec, Objectives, Raw, Sampling, Settings, SweepFile};
use crate::sweep::table::TraceLabel;

/// Memory for binned frames, bytes.
const MEMORY: usize = 768 << 20;

/// What the base system's display is called.
const DISPLAY: &str = "own";

/// A sweep over a system: every combination of the values of its axes.
///
/// ```no_run
/// use powergs_core::run::{MemoryStore, System, TraceFile};
/// use powergs_study::sweep::run::Sweep;
///
/// # fn main() -> Result<(), powergs_core::run::RunError> {
/// let mut trace = TraceFile::open("traces/demo.bin".as_ref())?;
/// let table = Sweep::over(System::named("gscore")?)
///     .axis("vru.cores", [2, 4, 8])
///     .axis("buffers.feature.capacity", ["64 KiB", "128 KiB"])
///     .run(&mut trace, &MemoryStore::new(), &())?;
/// for row in table.means() {
///     let number = |column| table.number(row, column).unwrap_or(f64::NAN);
///     println!("{} cores: {:.0} FPS", number("vru.cores"), number("fps.mean"));
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Sweep {
    base: System,
    name: String,
    question: String,
    axes: Vec<AxisSpec>,
    constraints: Vec<String>,
    objectives: Option<Objectives>,
    sampling: Sampling,
    display_fps: f64,
    memory: usize,
}

impl Sweep {
    /// A sweep over a system, without axes yet.
    pub fn over(base: System) -> Sweep {
        let name = base.machine().name.clone();
        Sweep {
            question: format!("Which design of {name} is best?"),
            name,
            base,
            axes: Vec::new(),
            constraints: Vec::new(),
            objectives: None,
            sampling: Sampling::default(),
            display_fps: 60.0,
            memory: MEMORY,
        }
    }

    /// The same with a key that takes each of these values, as a sweep file names it: `vru.cores`,
    /// `dram:timing.burst`. The last axis counts fastest.
    pub fn axis<V: Into<Value>>(mut self, key: &str, values: impl IntoIterator<Item = V>) -> Sweep {
        let values = values.into_iter().map(|value| Raw(value.into())).collect();
        let key = Some(key.to_owned());
        self.axes.push(AxisSpec { key, values: Some(values), ..AxisSpec::default() });
        self
    }

    /// The same with an expression that every design must fulfil: `ccu.units * vru.cores <= 32`.
    pub fn constraint(mut self, expression: &str) -> Sweep {
        self.constraints.push(expression.to_owned());
        self
    }

    /// The same with a column of the table that is to be small.
    pub fn minimize(mut self, column: &str) -> Sweep {
        self.wanted().minimize.push(column.to_owned());
        self
    }

    /// The same with a column of the table that is to be large.
    pub fn maximize(mut self, column: &str) -> Sweep {
        self.wanted().maximize.push(column.to_owned());
        self
    }

    fn wanted(&mut self) -> &mut Objectives {
        let none =
            Objectives { minimize: Vec::new(), maximize: Vec::new(), ..Objectives::default() };
        self.objectives.get_or_insert(none)
    }

    /// The same with some points of the space only; all of them without it.
    pub fn sampling(self, sampling: Sampling) -> Sweep {
        Sweep { sampling, ..self }
    }

    /// The same at another display rate, frames per second; 60 without it.
    pub fn display_fps(self, display_fps: f64) -> Sweep {
        Sweep { display_fps, ..self }
    }

    /// The same with at most so many bytes of binned frames in memory, one frame at least.
    pub fn memory(self, bytes: usize) -> Sweep {
        Sweep { memory: bytes, ..self }
    }

    /// What it spans, without any frames.
    ///
    /// # Errors
    /// [`RunError::Config`]: as [`Sweep::open`].
    pub fn designs(&self) -> Result<Designs, RunError> {
        let files: Arc<dyn Files> = Arc::new(BaseFiles { base: self.base.clone() });
        Designs::new(&self.file()?, Vec::new(), &files, &self.name).map_err(|e| self.told(e))
    }

    /// An error with the machine that the axes are over: who names none has not seen it.
    fn told(&self, error: RunError) -> RunError {
        match error {
            RunError::Config { place, message } if place == self.name => {
                RunError::Config { place: format!("axes over `{place}`"), message }
            }
            other => other,
        }
    }

    /// Checks the sweep on these frames.
    ///
    /// # Errors
    /// [`RunError::Config`]: unknown keys and columns with the nearest one, values that a key does
    /// not take, a space without a design; [`RunError::Input`]: frames that cannot be read.
    pub fn open<'f>(&self, frames: &'f mut dyn Frames) -> Result<OpenedSweep<'f>, RunError> {
        self.open_on([Box::new(frames) as Box<dyn Frames + 'f>])
    }

    /// Checks the sweep on several lists of frames, which have different names and equal weights.
    ///
    /// # Errors
    /// As [`Sweep::open`].
    pub fn open_on<'f>(
        &self,
        lists: impl IntoIterator<Item = Box<dyn Frames + 'f>>,
    ) -> Result<OpenedSweep<'f>, RunError> {
        let file = self.file()?;
        let trace = |frames: Box<dyn Frames + 'f>| {
            let label = TraceLabel { label: frames.name().to_owned(), weight: 1.0 };
            SweepTrace::new(frames, label)
        };
        let traces = lists.into_iter().map(trace).collect::<Result<_, _>>()?;
        let files = Arc::new(BaseFiles { base: self.base.clone() });
        OpenedSweep::of(&self.name, file, files, traces).map_err(|e| self.told(e))
    }

    /// Simulates every design on every frame, as far as `store` does not know it, and returns the
    /// table: the base system, then every design in the order of the space ([`Results::means`] has
    /// one row of each).
    /// After a cancellation, what is done is kept in the store, and the same call continues.
    ///
    /// # Errors
    /// As [`Sweep::open`]; [`RunError::Output`]: the store cannot be written, or holds another
    /// sweep.
    pub fn run(
        &self,
        frames: &mut dyn Frames,
        store: &dyn Store,
        watch: &dyn SweepWatch,
    ) -> Result<Results, RunError> {
        self.open(frames)?.run(store, self.memory, watch)
    }

    /// Simulates a part of the designs; whoever does the last part, or runs the whole on the same
    /// store, has the table. Returns whether the part is done; not after a cancellation.
    ///
    /// # Errors
    /// As [`Sweep::run`]; [`RunError::Request`]: an adaptive search has no parts.
    pub fn run_part(
        &self,
        part: Shard,
        frames: &mut dyn Frames,
        store: &dyn Store,
        watch: &dyn SweepWatch,
    ) -> Result<bool, RunError> {
        let mut sweep = self.open(frames)?;
        if sweep.designs.is_adaptive() {
            let what = "an adaptive search has no parts: every generation needs the one before";
            return Err(RunError::Request(what.into()));
        }
        let mut folder = SweepFolder::open(store, &sweep.state, Existing::Resume, Some(part))?;
        let mut shared = SharedResults::default();
        let Some(plan) = Plan::new(&sweep.designs, watch) else { return Ok(false) };
        let sink = ResultSink { folder: &mut folder, shared: &mut shared };
        work(&mut sweep, &plan, &plan.machines(part), sink, self.memory, watch)
    }

    /// The sweep as a file has it.
    fn file(&self) -> Result<SweepFile, RunError> {
        let file = SweepFile {
            question: self.question.clone(),
            base: self.name.clone(),
            set: Settings::default(),
            traces: Vec::new(),
            energy: Vec::new(),
            display: self.base.display().map(|_| DISPLAY.to_owned()),
            display_fps: self.display_fps,
            objectives: self.objectives.clone().unwrap_or_default(),
            axes: self.axes.clone(),
            derived: Settings::default(),
            constraints: self.constraints.clone(),
            sampling: self.sampling.clone(),
            has_common_axes: false,
            folder: None,
            typed: Vec::new(),
            text: String::new(),
        };
        let text = toml::to_string(&file).map_err(|e| RunError::Internal(e.to_string()))?;
        SweepFile::parse(&text).map_err(|e| RunError::config(&self.name, e))
    }
}

impl OpenedSweep<'_> {
    /// Simulates every design on every trace, as far as `store` does not know it, with at most
    /// `memory` bytes of binned frames, and returns the table: see [`Sweep::run`].
    ///
    /// # Errors
    /// As [`Sweep::run`].
    pub fn run(
        &mut self,
        store: &dyn Store,
        memory: usize,
        watch: &dyn SweepWatch,
    ) -> Result<Results, RunError> {
        let mut folder = SweepFolder::open(store, &self.state, Existing::Resume, None)?;
        let mut shared = SharedResults::default();
        let plan = if self.designs.is_adaptive() {
            search(self, &mut folder, &mut shared, memory, watch)?
        } else {
            let plan = Plan::new(&self.designs, watch);
            if let Some(plan) = &plan {
                let sink = ResultSink { folder: &mut folder, shared: &mut shared };
                let machines = plan.machines(Shard::WHOLE);
                work(self, plan, &machines, sink, memory, watch)?;
            }
            plan
        };
        match plan {
            Some(plan) => Results::of(self, &plan, &mut folder.records),
            None => Ok(Results::none(self)),
        }
    }
}

/// The files of a system as it is used; others by name or path.
struct BaseFiles {
    base: System,
}

impl Files for BaseFiles {
    fn read(
        &self,
        kind: FileKind,
        name: &str,
        folder: Option<&Path>,
    ) -> Result<ConfigText, RunError> {
        let machine = self.base.machine();
        let own = match kind {
            FileKind::Machine => name == machine.name,
            FileKind::Energy => name == machine.energy,
            FileKind::Dram => name == machine.dram.device,
            FileKind::Display => name == DISPLAY,
        };
        match self.base.table(kind).filter(|_| own) {
            Some(table) => {
                // What it names further is known here, but for a run, which lies where it is named.
                let folder = self.base.read(kind).and_then(|file| file.folder_of(RUN_KEY, &[]));
                // It is TOML, whatever it was read from.
                let origin = if is_yaml(name) { format!("{name} as TOML") } else { name.into() };
                Ok(ConfigText::new(origin, folder, table.to_string()))
            }
            None => DiskFiles.read(kind, name, folder),
        }
    }
}

impl Results {
    /// No rows: the walk through the space was cancelled.
    fn none(sweep: &OpenedSweep<'_>) -> Results {
        let columns = super::results::header(sweep);
        Results { columns, rows: Vec::new(), tally: Tally::default(), is_complete: false }
    }
}
