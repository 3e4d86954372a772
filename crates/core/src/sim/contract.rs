//! The laws that every dataflow keeps, as one function for the tests of a new one.
//!
//! ```no_run
//! use powergs_core::sim::contract::{Trial, broken};
//! # use powergs_frame::trace::Frame;
//! # fn frames() -> Vec<Frame> { Vec::new() }
//!
//! let text = std::fs::read_to_string("machines/mine.toml").expect("the machine");
//! let trial = Trial {
//!     machine: &text,
//!     files: &[],
//!     variants: &[&[], &["dram.model=bandwidth"], &["lanes.units=4"]],
//!     frames: &frames(),
//!     settled: &["lanes.speculation=0"],
//!     slack: 0.02,
//!     idle_keys: &[],
//! };
//! assert_eq!(broken(&trial), Vec::<String>::new());
//! ```

use std::io::{self, Read};

use rayon::prelude::*;
use toml::{Table, Value};

use super::{Timed, cost, time};
use crate::flow::{FrameTask, Handed, History, Work};
use crate::kernel::Memo;
use crate::kernel::timeline::{Observer, Span, Timeline};
use crate::machine::Machine;
use crate::stage::{EnergyTable, StatDecl, StatOf, doubles, hardware};
use powergs_base::config::embedded::{ENERGY, find};
use powergs_base::config::{key_docs_of, knob};
use powergs_energy::Prices;
use powergs_energy::hardware::Does;
use powergs_frame::trace::Frame;

/// What a dataflow is tried on.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// A machine file of it.
    pub machine: &'a str,
    /// Files that it names, with what is in them.
    pub files: &'a [(&'a str, &'a [u8])],
    /// Settings beyond it: each list is a machine. Between them they should reach everything that
    /// the dataflow can do.
    pub variants: &'a [&'a [&'a str]],
    /// Frames, as a trace has them one after the other.
    pub frames: &'a [Frame],
    /// Settings under which what is done does not depend on when: without speculation.
    pub settled: &'a [&'a str],
    /// How much longer a frame may take with twice of something, as a share: hand-outs in another
    /// order and requests in each other's way cost a little.
    pub slack: f64,
    /// Keys that move nothing on any of these machines, and why that is right stands where they
    /// are declared.
    pub idle_keys: &'a [&'a str],
}

/// What is wrong; empty where every law is kept:
///
/// - accounts close: each cycle of each unit is in one state, what an observer sees is what the
///   accounts say, bytes that are asked for are served, what enters a buffer leaves it;
/// - the same frame on the same machine is the same again, alone and behind any other of the
///   machines in one memo;
/// - what is done does not depend on when: not on the latency and the rate of the memory;
/// - twice of a resource does not slow a frame by more than `slack`, on the flat memory;
/// - what is measured of a frame is declared by a stage;
/// - every key of its tables moves a time, a count or a price on one of the machines.
///
/// # Panics
/// When a machine of the trial is refused, or cannot run one of the frames.
pub fn broken(trial: &Trial<'_>) -> Vec<String> {
    let machines: Vec<Machine> =
        trial.variants.iter().map(|sets| machine(trial, sets).expect("a machine")).collect();
    let mut found = same_again(trial, &machines);
    found.extend(machines.par_iter().flat_map_iter(|m| watched(trial, m)).collect::<Vec<_>>());
    found.extend(settled(trial));
    found.extend(machines.par_iter().flat_map_iter(|m| doubled(trial, m)).collect::<Vec<_>>());
    found.extend(dead_keys(trial, &machines));
    found
}

fn machine(trial: &Trial<'_>, sets: &[&str]) -> Result<Machine, String> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let mut machine = Machine::parse_with(trial.machine, &sets).map_err(|e| e.to_string())?;
    let open = |name: &str| -> Result<Box<dyn Read>, String> {
        let file = trial.files.iter().find(|(known, _)| *known == name);
        let (_, bytes) = file.ok_or_else(|| format!("the trial has no file {name}"))?;
        Ok(Box::new(io::Cursor::new(bytes.to_vec())))
    };
    machine.flow().attach(&mut machine, &mut { open })?;
    Ok(machine)
}

/// A machine as a table has it, as a variant of another one.
fn variant(table: &Table, of: &Machine) -> Option<Machine> {
    let mut machine = Machine::parse(&table.to_string()).ok()?;
    machine.keep(of).ok()?;
    Some(machine)
}

/// Takes all frames through a machine, with a memo for each.
fn all_frames(machine: &Machine, frames: &[Frame], memos: &[Memo]) -> Vec<Result<Timed, String>> {
    each_frame(machine, frames, memos, |task| time(task).map_err(|e| e.to_string()))
}

fn each_frame<T>(
    machine: &Machine,
    frames: &[Frame],
    memos: &[Memo],
    run: impl Fn(&FrameTask<'_>) -> T,
) -> Vec<T> {
    let (flow, key) = (machine.flow(), machine.flow().work_key(machine));
    let mut history = History::default();
    let one = |(frame, (facts, memo)): (usize, (&Frame, &Memo))| {
        let work: Box<dyn Work> = key.prepare(facts);
        let before: Option<Handed> = flow.hand_over(machine, &*work, None, &mut history);
        let first = FrameTask::first(machine, &*work, memo);
        run(&FrameTask { frame, before: before.as_ref(), ..first })
    };
    (0..).zip(frames.iter().zip(memos)).map(one).collect()
}

fn memos(frames: &[Frame]) -> Vec<Memo> {
    frames.iter().map(|_| Memo::default()).collect()
}

/// The same again, and behind each other machine.
fn same_again(trial: &Trial<'_>, machines: &[Machine]) -> Vec<String> {
    let alone = |machine| all_frames(machine, trial.frames, &memos(trial.frames));
    let first: Vec<_> = machines.par_iter().map(alone).collect();
    let again: Vec<_> = machines.par_iter().map(alone).collect();
    let shared = memos(trial.frames);
    let mut found = Vec::new();
    for (sets, (machine, (first, again))) in
        trial.variants.iter().zip(machines.iter().zip(first.iter().zip(&again)))
    {
        for timed in first {
            if let Err(refused) = timed {
                panic!("{sets:?}: {refused}");
            }
        }
        if first != again {
            found.push(format!("{sets:?}: the same frames again have other results"));
        }
        if *first != all_frames(machine, trial.frames, &shared) {
            found.push(format!("{sets:?}: other results behind other machines in one memo"));
        }
    }
    found
}

/// What an observer sees is what the accounts say.
fn watched(trial: &Trial<'_>, machine: &Machine) -> Vec<String> {
    let run = |task: &FrameTask<'_>| {
        let alone = machine.flow().run(task, None).expect("it ran");
        let mut seen = Timeline::default();
        let observer: &mut dyn Observer = &mut seen;
        let watched = machine.flow().run(task, Some(observer)).expect("it ran");
        let spans = |span: &Span| span.to - span.from;
        let cycles: u64 = seen.spans.iter().map(spans).sum();
        let timing = &alone.timing;
        // Units of a gang have one row.
        let most: u64 = timing.units.iter().map(|u| timing.frame * u64::from(u.instances)).sum();
        let end = seen.spans.iter().map(|span| span.to).max().unwrap_or(0);
        let mut found = Vec::new();
        if watched.timing != alone.timing || watched.actions != alone.actions {
            found.push(format!("{}: who watches changes it", machine.name));
        }
        for (stat, _) in alone.measured.all().filter(|(stat, _)| !is_declared(machine, stat)) {
            found.push(format!("{}: no stage declares `{}`", machine.name, stat.name));
        }
        if cycles > most || end > timing.frame {
            found.push(format!(
                "{}: spans of {cycles} cycles up to {end}, and units have {most} up to {}",
                machine.name, timing.frame
            ));
        }
        found
    };
    each_frame(machine, trial.frames, &memos(trial.frames), run).concat()
}

/// Whether a stage of a machine declares a number, or a share that is made of it.
fn is_declared(machine: &Machine, stat: &StatDecl) -> bool {
    let mut all = machine.flow().stages().iter().flat_map(|stage| stage.stats.iter().copied());
    all.any(|own| match own.of {
        StatOf::Share(part, whole) => own == stat || part == stat || whole.contains(&stat),
        _ => own == stat,
    })
}

/// What is done does not depend on when.
fn settled(trial: &Trial<'_>) -> Vec<String> {
    let slower: [&[&str]; 3] =
        [&[], &["dram.latency=700 ns", "dram.efficiency=0.2"], &["dram.model=banked"]];
    let counts = |more: &[&str]| {
        let sets = [&["dram.model=bandwidth"], trial.settled, more].concat();
        let machine = machine(trial, &sets).expect("a machine");
        let all = all_frames(&machine, trial.frames, &memos(trial.frames)).into_iter();
        let of = |timed: Result<Timed, String>| {
            let outcome = timed.expect("it ran").outcome;
            let clocks = |does| matches!(does, Does::Clock(_) | Does::IdleClock(_));
            let counts: Vec<u64> = hardware()
                .actions()
                .filter(|(_, does)| !clocks(*does))
                .map(|(action, _)| outcome.actions.total(action))
                .collect();
            (counts, outcome.served)
        };
        all.map(of).collect::<Vec<_>>()
    };
    let all: Vec<_> = slower.par_iter().map(|more| counts(more)).collect();
    let differs = all.iter().zip(slower).filter(|(counts, _)| **counts != all[0]);
    differs.map(|(_, more)| format!("with {more:?} other things are done")).collect()
}

/// Twice of a resource slows nothing.
fn doubled(trial: &Trial<'_>, machine: &Machine) -> Vec<String> {
    let mut table = machine.table();
    knob::set(&mut table, "dram.model", &"bandwidth".into());
    let cycles = |table: &Table| -> Option<u64> {
        let machine = variant(table, machine)?;
        let all = all_frames(&machine, trial.frames, &memos(trial.frames)).into_iter();
        all.map(|timed| Some(timed.ok()?.outcome.timing.frame)).sum()
    };
    let Some(before) = cycles(&table) else { return Vec::new() };
    let slows = |double: &crate::stage::DoubleDecl| {
        let mut twice = table.clone();
        for key in double.keys {
            knob::change(&mut twice, key, &mut |value| knob::scaled(value, 2.0));
        }
        // What does not fit is no faster machine.
        let after = cycles(&twice)?;
        (after as f64 > before as f64 * (1.0 + trial.slack)).then(|| {
            format!("{}: {} doubled: {before} cycles, then {after}", machine.name, double.name)
        })
    };
    doubles(machine).filter_map(slows).collect()
}

/// What a key may move.
type Moved = (Vec<Result<Timed, String>>, Option<Prices>);

/// Keys that move nothing.
fn dead_keys(trial: &Trial<'_>, machines: &[Machine]) -> Vec<String> {
    let Some(first) = machines.first() else { return Vec::new() };
    let outcome = |machine: &Machine| -> Moved {
        let own = trial.files.iter().find(|(name, _)| *name == machine.energy);
        let own = own.and_then(|(_, bytes)| std::str::from_utf8(bytes).ok());
        let table = own.or_else(|| find(ENERGY, &machine.energy)).map(EnergyTable::parse);
        let table = table.and_then(Result::ok);
        let prices = table.and_then(|table| cost::prices(&table, machine).ok());
        (all_frames(machine, trial.frames, &memos(trial.frames)), prices)
    };
    let bases: Vec<(&Machine, Moved)> = machines.par_iter().map(|m| (m, outcome(m))).collect();
    let moves = |base: &Machine, before: &Moved, path: &str, value: &Value| {
        let mut table = base.table();
        knob::change(&mut table, path, &mut |_| Some(value.clone()));
        variant(&table, base).is_some_and(|machine| outcome(&machine) != *before)
    };
    let keys = key_docs_of(&(first.flow().tables().schema)());
    let is_asked =
        |path: &str| !trial.idle_keys.contains(&path) && first.flow().fixed(path).is_none();
    let keys = keys.iter().filter(|doc| !doc.table && is_asked(&doc.path));
    let dead = keys.collect::<Vec<_>>().into_par_iter().filter(|doc| {
        !bases.iter().any(|(base, before)| {
            let values = knob::values(&base.table(), &doc.path);
            let others = values.iter().flat_map(|value| knob::others(value, &doc.choices()));
            others.into_iter().any(|value| moves(base, before, &doc.path, &value))
        })
    });
    dead.map(|doc| format!("`{}` moves nothing", doc.path)).collect()
}
