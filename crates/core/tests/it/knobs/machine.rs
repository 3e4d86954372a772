//! Every key of every machine.

use std::collections::BTreeMap;
use std::{iter, slice};

use powergs_base::config::embedded::{DRAM, ENERGY, Embedded, MACHINES, find};
use powergs_base::config::{KeyDoc, key_docs, knob};
use powergs_core::flow::{self, Dataflow};
use powergs_core::machine::Machine;
use powergs_core::machine::Optional;
use rayon::prelude::*;
use toml::{Table, Value};

use super::Verdict;
use super::inert::{Inert, list};
use super::support::{Outcome, alone_and_shared, outcome};

/// Text for people.
const TEXT: [&str; 3] = ["dataflow", "name", "description"];

/// A machine with what comes out of it.
struct Base {
    values: Table,
    outcome: Outcome,
}

impl Base {
    fn of(text: &str, sets: &[String]) -> Base {
        let machine = Machine::parse_with(text, sets).unwrap_or_else(|e| panic!("{sets:?}: {e}"));
        let values = machine.to_toml().parse().expect("TOML");
        let outcome = outcome(&machine).unwrap_or_else(|e| panic!("{}: {e}", machine.name));
        Base { values, outcome }
    }

    /// Whether its dataflow has such a key.
    fn may_have(&self, doc: &KeyDoc) -> bool {
        let table = doc.path.split('.').next().unwrap_or_default();
        let own = self.values["dataflow"].as_str().and_then(|name| flow::named(name).ok());
        flow::of_table(table).is_none() || flow::has_key(own.expect("it has one"), &doc.path)
    }

    /// Whether its tables say the rate of its memory.
    fn knows_its_memory(&self) -> bool {
        let machine = Machine::parse(&self.values.to_string()).expect("it was one before");
        machine.flow().memory_rate(&machine).is_some()
    }

    /// What the key with this value does.
    fn verdict(&self, key: &str, value: &Value) -> Verdict {
        let mut table = self.values.clone();
        let n = knob::change(&mut table, key, &mut |_| Some(value.clone()));
        assert_eq!(n, 1, "{key}");
        let priced = match Machine::parse(&table.to_string()) {
            Ok(machine) => outcome(&machine),
            Err(e) => Err(e.to_string()),
        };
        match priced {
            Ok(new) => Verdict::of(new != self.outcome),
            Err(e) => Verdict::of_error(&e, key, value),
        }
    }

    /// What was tried without any effect; `None` for a key that has one.
    fn dead(&self, doc: &KeyDoc) -> Option<String> {
        // A key that may be left out: the list, or its part, says where it counts.
        let Some(value) = knob::values(&self.values, &doc.path).pop() else {
            return Some(format!("{}: left out", doc.path));
        };
        // Files that may say the same in the keys that matter here.
        let files = match doc.path.as_str() {
            "energy" => ENERGY,
            "dram.device" => DRAM,
            _ => &[],
        };
        let names = match files {
            [] if doc.path == "record.numbers" => {
                ["e5m10", "e5m6", "e4m3"].map(String::from).to_vec()
            }
            [] => doc.choices(),
            files => files.iter().map(|f| f.name.to_owned()).collect(),
        };
        let tried = knob::others(&value, &names);
        assert!(!tried.is_empty(), "{}: nothing to try", doc.path);
        let is_name = !names.is_empty() && files.is_empty();
        let mut verdicts = Vec::new();
        for value in &tried {
            verdicts.push(self.verdict(&doc.path, value));
            if !is_name && verdicts.contains(&Verdict::Moved) {
                return None;
            }
        }
        let tried: Vec<_> = tried.iter().zip(&verdicts).collect();
        let dead = !Verdict::is_alive(&verdicts, is_name);
        dead.then(|| format!("{}: {tried:?}", doc.path))
    }
}

/// Keys of a machine that move nothing, and those of them that move nothing either once their
/// condition is lifted.
fn dead_keys(file: &Embedded) -> (Vec<String>, Vec<String>) {
    // The memory that is simulated fastest: keys of the others have it in their condition.
    let flat = "dram.model=bandwidth".to_owned();
    let base = Base::of(file.text, slice::from_ref(&flat));
    let list = list();
    let docs = key_docs::<Machine>();
    let keys: Vec<&KeyDoc> =
        docs.iter().filter(|d| !d.table && !TEXT.contains(&d.path.as_str())).collect();
    let keys: Vec<&KeyDoc> = keys.into_iter().filter(|doc| base.may_have(doc)).collect();
    let inert: Vec<(&&KeyDoc, String)> =
        keys.par_iter().filter_map(|doc| Some((doc, base.dead(doc)?))).collect();
    let still = |(doc, dead): &(&&KeyDoc, String)| match list["machine"].get(&doc.path) {
        Some(Inert { lift_file: Some(other), .. }) => {
            assert_ne!(other, file.name, "{}: the condition is not lifted", doc.path);
            let other = find(MACHINES, other).expect("a machine that comes with the program");
            Base::of(other, slice::from_ref(&flat)).dead(doc)
        }
        // It must agree with what the tables say, so that it moves nothing by itself.
        Some(_) if doc.path == "dram.bandwidth" && base.knows_its_memory() => None,
        Some(inert) => {
            let sets: Vec<String> = iter::once(&flat).chain(&inert.lift).cloned().collect();
            Base::of(file.text, &sets).dead(doc)
        }
        None => match Optional::of(&doc.path) {
            Some(part) => {
                let with = iter::once(flat.as_str()).chain(part.with.iter().copied());
                let with: Vec<String> = with.map(str::to_owned).collect();
                // Not every machine can have every part.
                Machine::parse_with(file.text, &with).ok()?;
                Base::of(file.text, &with).dead(doc)
            }
            None => Some(dead.clone()),
        },
    };
    let dead = inert.par_iter().filter_map(still).collect();
    (inert.iter().map(|(doc, _)| doc.path.clone()).collect(), dead)
}

#[test]
fn every_part_can_be_added_to_a_machine() {
    for part in Optional::all() {
        let with: Vec<String> = part.with.iter().map(|set| (*set).to_owned()).collect();
        let can = |file: &Embedded| {
            let has =
                |sets: &[String]| Machine::parse_with(file.text, sets).map(|m| (part.is_there)(&m));
            let is_own = |flow: &dyn Dataflow| {
                let mut all = flow.stages().iter().flat_map(|stage| stage.optional);
                all.any(|own| (own.what, own.switch) == (part.what, part.switch))
            };
            let machine = Machine::parse(file.text).expect("it comes with the program");
            let is_common = !flow::all().any(is_own);
            (is_common || is_own(machine.flow())) && has(&[]) == Ok(false) && has(&with) == Ok(true)
        };
        assert!(MACHINES.iter().any(can), "{}", part.what);
    }
}

#[test]
fn every_key_of_every_machine_moves_something() {
    let mut dead = Vec::new();
    let mut inert = Vec::new();
    for file in MACHINES {
        let (without_lift, with_lift) = dead_keys(file);
        dead.extend(with_lift.into_iter().map(|key| format!("{}: {key}", file.name)));
        inert.extend(without_lift);
    }
    assert!(dead.is_empty(), "nothing moved: {dead:#?}");
    // A condition that no longer holds anywhere leaves the list, unless it depends on another key.
    let mut alive = Vec::new();
    for (key, entry) in &list()["machine"] {
        let met = inert.contains(key) || entry.lift.iter().any(|l| l == "dram.model=bandwidth");
        // What the frames of a trace decide: these have everything.
        let met = met || entry.when.contains("of the trace");
        alive.extend((!met).then_some(key));
    }
    assert!(alive.is_empty(), "arch-configs/inert.toml: alive in every machine: {alive:?}");
}

/// Settings under which the memory, the arithmetic or the codebook of the CCUs decides when they
/// are done, so that a key that a memo has forgotten shows.
const SHARED: [&[&str]; 3] = [
    &["dram.model=bandwidth"],
    &[
        "dram.model=bandwidth",
        "codebook.entries=4096",
        "codebook.word=2 B",
        "ccu.operations-per-cycle=8192",
        "ccu.intersection-units=64",
    ],
    &["dram.model=calibrated", "codebook.entries=4096", "codebook.word=2 B"],
];

/// Machines that differ in any one key share what is prepared for a frame, and each does what it
/// does alone.
#[test]
fn what_machines_share_changes_none_of_them() {
    let one = |(file, sets): (&Embedded, &[&str])| {
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        let base =
            Machine::parse_with(file.text, &sets).unwrap_or_else(|e| panic!("{sets:?}: {e}"));
        let values: Table = base.to_toml().parse().expect("TOML");
        let mut memos = BTreeMap::new();
        let mut findings = Vec::new();
        let mut compared = 0;
        // A calibration is a run of the device: those keys have to do that it reads first.
        let is_flat = sets.iter().any(|set| set == "dram.model=bandwidth");
        let is_tried = |doc: &&KeyDoc| {
            let table = doc.path.split('.').next();
            !doc.table && (is_flat || ["ccu", "codebook", "record"].map(Some).contains(&table))
        };
        for doc in key_docs::<Machine>().iter().filter(is_tried) {
            let Some(value) = knob::values(&values, &doc.path).pop() else { continue };
            for other in knob::others(&value, &doc.choices()) {
                let mut table = values.clone();
                knob::change(&mut table, &doc.path, &mut |_| Some(other.clone()));
                let Ok(machine) = Machine::parse(&table.to_string()) else { continue };
                let [alone, shared] = alone_and_shared(&machine, &mut memos);
                compared += 1;
                if alone != shared {
                    findings.push(format!("{}: {} = {other} with {sets:?}", file.name, doc.path));
                }
            }
        }
        assert!(compared > 20, "{}: {compared} machines", file.name);
        findings
    };
    // Each makes its lists and reads its records in another way.
    let few = ["gscore", "gbu", "neo", "gscore-powergs"];
    let few = MACHINES.iter().filter(|file| few.contains(&file.name));
    let all = few.flat_map(|file| SHARED.iter().map(move |sets| (file, *sets)));
    let is_quick = |(file, sets): &(&Embedded, &[&str])| {
        file.name == "gscore" || sets.contains(&"dram.model=bandwidth")
    };
    let cases: Vec<(&Embedded, &[&str])> = all.filter(is_quick).collect();
    let findings: Vec<String> = cases.into_par_iter().flat_map_iter(one).collect();
    assert!(findings.is_empty(), "not as alone: {findings:#?}");
}

/// The keys of the `bandwidth` model are inert in the others.
#[test]
fn keys_of_one_memory_model_are_inert_in_the_other() {
    let list = list();
    let base = Base::of(MACHINES[0].text, &["dram.model=banked".to_owned()]);
    for doc in key_docs::<Machine>().iter().filter(|d| !d.table) {
        let bandwidth_only = list["machine"]
            .get(&doc.path)
            .is_some_and(|i| i.lift.iter().any(|l| l == "dram.model=bandwidth"));
        if bandwidth_only {
            assert!(base.dead(doc).is_some(), "`{}` is no longer inert", doc.path);
        }
    }
}
