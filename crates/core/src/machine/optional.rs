//! Parts that a machine may not have, and choices that bring keys of their own. Without them those
//! keys have no effect: files leave them out, and what is asked of them is refused.

use toml::Table;

use crate::flow::{self, Dataflow};
use crate::machine::{Machine, MemoryOwner};
use powergs_base::config::{Config, Place, Problem};

/// A part with keys of its own.
#[derive(Debug, Clone, Copy)]
pub struct Optional {
    /// What it is, with its article.
    pub what: &'static str,
    /// The key that brings it.
    pub switch: &'static str,
    /// Its keys: a table with all that is in it, or single keys.
    pub keys: &'static [&'static str],
    /// `--set` values with which a machine has it.
    pub with: &'static [&'static str],
    /// Whether a machine has it.
    pub is_there: fn(&Machine) -> bool,
}

/// Those of every dataflow.
const COMMON: [Optional; 5] = [
    Optional {
        what: "a memory of others",
        switch: "dram.owner",
        keys: &["dram.standby-share"],
        with: &["dram.owner=shared", "dram.standby-share=0.25"],
        is_there: |m| m.dram.owner == MemoryOwner::Shared,
    },
    Optional {
        what: "a second master",
        switch: "dram.second-master.rate",
        keys: &["dram.second-master"],
        with: &["dram.second-master.rate=5 GB/s"],
        is_there: |m| m.dram.second_master.is_on(),
    },
    Optional {
        what: "a third master",
        switch: "dram.third-master.rate",
        keys: &["dram.third-master"],
        with: &["dram.third-master.rate=5 GB/s"],
        is_there: |m| m.dram.third_master.is_on(),
    },
    Optional {
        what: "a fourth master",
        switch: "dram.fourth-master.rate",
        keys: &["dram.fourth-master"],
        with: &["dram.fourth-master.rate=5 GB/s"],
        is_there: |m| m.dram.fourth_master.is_on(),
    },
    Optional {
        what: "power gating",
        switch: "gating.units",
        keys: &["gating"],
        with: &["gating.units=true"],
        is_there: |m| m.gating.units,
    },
];

/// Those of a dataflow, stage by stage.
fn of_flow(flow: &dyn Dataflow) -> impl Iterator<Item = &'static Optional> + use<> {
    flow.stages().iter().flat_map(|stage| stage.optional)
}

/// Those of a machine, the common ones first.
fn of_machine(machine: &Machine) -> impl Iterator<Item = &'static Optional> + use<> {
    COMMON.iter().chain(of_flow(machine.flow()))
}

impl Optional {
    /// All of them, of all dataflows.
    pub fn all() -> impl Iterator<Item = &'static Optional> {
        COMMON.iter().chain(flow::all().flat_map(of_flow))
    }

    /// The part that a key is of; `None` for one that every machine has.
    pub fn of(key: &str) -> Option<&'static Optional> {
        // The narrowest: bits of a distance are of the eviction, then of the cache.
        // Of what several dataflows have, that of the first.
        let all = Optional::all().filter(|part| part.has(key));
        all.min_by_key(|part| std::cmp::Reverse(part.keys[0].len()))
    }

    /// Whether a key is one of its own.
    fn has(&self, key: &str) -> bool {
        self.keys.iter().any(|own| {
            key.strip_prefix(own).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        })
    }

    /// What is to be said of one of its keys where it is not there, with the remedy.
    pub fn absent(&self, key: &str) -> String {
        let Optional { what, switch, with, .. } = self;
        format!(
            "`{key}` is of {what}, which this machine does not have: give `{switch}` (for example \
             --set '{}')",
            with.join("' --set '")
        )
    }

    /// Whether a machine has it.
    pub fn is_in(&self, machine: &Machine) -> bool {
        (self.is_there)(machine)
    }
}

impl Machine {
    /// The part without which a key has no effect on this machine, as it does not have it.
    pub fn lacks(&self, key: &str) -> Option<&'static Optional> {
        of_machine(self).find(|part| part.has(key) && part.switch != key && !part.is_in(self))
    }

    /// Parts and choices that it may be without, the common ones first.
    pub fn optional_parts(&self) -> impl Iterator<Item = &'static Optional> + use<> {
        of_machine(self)
    }

    /// Whether a file of this machine leaves a key out.
    pub fn leaves_out(&self, key: &str) -> bool {
        of_machine(self).any(|part| part.has(key) && !part.is_in(self))
    }
}

/// Takes the keys of all parts that a machine does not have out of its table.
pub(crate) fn leave_out(table: &mut Table, machine: &Machine) {
    for part in of_machine(machine).filter(|part| !part.is_in(machine)) {
        part.keys.iter().for_each(|key| remove_key(table, key));
    }
}

/// A table without a key: dots between its parts.
#[doc(hidden)]
#[must_use]
pub fn without_key(mut table: Table, key: &str) -> Table {
    remove_key(&mut table, key);
    table
}

fn remove_key(table: &mut Table, key: &str) {
    let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
    let mut tables = tables.split('.').filter(|name| !name.is_empty());
    let at = tables.try_fold(table, |at, name| at.get_mut(name)?.as_table_mut());
    if let Some(at) = at {
        at.remove(last);
    }
}

/// Keys of parts that the machine does not have: asked for by `--set`, or in a file that does not
/// say whether it has the part. A file that says that it has none may keep the other keys.
pub(super) fn strays(config: &Config<Machine>) -> Vec<Problem> {
    let stray = |(key, place): (&str, &Place)| {
        let part = config.value.lacks(key)?;
        let is_table = part.keys.contains(&key) && part.switch.starts_with(&format!("{key}."));
        let is_meant = matches!(place, Place::Set(_)) || !config.states(part.switch);
        (is_meant && !is_table).then(|| config.problem(key, part.absent(key)))
    };
    config.stated().filter_map(stray).collect()
}
