//! What the machines of a program are built of: the declarations of all stages, each thing with its
//! number.
//!
//! A number is the place of a thing in one list for all machines, so that counts, prices and areas
//! are plain vectors. Sums run in the order of the numbers: work of all stages, cycles with and
//! without work, DRAM, buffers; what is declared outside of the program follows stage by stage.

use std::fmt;

use crate::Component;
use crate::action::{ActionId, BufferId, PartId, Phase, StageId};

/// A stage as energy and area see it: units of a kind, or something that units share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StageFacts {
    /// The key in every file and output: `vru`.
    pub key: &'static str,
    /// What sentences call it: `volume rendering units (VRU)`.
    pub words: &'static str,
    /// The phase that it works in.
    pub phase: Phase,
    /// Whether it is units of a kind, which have a clock, leak and take area.
    pub is_units: bool,
    /// Whether its units compute with `record.numbers`.
    pub has_numbers: bool,
    /// The stage and the part of it that its area and leakage are counted in, for as much as its
    /// own first part says; `None` where they have prices of their own.
    pub counted_in: Option<(&'static str, &'static str)>,
}

/// What an action costs in a table that has no price of its own for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unpriced {
    /// The table cannot price machines that do it.
    Never,
    /// As much as another action.
    As(&'static str),
    /// Nothing: it is made of another action, which has the price. Where it has one itself, all
    /// that are made of that action have, and that one is free.
    MadeOf(&'static str),
}

/// Work of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WorkFacts {
    /// The key in energy tables and, with `_`, in outputs: `alpha`.
    pub key: &'static str,
    /// What is counted, for people.
    pub means: &'static str,
    /// Floating-point operations as PowerGS counts them (`powergs`); of a colour, at degree 3.
    pub flops: u32,
    /// What it costs without a price of its own.
    pub unpriced: Unpriced,
    /// Whether it takes as much less as a colour of a lower SH degree has fewer operations.
    pub is_colour: bool,
}

/// A buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferFacts {
    /// The name in every output (snake_case).
    pub name: &'static str,
    /// Whether it fills and empties: the others are tables, which are always full.
    pub fills: bool,
    /// Whether the parts of its stage make it larger.
    pub grows: bool,
    /// The table of a machine file that has its capacity, banks and word.
    pub table: &'static str,
    /// The key of its size in that table.
    pub size: &'static str,
}

/// Something that one unit of a stage has in an amount that an architect chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartFacts {
    /// The key in `[parts.STAGE]` of energy tables.
    pub key: &'static str,
    /// What its amount counts.
    pub means: &'static str,
    /// Whether units may be without it: nothing said of it is an amount of 0.
    pub may_lack: bool,
}

/// Everything that a stage declares of this.
#[derive(Debug, Clone)]
pub struct Declared {
    /// The stage.
    pub stage: StageFacts,
    /// Its work.
    pub works: Vec<WorkFacts>,
    /// Keys of work that it does and another stage declares.
    pub also_works: Vec<&'static str>,
    /// Its buffers.
    pub buffers: Vec<BufferFacts>,
    /// Its parts.
    pub parts: Vec<PartFacts>,
}

/// What an action is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Does {
    /// Work of a unit.
    Work(StageId, WorkFacts),
    /// A cycle of a unit that has work, or waits with it.
    Clock(StageId),
    /// A cycle of a unit without work.
    IdleClock(StageId),
    /// A byte read from a buffer.
    SramRead(BufferId),
    /// A byte written to a buffer.
    SramWrite(BufferId),
    /// A byte read from DRAM.
    DramRead,
    /// A byte written to DRAM.
    DramWrite,
}

impl Does {
    /// The component that spends its energy.
    pub const fn component(self) -> Component {
        match self {
            Does::DramRead | Does::DramWrite => Component::Dram,
            Does::SramRead(_) | Does::SramWrite(_) => Component::Sram,
            Does::Work(..) | Does::Clock(_) | Does::IdleClock(_) => Component::Flop,
        }
    }

    /// The units that do it.
    pub const fn stage(self) -> Option<StageId> {
        match self {
            Does::Work(stage, _) | Does::Clock(stage) | Does::IdleClock(stage) => Some(stage),
            Does::SramRead(_) | Does::SramWrite(_) | Does::DramRead | Does::DramWrite => None,
        }
    }
}

/// Everything that the machines of a program may be built of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hardware {
    stages: Vec<StageFacts>,
    buffers: Vec<(StageId, BufferFacts)>,
    parts: Vec<(StageId, PartFacts)>,
    also_works: Vec<(StageId, &'static str)>,
    actions: Vec<Does>,
}

/// The declarations of a program, for types that have no other way to them.
pub trait Catalogue: fmt::Debug + Clone + PartialEq + Send + Sync + 'static {
    /// All of them, always the same.
    fn hardware() -> &'static Hardware;
}

impl Hardware {
    /// The stages of the program, and those declared from outside of it.
    pub fn new(own: &[Declared], others: &[Declared]) -> Hardware {
        let mut all = Hardware {
            stages: Vec::new(),
            buffers: Vec::new(),
            parts: Vec::new(),
            also_works: Vec::new(),
            actions: Vec::new(),
        };
        all.add(own, true);
        others.iter().for_each(|one| all.add(std::slice::from_ref(one), false));
        all
    }

    fn add(&mut self, more: &[Declared], has_dram: bool) {
        let first = self.stages.len();
        let id = |k: usize| StageId::new(first + k);
        let old_buffers = self.buffers.len();
        for (k, one) in more.iter().enumerate() {
            self.stages.push(one.stage);
            self.buffers.extend(one.buffers.iter().map(|buffer| (id(k), *buffer)));
            self.parts.extend(one.parts.iter().map(|part| (id(k), *part)));
            self.also_works.extend(one.also_works.iter().map(|key| (id(k), *key)));
        }
        let each = || more.iter().enumerate().map(|(k, one)| (id(k), one));
        let units = || each().filter(|(_, one)| one.stage.is_units).map(|(id, _)| id);
        let buffers = old_buffers..self.buffers.len();
        let buffers = || buffers.clone().map(BufferId::new);
        let works = each().flat_map(|(id, one)| one.works.iter().map(move |w| Does::Work(id, *w)));
        self.actions.extend(works);
        self.actions.extend(units().map(Does::Clock));
        self.actions.extend(units().map(Does::IdleClock));
        if has_dram {
            self.actions.extend([Does::DramRead, Does::DramWrite]);
        }
        self.actions.extend(buffers().map(Does::SramRead));
        self.actions.extend(buffers().map(Does::SramWrite));
    }

    /// All actions, in the order of their numbers.
    pub fn actions(&self) -> impl Iterator<Item = (ActionId, Does)> {
        self.actions.iter().enumerate().map(|(i, does)| (ActionId::new(i), *does))
    }

    /// What an action is.
    pub fn does(&self, action: ActionId) -> Does {
        self.actions[action.index()]
    }

    /// The number of an action.
    pub fn action(&self, wanted: impl Fn(Does) -> bool) -> Option<ActionId> {
        self.actions().find(|(_, does)| wanted(*does)).map(|(id, _)| id)
    }

    /// The stages whose units do some work: the one that declares it, then the others.
    pub fn doers(&self, declares: StageId, key: &str) -> impl Iterator<Item = StageId> {
        let others = self.also_works.iter().filter(move |(_, also)| *also == key);
        std::iter::once(declares).chain(others.map(|(stage, _)| *stage))
    }

    /// The action with a key, as [`Hardware::key`] writes it.
    pub fn action_called(&self, key: &str) -> Option<ActionId> {
        self.actions().map(|(id, _)| id).find(|id| self.key(*id) == key)
    }

    /// The key of an action in energy tables (kebab-case) and, with `_`, in outputs: `alpha`,
    /// `sram-read.feature`.
    pub fn key(&self, action: ActionId) -> String {
        let buffer = |buffer| self.buffer(buffer).key();
        match self.does(action) {
            Does::Work(_, work) => work.key.to_owned(),
            Does::Clock(stage) => format!("clock.{}", self.stage(stage).key),
            Does::IdleClock(stage) => format!("idle-clock.{}", self.stage(stage).key),
            Does::DramRead => "dram-read".to_owned(),
            Does::DramWrite => "dram-write".to_owned(),
            Does::SramRead(b) => format!("sram-read.{}", buffer(b)),
            Does::SramWrite(b) => format!("sram-write.{}", buffer(b)),
        }
    }

    /// All stages.
    pub fn stages(&self) -> impl Iterator<Item = (StageId, &StageFacts)> {
        self.stages.iter().enumerate().map(|(i, stage)| (StageId::new(i), stage))
    }

    /// A stage.
    pub fn stage(&self, stage: StageId) -> &StageFacts {
        &self.stages[stage.index()]
    }

    /// The stage with a key.
    pub fn stage_called(&self, key: &str) -> Option<StageId> {
        self.stages().find(|(_, stage)| stage.key == key).map(|(id, _)| id)
    }

    /// Units of all kinds, in the order of their numbers.
    pub fn units(&self) -> impl Iterator<Item = (StageId, &StageFacts)> {
        self.stages().filter(|(_, stage)| stage.is_units)
    }

    /// All buffers.
    pub fn buffers(&self) -> impl Iterator<Item = (BufferId, &BufferFacts)> {
        self.buffers.iter().enumerate().map(|(i, (_, buffer))| (BufferId::new(i), buffer))
    }

    /// A buffer.
    pub fn buffer(&self, buffer: BufferId) -> &BufferFacts {
        &self.buffers[buffer.index()].1
    }

    /// The stage of a buffer.
    pub fn stage_of(&self, buffer: BufferId) -> StageId {
        self.buffers[buffer.index()].0
    }

    /// The buffer with a key.
    pub fn buffer_called(&self, key: &str) -> Option<BufferId> {
        self.buffers().find(|(_, buffer)| buffer.key() == key).map(|(id, _)| id)
    }

    /// All parts, with their stages.
    pub fn parts(&self) -> impl Iterator<Item = (PartId, StageId, &PartFacts)> {
        self.parts.iter().enumerate().map(|(i, (stage, part))| (PartId::new(i), *stage, part))
    }

    /// The part of a stage with a key.
    pub fn part_called(&self, stage: &str, key: &str) -> Option<PartId> {
        let is_it = |at: StageId, part: &PartFacts| self.stage(at).key == stage && part.key == key;
        self.parts().find(|(_, at, part)| is_it(*at, part)).map(|(id, ..)| id)
    }
}

impl BufferFacts {
    /// Its key in files (kebab-case).
    pub fn key(&self) -> String {
        self.name.replace('_', "-")
    }
}
