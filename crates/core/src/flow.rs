//! Dataflows: ways in which Gaussians become pixels.
//!
//! A dataflow says which tables a machine file has, which stages a machine is made of, and how a
//! frame goes through it. A machine file names its dataflow (`dataflow = "tile-wise"`); everything
//! around it (sessions, sweeps, what-if, sensitivity, the optimiser, Python) works on any of them.

use std::any::{Any, TypeId};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::io::Read;
use std::sync::{Mutex, PoisonError};

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::Spanned;
use toml::de::DeTable;

use crate::kernel::timeline::Observer;
use crate::kernel::{Halt, Memo};
use crate::machine::check::Found;
use crate::machine::{Machine, optional};
use crate::stage::{self, RegisterError, StageDecl};
use crate::workload::demand::Unbinnable;
use powergs_base::budget::Budget;
use powergs_base::config::embedded::{Embedded, MACHINES};
use powergs_base::config::schema_of;
use powergs_base::config::suggest::nearest;
use powergs_base::number::NumberFormat;
use powergs_base::quantity::BytesPerSecond;
use powergs_energy::action::Inventory;
use powergs_frame::scene::{Eye, ShDegree};
use powergs_frame::splat::Counters;
use powergs_frame::trace::Frame;

mod error;
pub mod gpu;
pub mod lists;
mod outcome;
pub mod over;
pub mod recorded;
pub mod resident;
pub mod steps;
mod task;
pub mod tile_wise;

pub use error::{Incompatible, InvariantViolated, SimError};
pub use outcome::{FlowOutcome, FoveaSummary, Foveal, RegionWork};
pub use task::{Task, TaskKind};

/// A dataflow.
pub trait Dataflow: Sync {
    /// The name in machine files.
    fn key(&self) -> &'static str;

    /// What it is, in one sentence.
    fn means(&self) -> &'static str;

    /// The machine file that comes with the program and shows it.
    fn example(&self) -> Option<&'static str> {
        None
    }

    /// The stages that its machines may have, in the order of every report. A stage may be of
    /// several dataflows.
    fn stages(&self) -> &'static [&'static StageDecl];

    /// Its tables in a machine file.
    fn tables(&self) -> TablesDecl;

    /// Adds what is wrong with keys of a machine that no stage has to itself.
    fn check(&self, _machine: &Machine, _found: &mut Found) {}

    /// What a machine is built of: where its stages do not say it, its tables do.
    fn inventory(&self, machine: &Machine) -> Inventory {
        machine.declared()
    }

    /// Reads what a machine needs besides its file; `open` finds a file that it names.
    ///
    /// # Errors
    /// What is wrong with such a file.
    fn attach(&self, _machine: &mut Machine, _open: &mut Opener<'_>) -> Result<(), String> {
        Ok(())
    }

    /// Takes over from a machine that this one is a variant of what no table has.
    ///
    /// # Errors
    /// A variant that there cannot be, and why.
    fn keep(&self, _machine: &mut Machine, _old: &Machine) -> Result<(), String> {
        Ok(())
    }

    /// Why a key cannot be changed in a machine; `None` where it can.
    fn fixed(&self, _key: &str) -> Option<String> {
        None
    }

    /// What a frame of a machine is.
    fn task(&self, _machine: &Machine) -> Task {
        Task::RENDER
    }

    /// What is doubtful about what [`Dataflow::attach`] read for a machine, in a sentence.
    fn doubt(&self, _machine: &Machine) -> Option<String> {
        None
    }

    /// Whether its machines run any frame; the others have those that were run elsewhere.
    fn runs_any_frame(&self) -> bool {
        true
    }

    /// Where its machine files have what is stored of a Gaussian; `None` where they do not.
    fn record(&self) -> Option<RecordKeys> {
        None
    }

    /// Everything in its tables that decides timing, as bytes: keys of parts that are not there are
    /// left out.
    fn timing(&self, machine: &Machine) -> Vec<u8> {
        let mut tables = machine.tables.to_toml();
        optional::leave_out(&mut tables, machine);
        let all = (machine.clock, tables);
        serde_json::to_vec(&all).expect("a machine has only tables, numbers and strings")
    }

    /// Peak rate of the memory of a machine without a device, where its tables say it.
    fn memory_rate(&self, _machine: &Machine) -> Option<BytesPerSecond> {
        None
    }

    /// Channels of the memory that the chip has PHY and controllers for.
    fn channels(&self, machine: &Machine) -> f64 {
        f64::from(machine.dram.channels)
    }

    /// The numbers that its units compute with, where the machine says.
    fn numbers(&self, _machine: &Machine) -> Option<NumberFormat> {
        None
    }

    /// Width and height of the tiles of an image, which timelines number row by row, pixels.
    fn tile(&self, machine: &Machine, image: [u32; 2]) -> [u32; 2];

    /// Whether phases of a frame overlap on a machine.
    fn overlaps(&self, _machine: &Machine) -> bool {
        false
    }

    /// Frames that a machine has under way at a time: a frame takes that many distances of two.
    fn under_way(&self, _machine: &Machine) -> u64 {
        1
    }

    /// What a machine needs of a frame.
    fn work_key(&self, machine: &Machine) -> WorkKey;

    /// Whether the machine can run the frame, and what it has to prepare further fits into memory.
    ///
    /// # Errors
    /// [`Incompatible`].
    fn fits(&self, task: &FrameTask<'_>) -> Result<(), Incompatible> {
        let (work, needed) = (task.work.key(), self.work_key(task.machine));
        if work == needed {
            return Ok(());
        }
        Err(Incompatible::Work {
            work: work.to_string(),
            machine: task.machine.name.clone(),
            needed: needed.to_string(),
        })
    }

    /// Whether a trace of so many frames shows what a machine does.
    ///
    /// # Errors
    /// Why so few do not, and what to do.
    fn goes_over(&self, machine: &Machine, frames: usize) -> Result<(), String> {
        over::pixels::goes_over(machine, frames)
    }

    /// What decides what a machine takes over from the frame before: machines with the same work
    /// and the same numbers take over the same. `None` where each frame stands alone.
    fn takes_over(&self, _machine: &Machine) -> Option<Vec<u32>> {
        None
    }

    /// What a machine takes over into this frame; frames come in order.
    fn hand_over(
        &self,
        _machine: &Machine,
        _work: &dyn Work,
        _eye: Option<Eye>,
        _history: &mut History,
    ) -> Option<Handed> {
        None
    }

    /// What machines must agree in to share a part of their runs on a frame, for estimates of time;
    /// `None` for a machine that shares nothing.
    fn shared(&self, _machine: &Machine) -> Option<String> {
        None
    }

    /// Takes a frame through a machine. Accounts that only the dataflow knows are closed.
    ///
    /// # Errors
    /// [`SimError`]: as [`Dataflow::fits`], or a defect of the simulator.
    fn run(
        &self,
        task: &FrameTask<'_>,
        observer: Option<&mut dyn Observer>,
    ) -> Result<FlowOutcome, SimError>;
}

/// The keys of what is stored of a Gaussian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RecordKeys {
    /// Bytes of the position.
    pub position: &'static str,
    /// Bytes of scale, rotation and opacity.
    pub shape: &'static str,
    /// Bytes of a colour.
    pub colour: &'static str,
    /// Distance of two colours in memory, bytes.
    pub pitch: &'static str,
    /// Bytes of a colour that do not get fewer with the degree of the scene, where the others do.
    pub extra: Option<&'static str>,
    /// The table of colours that records name by a number, where machines may have one.
    pub codebook: Option<&'static str>,
}

/// Finds and opens a file that a machine file names.
///
/// # Errors
/// That it cannot be opened, and why.
pub type Opener<'a> = dyn FnMut(&str) -> Result<Box<dyn Read>, String> + 'a;

/// A kind of work: what is prepared of a frame once, for many machines of any dataflow.
pub trait WorkKind: Sync {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Memory that preparing a frame for these numbers takes, bytes, at most about so much.
    ///
    /// # Errors
    /// [`Unbinnable`]: more than `budget`, or a frame that cannot be prepared at all.
    fn demand(&self, frame: &Frame, numbers: &[u32], budget: Budget) -> Result<u64, Unbinnable>;

    /// Prepares a frame.
    fn prepare(&self, frame: &Frame, numbers: &[u32]) -> Box<dyn Work>;
}

/// What decides what is prepared of a frame: machines with the same key share it.
#[derive(Clone)]
pub struct WorkKey {
    /// What it is.
    pub kind: &'static dyn WorkKind,
    /// Numbers that only the kind understands.
    pub numbers: Vec<u32>,
}

impl WorkKey {
    /// [`WorkKind::demand`].
    ///
    /// # Errors
    /// As there.
    pub fn demand(&self, frame: &Frame, budget: Budget) -> Result<u64, Unbinnable> {
        self.kind.demand(frame, &self.numbers, budget)
    }

    /// Prepares a frame for all machines with this key.
    pub fn prepare(&self, frame: &Frame) -> Box<dyn Work> {
        self.kind.prepare(frame, &self.numbers)
    }

    /// What tells keys apart.
    fn parts(&self) -> (&'static str, &[u32]) {
        (self.kind.name(), &self.numbers)
    }
}

impl PartialEq for WorkKey {
    fn eq(&self, other: &WorkKey) -> bool {
        self.parts() == other.parts()
    }
}

impl Eq for WorkKey {}

impl PartialOrd for WorkKey {
    fn partial_cmp(&self, other: &WorkKey) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for WorkKey {
    fn cmp(&self, other: &WorkKey) -> Ordering {
        self.parts().cmp(&other.parts())
    }
}

impl Hash for WorkKey {
    fn hash<H: Hasher>(&self, to: &mut H) {
        self.parts().hash(to);
    }
}

impl fmt::Debug for WorkKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for WorkKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {:?}", self.kind.name(), self.numbers)
    }
}

/// A frame, prepared for the machines with a key.
pub trait Work: Any + fmt::Debug + Send + Sync {
    /// Who shares it.
    fn key(&self) -> WorkKey;

    /// Frame totals.
    fn counters(&self) -> &Counters;

    /// Degree of the scene's spherical harmonics: 3 where the trace does not say.
    fn sh_degree(&self) -> ShDegree;

    /// Tiles of the image.
    fn tiles(&self) -> usize;

    /// Bytes in host memory.
    fn bytes(&self) -> usize;
}

impl dyn Work {
    /// The work of one dataflow; `None` where it is of another.
    pub fn of<T: Work>(&self) -> Option<&T> {
        let all: &dyn Any = self;
        all.downcast_ref()
    }
}

/// Something that is handed on from one frame to the next.
pub type Handed = Box<dyn Any + Send + Sync>;

/// What decides what a machine takes over into a frame: machines with the same one share it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct TakesOver {
    /// Who hands it over: two dataflows make different things of the same work.
    flow: &'static str,
    /// What it is made of.
    pub work: WorkKey,
    numbers: Vec<u32>,
}

impl TakesOver {
    /// That of a machine; `None` where each frame stands alone.
    pub fn of(machine: &Machine) -> Option<TakesOver> {
        let flow = machine.flow();
        let numbers = flow.takes_over(machine)?;
        Some(TakesOver { flow: flow.key(), work: flow.work_key(machine), numbers })
    }
}

/// What machines with the same [`TakesOver`] keep of frames: each eye of pairs has its
/// own, since the order of a view is kept best by the next one of the same eye.
#[derive(Default)]
pub struct History([BTreeMap<TypeId, Handed>; Eye::ALL.len()]);

impl History {
    /// Takes out what of this kind was kept for an eye.
    pub fn take<T: 'static>(&mut self, eye: Option<Eye>) -> Option<T> {
        let kept = self.0[eye.map_or(0, |eye| eye as usize)].remove(&TypeId::of::<T>())?;
        kept.downcast().ok().map(|kept| *kept)
    }

    /// Keeps something for the next frame of an eye.
    pub fn keep<T: Send + Sync + 'static>(&mut self, eye: Option<Eye>, next: T) {
        self.0[eye.map_or(0, |eye| eye as usize)].insert(TypeId::of::<T>(), Box::new(next));
    }
}

/// A frame that a machine runs.
#[derive(Clone, Copy)]
pub struct FrameTask<'a> {
    /// Position of the frame in its trace.
    pub frame: usize,
    /// The machine.
    pub machine: &'a Machine,
    /// The frame, prepared for it.
    pub work: &'a dyn Work,
    /// What it takes over from the frame before.
    pub before: Option<&'a Handed>,
    /// Whether the order of lists is checked: that costs about as much as binning the frame, and
    /// changes no time and no energy.
    pub checks_order: bool,
    /// What machines on this frame share.
    pub memo: &'a Memo,
    /// Memory for what is prepared further.
    pub budget: Budget,
    /// Whether the frame is still wanted.
    pub halt: Halt<'a>,
}

impl<'a> FrameTask<'a> {
    /// A frame as if it were the first of its trace.
    pub fn first(machine: &'a Machine, work: &'a dyn Work, memo: &'a Memo) -> FrameTask<'a> {
        let budget = Budget(powergs_base::quantity::Bytes(u64::MAX));
        let (before, halt) = (None, Halt::NEVER);
        FrameTask { frame: 0, machine, work, before, checks_order: false, memo, budget, halt }
    }
}

/// A dataflow of this program, with its stages: their numbers are given before it runs.
#[derive(Clone, Copy)]
pub struct FlowDecl {
    /// The dataflow.
    pub flow: &'static dyn Dataflow,
    /// Its stages, in the order of every report.
    pub stages: &'static [&'static StageDecl],
}

/// The dataflows of this program.
pub const FLOWS: [FlowDecl; 4] = [tile_wise::FLOW, resident::FLOW, gpu::FLOW, recorded::FLOW];

/// Those from outside of the program.
static REGISTERED: Mutex<Vec<&'static dyn Dataflow>> = Mutex::new(Vec::new());

/// Adds a dataflow from outside of the program, with its stages, which must be done before anything
/// else.
///
/// # Errors
/// [`RegisterError`]: too late, or a name that is taken.
pub fn register(flow: &'static dyn Dataflow) -> Result<(), RegisterError> {
    let key = flow.key();
    if all().any(|known| known.key() == key) {
        return Err(RegisterError::Flow(key));
    }
    flow.stages().iter().try_for_each(|stage| stage::register(stage))?;
    REGISTERED.lock().unwrap_or_else(PoisonError::into_inner).push(flow);
    Ok(())
}

/// All dataflows.
pub fn all() -> impl Iterator<Item = &'static dyn Dataflow> {
    let more = REGISTERED.lock().unwrap_or_else(PoisonError::into_inner).clone();
    FLOWS.into_iter().map(|decl| decl.flow).chain(more)
}

/// The dataflow of machine files that name none.
pub const DEFAULT: &str = "tile-wise";

/// The dataflow with a name.
///
/// # Errors
/// There is none: the nearest name, and all of them.
pub fn named(name: &str) -> Result<&'static dyn Dataflow, String> {
    all().find(|flow| flow.key() == name).ok_or_else(|| {
        let names: Vec<&str> = all().map(|flow| flow.key()).collect();
        let near = nearest(name, names.iter().copied());
        let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        format!("no dataflow `{name}`{near}: there are {}", names.join(", "))
    })
}

/// Whether machine files of a dataflow have a key of its own tables: dots between its parts.
pub fn has_key(flow: &dyn Dataflow, key: &str) -> bool {
    let schema = (flow.tables().schema)();
    let mut parts = key.split(['.', '[']);
    parts.try_fold(&schema, |at, part| at["properties"].get(part)).is_some()
}

/// The first dataflow whose machines have a table; `None` for what all have.
pub fn of_table(name: &str) -> Option<&'static dyn Dataflow> {
    static TABLES: Mutex<BTreeMap<&'static str, Vec<String>>> = Mutex::new(BTreeMap::new());
    let mut tables = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
    all().find(|flow| {
        let own = tables.entry(flow.key()).or_insert_with(|| {
            let keys =
                (flow.tables().schema)()["properties"].as_object().cloned().unwrap_or_default();
            keys.into_iter().map(|(key, _)| key).collect()
        });
        own.iter().any(|table| table == name)
    })
}

/// The machine file that shows a dataflow; `None` where none comes with the program.
pub fn example(flow: &dyn Dataflow) -> Option<&'static Embedded> {
    MACHINES.iter().find(|file| Some(file.name) == flow.example())
}

/// How the tables of a dataflow are described and read.
#[derive(Debug, Clone, Copy)]
pub struct TablesDecl {
    /// Their schema: an object.
    pub schema: fn() -> Value,
    /// From a machine file that has been held against the schema.
    pub read: fn(Spanned<DeTable<'_>>) -> Result<Tables, toml::de::Error>,
    /// From plain values.
    pub read_plain: fn(toml::Table) -> Result<Tables, toml::de::Error>,
}

impl TablesDecl {
    /// Of tables that are plain data.
    pub fn of<T: FlowTables + JsonSchema + DeserializeOwned>() -> TablesDecl {
        TablesDecl {
            schema: schema_of::<T>,
            read: |tables| T::deserialize(toml::Deserializer::from(tables)).map(Tables::new),
            read_plain: |tables| T::deserialize(toml::Value::Table(tables)).map(Tables::new),
        }
    }
}

/// The tables of one dataflow.
pub trait FlowTables: Any + fmt::Debug + Send + Sync {
    /// Their dataflow.
    fn flow(&self) -> &'static dyn Dataflow;

    /// The table of this type; `None` where the dataflow has none.
    fn table(&self, of: TypeId) -> Option<&dyn Any>;

    /// As a machine file has them.
    fn to_toml(&self) -> toml::Table;

    /// The same once more.
    fn boxed(&self) -> Box<dyn FlowTables>;

    /// Whether they are the same.
    fn equals(&self, other: &dyn FlowTables) -> bool;
}

/// The tables of the dataflow of a machine.
#[derive(Debug)]
pub struct Tables(Box<dyn FlowTables>);

impl Clone for Tables {
    fn clone(&self) -> Tables {
        Tables(self.0.boxed())
    }
}

impl PartialEq for Tables {
    fn eq(&self, other: &Tables) -> bool {
        self.0.equals(&*other.0)
    }
}

impl Tables {
    /// These tables.
    pub fn new(tables: impl FlowTables) -> Tables {
        Tables(Box::new(tables))
    }

    /// Their dataflow.
    pub fn flow(&self) -> &'static dyn Dataflow {
        self.0.flow()
    }

    /// As a machine file has them.
    pub fn to_toml(&self) -> toml::Table {
        self.0.to_toml()
    }

    /// The table of a type; `None` where the dataflow has none.
    pub fn get<T: 'static>(&self) -> Option<&T> {
        let all: &dyn Any = &*self.0;
        let whole = all.downcast_ref();
        whole.or_else(|| self.0.table(TypeId::of::<T>())?.downcast_ref())
    }

    /// All tables of a dataflow, to be changed; `None` where they are of another.
    pub fn all_mut<T: FlowTables>(&mut self) -> Option<&mut T> {
        let all: &mut dyn Any = &mut *self.0;
        all.downcast_mut()
    }
}

/// What [`FlowTables`] is for a struct of tables, each of a type of its own. A dataflow may lack
/// keys of a table that others have too: these are named last.
#[macro_export]
macro_rules! flow_tables {
    ($tables:ty, $flow:expr, [$($table:ident),* $(,)?]) => {
        $crate::flow::flow_tables!($tables, $flow, [$($table),*], []);
    };
    ($tables:ty, $flow:expr, [$($table:ident),* $(,)?], $lacks:expr) => {
        impl $crate::flow::FlowTables for $tables {
            fn flow(&self) -> &'static dyn $crate::flow::Dataflow {
                &$flow
            }

            fn table(&self, of: std::any::TypeId) -> Option<&dyn std::any::Any> {
                let all: &[&dyn std::any::Any] = &[$(&self.$table),*];
                all.iter().copied().find(|table| (**table).type_id() == of)
            }

            fn to_toml(&self) -> toml::Table {
                let table = toml::Table::try_from(self);
                let table = table.expect("a machine has only tables, numbers and strings");
                let lacks: &[&str] = &$lacks;
                lacks.iter().fold(table, |table, key| $crate::machine::without_key(table, key))
            }

            fn boxed(&self) -> Box<dyn $crate::flow::FlowTables> {
                Box::new(self.clone())
            }

            fn equals(&self, other: &dyn $crate::flow::FlowTables) -> bool {
                let other: &dyn std::any::Any = other;
                other.downcast_ref::<Self>().is_some_and(|other| self == other)
            }
        }
    };
}

pub use flow_tables;
