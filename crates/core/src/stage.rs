//! Stages declare themselves: what one is made of, does, waits for and leaves out is said once,
//! beside its rule.
//!
//! Statistics, the keys of energy tables and their checks, area, peak power, rooflines, what-if,
//! limits, the words of bottlenecks and timelines are read off the declarations. What a program
//! knows of is [`STAGES`], and what was [registered](register) before anybody asked.

mod drawn;
mod stat;

use std::sync::{Mutex, OnceLock, PoisonError};

use crate::flow::FLOWS;
use crate::kernel::stream::{StreamDecl, Streams, same};
use crate::machine::check::Found;
use crate::machine::{DramModel, Exclusion, Machine, Optional};
use powergs_energy::action::{ActionId, BufferId, Memory, Phase, StageId};
use powergs_energy::hardware::{
    BufferFacts, Catalogue, Declared, PartFacts, StageFacts, Unpriced, WorkFacts,
};

pub use crate::kernel::Stall;
pub use powergs_energy::hardware::{Does, Hardware};
pub use stat::{Measured, Merge, StatDecl, StatOf, Value, counted, real, share, timed};

/// A stage: units of a kind, or something that units share.
#[derive(Debug, Clone, Copy)]
pub struct StageDecl {
    /// The key in every file and output: `vru`.
    pub key: &'static str,
    /// What sentences call it: `volume rendering units (VRU)`.
    pub words: &'static str,
    /// What it is and does, for people.
    pub means: &'static str,
    /// The phase that it works in.
    pub phase: Phase,
    /// How many units of it a machine has; `None` for what is no unit.
    pub units: Option<fn(&Machine) -> u32>,
    /// The stage whose cycles its units work in; `None` for those with cycles of their own.
    pub within: Option<&'static str>,
    /// Whether its units compute with `record.numbers`.
    pub has_numbers: bool,
    /// Whether one unit is one lane, which evaluates a pixel a cycle.
    pub has_lanes: bool,
    /// The part of other units that its area and leakage are counted in, where they have no prices
    /// of their own: stage and part.
    pub counted_in: Option<(&'static str, &'static str)>,
    /// What its units do.
    pub works: &'static [WorkDecl],
    /// What its units do that another stage declares.
    pub also_works: &'static [AlsoDecl],
    /// Buffers that it is the first to fill.
    pub buffers: &'static [BufferDecl],
    /// Requests that it makes.
    pub streams: &'static [StreamDecl],
    /// What its units have in amounts that an architect chooses.
    pub parts: &'static [PartDecl],
    /// What is measured of it.
    pub stats: &'static [&'static StatDecl],
    /// What it waits for besides its input, room for its output and banks.
    pub waits: &'static [WaitDecl],
    /// Names of waits of other stages that it may be held up by too.
    pub also_waits: &'static [&'static str],
    /// The stage whose results it works on.
    pub after: Option<&'static str>,
    /// What it gets from that, for sentences: `sorted chunks from the GSU`.
    pub input: &'static str,
    /// What doubling it means.
    pub doubles: &'static [DoubleDecl],
    /// What it leaves out.
    pub omits: &'static [OmitDecl],
    /// Assumptions behind its speed.
    pub behind: &'static [&'static str],
    /// Parts and choices of it that machines may be without.
    pub optional: &'static [Optional],
    /// What its choices exclude.
    pub excludes: &'static [Exclusion],
    /// Adds what else of its keys does not fit together.
    pub check: Option<fn(&Machine, &mut Found)>,
}

impl StageDecl {
    /// A stage that has nothing yet.
    pub const fn new(
        key: &'static str,
        words: &'static str,
        phase: Phase,
        means: &'static str,
    ) -> StageDecl {
        StageDecl {
            key,
            words,
            means,
            phase,
            units: None,
            within: None,
            has_numbers: false,
            has_lanes: false,
            counted_in: None,
            works: &[],
            also_works: &[],
            buffers: &[],
            streams: &[],
            parts: &[],
            stats: &[],
            waits: &[],
            also_waits: &[],
            after: None,
            input: "its input",
            doubles: &[],
            omits: &[],
            behind: &[],
            optional: &[],
            excludes: &[],
            check: None,
        }
    }

    /// How many units of it a machine has.
    pub fn count(&self, machine: &Machine) -> u32 {
        let units = self.units.filter(|_| machine.has_stage(self.key));
        units.map_or(0, |units| units(machine))
    }

    /// What its units may wait for, in report order.
    pub fn stalls(&self) -> impl Iterator<Item = Stall> + '_ {
        Stall::all().iter().copied().filter(|cause| {
            let (WaitDecl { name, .. }, declares) = (cause.words(), cause.stage());
            declares.is_none_or(|stage| stage.key == self.key) || self.also_waits.contains(&name)
        })
    }

    /// What one unit does at most in a cycle: each action with how often. Of work that one unit
    /// does in place of another, both are listed.
    pub fn a_cycle<'m>(
        &'m self,
        machine: &'m Machine,
    ) -> impl Iterator<Item = (&'static str, f64)> + 'm {
        // Of machines that have it: the tables of others say nothing of it.
        let own = self.works.iter().map(|work| (work.facts.key, work.a_cycle));
        let all = own.chain(self.also_works.iter().map(|also| (also.key, also.a_cycle)));
        let all = all.filter(|_| machine.has_stage(self.key));
        all.filter_map(|(key, a_cycle)| Some((key, a_cycle?(machine))))
    }
}

/// Work of the units of a stage.
#[derive(Debug, Clone, Copy)]
pub struct WorkDecl {
    /// Its key, meaning, operations.
    pub facts: WorkFacts,
    /// How often one unit does it in a cycle at most.
    pub a_cycle: Option<fn(&Machine) -> f64>,
    /// Operations of one for rooflines where they are no floating-point operations: comparisons.
    pub comparisons: Option<fn(&Machine) -> u32>,
}

/// Work with a price of its own: key, floating-point operations as PowerGS counts them, meaning.
pub const fn work(key: &'static str, flops: u32, means: &'static str) -> WorkDecl {
    let facts = WorkFacts { key, means, flops, unpriced: Unpriced::Never, is_colour: false };
    WorkDecl { facts, a_cycle: None, comparisons: None }
}

impl WorkDecl {
    /// The same, done so often by one unit in a cycle at most.
    pub const fn a_cycle(self, a_cycle: fn(&Machine) -> f64) -> WorkDecl {
        WorkDecl { a_cycle: Some(a_cycle), ..self }
    }

    /// The same with so many comparisons.
    pub const fn comparing(self, comparisons: fn(&Machine) -> u32) -> WorkDecl {
        WorkDecl { comparisons: Some(comparisons), ..self }
    }

    /// The same with the price of another action where a table has none for it.
    pub const fn priced_as(self, other: &'static str) -> WorkDecl {
        let facts = WorkFacts { unpriced: Unpriced::As(other), ..self.facts };
        WorkDecl { facts, ..self }
    }

    /// The same, made of another action, which a table may price in its place.
    pub const fn made_of(self, other: &'static str) -> WorkDecl {
        let facts = WorkFacts { unpriced: Unpriced::MadeOf(other), ..self.facts };
        WorkDecl { facts, ..self }
    }

    /// The same, as much cheaper as colours of lower SH degree have fewer operations.
    pub const fn of_colour(self) -> WorkDecl {
        WorkDecl { facts: WorkFacts { is_colour: true, ..self.facts }, ..self }
    }
}

/// Work that another stage declares.
#[derive(Debug, Clone, Copy)]
pub struct AlsoDecl {
    /// Its key.
    pub key: &'static str,
    /// How often one unit of this stage does it in a cycle at most; `None` for what it does in
    /// place of other work, in cycles that count for that.
    pub a_cycle: Option<fn(&Machine) -> f64>,
}

/// Work that another stage declares, and this one does in place of other work.
pub const fn also(key: &'static str) -> AlsoDecl {
    AlsoDecl { key, a_cycle: None }
}

impl AlsoDecl {
    /// The same, done so often by one unit in a cycle at most.
    pub const fn a_cycle(self, a_cycle: fn(&Machine) -> f64) -> AlsoDecl {
        AlsoDecl { a_cycle: Some(a_cycle), ..self }
    }
}

/// A buffer.
#[derive(Debug, Clone, Copy)]
pub struct BufferDecl {
    /// Its name, and where a machine file has it.
    pub facts: BufferFacts,
    /// How a machine builds it; no banks where the machine has no such buffer.
    pub memory: fn(&Machine) -> Memory,
}

/// A buffer that fills and empties: name in outputs, table in a machine file.
pub const fn buffer(
    name: &'static str,
    table: &'static str,
    memory: fn(&Machine) -> Memory,
) -> BufferDecl {
    let facts = BufferFacts { name, fills: true, grows: false, table, size: "capacity" };
    BufferDecl { facts, memory }
}

impl BufferDecl {
    /// The same as a table, which is always full.
    pub const fn full(self) -> BufferDecl {
        BufferDecl { facts: BufferFacts { fills: false, ..self.facts }, ..self }
    }

    /// The same, whose size is another key.
    pub const fn sized_by(self, size: &'static str) -> BufferDecl {
        BufferDecl { facts: BufferFacts { size, ..self.facts }, ..self }
    }

    /// The same, which the parts of its stage make larger.
    pub const fn growing(self) -> BufferDecl {
        BufferDecl { facts: BufferFacts { grows: true, ..self.facts }, ..self }
    }
}

/// Something that one unit has in an amount that an architect chooses.
#[derive(Debug, Clone, Copy)]
pub struct PartDecl {
    /// Its key and meaning.
    pub facts: PartFacts,
    /// How much of it one unit has.
    pub amount: fn(&Machine) -> f64,
}

/// A part: key in `[parts.STAGE]`, what its amount counts, the amount.
pub const fn part(key: &'static str, means: &'static str, amount: fn(&Machine) -> f64) -> PartDecl {
    PartDecl { facts: PartFacts { key, means, may_lack: false }, amount }
}

impl PartDecl {
    /// The same, which units may be without.
    pub const fn may_lack(self) -> PartDecl {
        PartDecl { facts: PartFacts { may_lack: true, ..self.facts }, ..self }
    }
}

/// Who brings what a unit waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum From {
    /// The memory.
    Memory,
    /// A stage of the machine, by its key.
    Stage(&'static str),
    /// Whatever is before it, or behind it.
    Neighbour,
}

/// Something that a unit waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WaitDecl {
    /// The name in every output.
    pub name: &'static str,
    /// What is waited for, in sentences: `records of Gaussians`.
    pub what: &'static str,
    /// The same in legends: `records from DRAM`.
    pub short: &'static str,
    /// Why, after `because`: `records of Gaussians were in DRAM or on their way`.
    pub because: &'static str,
    /// One character in drawings of few cycles.
    pub symbol: char,
    /// Who brings it.
    pub from: From,
}

/// What twice as much of a resource means.
#[derive(Debug, Clone, Copy)]
pub struct DoubleDecl {
    /// What it is called, in the words of the machine file: its first key, or that and what comes
    /// with it.
    pub name: &'static str,
    /// The keys that are doubled together.
    pub keys: &'static [&'static str],
    /// The assumptions that decide how fast it is.
    pub assumptions: &'static [&'static str],
    /// Whether a machine has it.
    pub is_there: fn(&Machine) -> bool,
}

/// A resource that every machine with the stage has.
pub const fn double(
    name: &'static str,
    keys: &'static [&'static str],
    assumptions: &'static [&'static str],
) -> DoubleDecl {
    DoubleDecl { name, keys, assumptions, is_there: |_| true }
}

/// What an effect that is left out does to the frame time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bias {
    /// Real frames take longer than simulated ones.
    Optimistic,
    /// Real frames take less time than simulated ones.
    Pessimistic,
    /// Depends on the scene or the design.
    Either,
}

impl Bias {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Bias::Optimistic => "optimistic",
            Bias::Pessimistic => "pessimistic",
            Bias::Either => "either",
        }
    }
}

/// An effect that is left out.
#[derive(Debug, Clone, Copy)]
pub struct OmitDecl {
    /// What is left out.
    pub what: &'static str,
    /// Which way the frame time is wrong for it.
    pub bias: Bias,
    /// The assumption that says more; empty where none does.
    pub assumption: &'static str,
    /// The key and value with which a machine leaves it out; empty where all do.
    pub with: &'static str,
    /// Whether a machine leaves it out.
    pub by: fn(&Machine) -> bool,
}

/// An effect that every machine leaves out.
pub const fn omit(what: &'static str, bias: Bias, assumption: &'static str) -> OmitDecl {
    OmitDecl { what, bias, assumption, with: "", by: |_| true }
}

impl OmitDecl {
    /// The same, left out by machines with this key and value only.
    pub const fn by(self, with: &'static str, by: fn(&Machine) -> bool) -> OmitDecl {
        OmitDecl { with, by, ..self }
    }
}

/// The stages of this program, each once, dataflow by dataflow, in the order of every report.
pub const STAGES: [&StageDecl; distinct()] = {
    let mut all = [FLOWS[0].stages[0]; distinct()];
    let (mut n, mut flow) = (0, 0);
    while flow < FLOWS.len() {
        let mut at = 0;
        while at < FLOWS[flow].stages.len() {
            if is_first(flow, at) {
                all[n] = FLOWS[flow].stages[at];
                n += 1;
            }
            at += 1;
        }
        flow += 1;
    }
    all
};

/// How many stages there are, those once that several dataflows have.
const fn distinct() -> usize {
    let (mut n, mut flow) = (0, 0);
    while flow < FLOWS.len() {
        let mut at = 0;
        while at < FLOWS[flow].stages.len() {
            n += is_first(flow, at) as usize;
            at += 1;
        }
        flow += 1;
    }
    n
}

/// Whether no earlier dataflow has a stage.
const fn is_first(flow: usize, at: usize) -> bool {
    let (key, mut other) = (FLOWS[flow].stages[at].key, 0);
    while other < flow {
        let mut i = 0;
        while i < FLOWS[other].stages.len() {
            if same(FLOWS[other].stages[i].key, key) {
                return false;
            }
            i += 1;
        }
        other += 1;
    }
    true
}

/// The streams of some stages.
///
/// # Panics
/// When there are more than [`Streams::MOST`], or one is like one that does not exist.
pub const fn streams(stages: &[&StageDecl]) -> Streams {
    let (mut streams, mut s) = (Streams::NONE, 0);
    while s < stages.len() {
        streams = streams.with(stages[s].phase, stages[s].streams);
        s += 1;
    }
    streams.checked()
}

/// Works, units, buffers of [`STAGES`] in front of what `stage` (or all, behind the last) has.
const fn before(stage: usize) -> [usize; 3] {
    let mut sum = [0; 3];
    let mut s = 0;
    while s < stage {
        sum[0] += STAGES[s].works.len();
        sum[1] += STAGES[s].units.is_some() as usize;
        sum[2] += STAGES[s].buffers.len();
        s += 1;
    }
    sum
}

/// Numbers in all.
const ALL: [usize; 3] = before(STAGES.len());

/// The number of a stage of this program.
pub const fn stage_id(key: &str) -> StageId {
    let mut s = 0;
    while s < STAGES.len() {
        if same(STAGES[s].key, key) {
            return StageId::new(s);
        }
        s += 1;
    }
    panic!("no stage of this program has this key");
}

/// The number of work that a stage of this program declares.
pub const fn work_id(key: &str) -> ActionId {
    let mut s = 0;
    while s < STAGES.len() {
        let mut i = 0;
        while i < STAGES[s].works.len() {
            if same(STAGES[s].works[i].facts.key, key) {
                return ActionId::new(before(s)[0] + i);
            }
            i += 1;
        }
        s += 1;
    }
    panic!("no stage of this program declares this work");
}

/// The number of a buffer that a stage of this program declares.
pub const fn buffer_id(name: &str) -> BufferId {
    let mut s = 0;
    while s < STAGES.len() {
        let mut i = 0;
        while i < STAGES[s].buffers.len() {
            if same(STAGES[s].buffers[i].facts.name, name) {
                return BufferId::new(before(s)[2] + i);
            }
            i += 1;
        }
        s += 1;
    }
    panic!("no stage of this program declares this buffer");
}

/// A cycle of a unit of a stage of this program that has work, or waits with it; or one without.
pub const fn clock(stage: StageId, idle: bool) -> ActionId {
    let unit = before(stage.index())[1];
    ActionId::new(ALL[0] + if idle { ALL[1] } else { 0 } + unit)
}

/// A byte read from DRAM.
pub const DRAM_READ: ActionId = ActionId::new(ALL[0] + 2 * ALL[1]);

/// A byte written to DRAM.
pub const DRAM_WRITE: ActionId = ActionId::new(ALL[0] + 2 * ALL[1] + 1);

/// A byte read from a buffer of this program.
pub const fn sram_read(buffer: BufferId) -> ActionId {
    ActionId::new(ALL[0] + 2 * ALL[1] + 2 + buffer.index())
}

/// A byte written to a buffer of this program.
pub const fn sram_write(buffer: BufferId) -> ActionId {
    ActionId::new(ALL[0] + 2 * ALL[1] + 2 + ALL[2] + buffer.index())
}

impl Stall {
    /// Causes that every unit may have.
    const COMMON_WORDS: [WaitDecl; Stall::COMMON] = [
        WaitDecl {
            name: "input",
            what: "its input",
            short: "unit before it",
            because: "the unit before had not finished",
            symbol: 'i',
            from: From::Neighbour,
        },
        WaitDecl {
            name: "output",
            what: "room in the output buffer",
            short: "room behind it",
            because: "the buffer behind them was full",
            symbol: 'o',
            from: From::Neighbour,
        },
        WaitDecl {
            name: "bank",
            what: "busy banks",
            short: "buffer bank",
            because: "banks of their buffers were taken by other accesses",
            symbol: 'b',
            from: From::Neighbour,
        },
    ];

    /// A wait that a stage of this program declares.
    pub const fn of(name: &str) -> Stall {
        let (mut s, mut at) = (0, Stall::COMMON);
        while s < STAGES.len() {
            let mut i = 0;
            while i < STAGES[s].waits.len() {
                if same(STAGES[s].waits[i].name, name) {
                    return Stall::at(at + i);
                }
                i += 1;
            }
            at += STAGES[s].waits.len();
            s += 1;
        }
        panic!("no stage of this program declares this wait");
    }

    /// All causes, in report order: those that every unit may have last.
    pub fn all() -> &'static [Stall] {
        &registry().stalls
    }

    /// What is said of it.
    pub fn words(self) -> WaitDecl {
        registry().waits[self.index()]
    }

    /// The name in every output.
    pub fn name(self) -> &'static str {
        self.words().name
    }

    /// Whether the unit waits for the memory.
    pub fn is_dram(self) -> bool {
        self.words().from == From::Memory
    }

    /// The stage that declares it; `None` for what every unit may have.
    pub fn stage(self) -> Option<&'static StageDecl> {
        let declared = self.index().checked_sub(Stall::COMMON)?;
        Some(registry().waiting[declared])
    }
}

/// What the program knows of.
struct Registry {
    stages: Vec<&'static StageDecl>,
    hardware: Hardware,
    /// By [`Stall::index`].
    waits: Vec<WaitDecl>,
    /// The stages that declare those behind the common ones.
    waiting: Vec<&'static StageDecl>,
    /// In report order.
    stalls: Vec<Stall>,
}

/// What was registered and is not yet known of.
static REGISTERED: Mutex<Vec<&'static StageDecl>> = Mutex::new(Vec::new());

static REGISTRY: OnceLock<Registry> = OnceLock::new();

/// Why a stage cannot be registered.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RegisterError {
    /// Somebody has asked already.
    #[error(
        "the stage `{0}` comes too late: register stages before anything reads a file or asks for \
         a statistic"
    )]
    Late(&'static str),
    /// Something of it has a name that is taken.
    #[error("`{name}` of the stage `{stage}` is declared already: give it another name")]
    Taken {
        /// Key of the stage.
        stage: &'static str,
        /// What is taken.
        name: &'static str,
    },
    /// A dataflow with a name that another one has.
    #[error("there is a dataflow `{0}` already: give yours another name")]
    Flow(&'static str),
    /// A timing rule with a name that another one of its unit has.
    #[error("there is a rule `{name}` of the unit `{unit}` already: give yours another name")]
    Rule {
        /// Key of the unit.
        unit: &'static str,
        /// Name of the rule.
        name: String,
    },
    /// More causes of waits than accounts have room for.
    #[error("the stage `{0}` has too many causes to wait: all stages together have at most 13")]
    Waits(&'static str),
}

/// Adds a stage from outside of the program, which must be done before anything else.
///
/// # Errors
/// [`RegisterError`]: too late, or a name that is taken.
pub fn register(stage: &'static StageDecl) -> Result<(), RegisterError> {
    let mut more = REGISTERED.lock().unwrap_or_else(PoisonError::into_inner);
    if REGISTRY.get().is_some() {
        return Err(RegisterError::Late(stage.key));
    }
    let known: Vec<&StageDecl> = STAGES.into_iter().chain(more.iter().copied()).collect();
    let names = |stage: &'static StageDecl| {
        let works = stage.works.iter().map(|work| work.facts.key);
        let buffers = stage.buffers.iter().map(|buffer| buffer.facts.name);
        let waits = stage.waits.iter().map(|wait| wait.name);
        [stage.key].into_iter().chain(works).chain(buffers).chain(waits)
    };
    let taken = |name: &&str| {
        known.iter().any(|other| names(other).any(|theirs| theirs == *name))
            || Stall::COMMON_WORDS.iter().any(|wait| wait.name == *name)
    };
    if let Some(name) = names(stage).find(taken) {
        return Err(RegisterError::Taken { stage: stage.key, name });
    }
    let waits = known.iter().map(|stage| stage.waits.len()).sum::<usize>() + stage.waits.len();
    if Stall::COMMON + waits > Stall::MOST {
        return Err(RegisterError::Waits(stage.key));
    }
    more.push(stage);
    Ok(())
}

fn registry() -> &'static Registry {
    REGISTRY.get_or_init(|| {
        let more = REGISTERED.lock().unwrap_or_else(PoisonError::into_inner);
        let stages: Vec<&'static StageDecl> =
            STAGES.into_iter().chain(more.iter().copied()).collect();
        let declared: Vec<Declared> = stages.iter().map(|stage| declared(stage)).collect();
        let (own, others) = declared.split_at(STAGES.len());
        let common = Stall::COMMON;
        let own_waits = || stages.iter().flat_map(|s| s.waits.iter().map(move |wait| (*s, *wait)));
        let waits: Vec<WaitDecl> =
            Stall::COMMON_WORDS.into_iter().chain(own_waits().map(|(_, wait)| wait)).collect();
        let order = (common..waits.len()).chain(0..common);
        Registry {
            hardware: Hardware::new(own, others),
            waiting: own_waits().map(|(stage, _)| stage).collect(),
            stalls: order.map(Stall::at).collect(),
            waits,
            stages,
        }
    })
}

fn declared(stage: &StageDecl) -> Declared {
    Declared {
        stage: StageFacts {
            key: stage.key,
            words: stage.words,
            phase: stage.phase,
            is_units: stage.units.is_some(),
            has_numbers: stage.has_numbers,
            counted_in: stage.counted_in,
        },
        works: stage.works.iter().map(|work| work.facts).collect(),
        also_works: stage.also_works.iter().map(|also| also.key).collect(),
        buffers: stage.buffers.iter().map(|buffer| buffer.facts).collect(),
        parts: stage.parts.iter().map(|part| part.facts).collect(),
    }
}

/// All stages that machines may have, by [`StageId`].
pub fn stages() -> &'static [&'static StageDecl] {
    &registry().stages
}

/// A stage.
pub fn stage(id: StageId) -> &'static StageDecl {
    stages()[id.index()]
}

/// Everything that is known to be left out: by memories, by stages, by all machines.
pub fn omissions() -> impl Iterator<Item = &'static OmitDecl> {
    let of_stages = stages().iter().flat_map(|stage| stage.omits);
    MEMORY_OMITS.iter().chain(of_stages).chain(&OMITS)
}

/// What memories leave out.
const MEMORY_OMITS: [OmitDecl; 4] = [
    omit("bursts, rows, banks, refresh and turnaround of the DRAM", Bias::Either, "A4")
        .by("dram.model = \"bandwidth\"", |m| m.dram.model == DramModel::Bandwidth),
    omit("address translation and interconnect of the DRAM", Bias::Optimistic, ""),
    omit("other users of the DRAM: GPU, display, camera", Bias::Optimistic, "A18")
        .by("dram.second-master.rate = \"0 B/s\"", |m| m.dram.is_alone()),
    omit("reads of one unit served before older ones of another", Bias::Either, "A33"),
];

/// What twice the memory is.
const MEMORY_DOUBLES: [DoubleDecl; 3] = [
    DoubleDecl {
        is_there: |m| !m.dram.has_device() && m.dram.bandwidth.is_some(),
        ..double("dram.bandwidth", &["dram.bandwidth"], &["A4", "A5"])
    },
    DoubleDecl {
        is_there: |m| m.dram.has_device() && m.dram.model == DramModel::Bandwidth,
        ..double("dram.channels", &["dram.channels"], &["A4", "A5"])
    },
    DoubleDecl {
        is_there: |m| m.dram.has_device() && m.dram.model != DramModel::Bandwidth,
        ..double("dram.channels", &["dram.channels"], &["A41"])
    },
];

/// What no machine has.
const OMITS: [OmitDecl; 2] = [
    omit("frame set-up: camera, command lists, the processor", Bias::Optimistic, ""),
    omit(
        "changes of clock and voltage in a frame, temperature, wake-up times",
        Bias::Optimistic,
        "",
    ),
];

/// What a machine leaves out.
pub fn left_out(machine: &Machine) -> impl Iterator<Item = &'static OmitDecl> {
    let of_stages = machine.flow().stages().iter().flat_map(|stage| stage.omits);
    let all = MEMORY_OMITS.iter().chain(of_stages).chain(&OMITS);
    all.filter(|omit| (omit.by)(machine))
}

/// What may be doubled in a machine: parts of the memory, then what its stages declare.
pub fn doubles(machine: &Machine) -> impl Iterator<Item = &'static DoubleDecl> {
    let is_there = |stage: &&&StageDecl| stage.units.is_none_or(|units| units(machine) > 0);
    let stages = machine.flow().stages().iter().filter(is_there);
    let of_stages = stages.flat_map(|stage| stage.doubles);
    MEMORY_DOUBLES.iter().chain(of_stages).filter(|double| (double.is_there)(machine))
}

/// Everything that machines may be built of.
pub fn hardware() -> &'static Hardware {
    &registry().hardware
}

/// The declarations of this program, for types that have no other way to them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stages;

impl Catalogue for Stages {
    fn hardware() -> &'static Hardware {
        hardware()
    }
}

/// Prices of what the stages of this program do.
pub type EnergyTable = powergs_energy::EnergyTable<Stages>;
