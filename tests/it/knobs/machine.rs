//! Every key of every machine.

use powergs_sim::accel::Machine;
use powergs_sim::config::embedded::{DRAM, ENERGY, Embedded, MACHINES};
use powergs_sim::config::{KeyDoc, key_docs, knob};
use rayon::prelude::*;
use toml::{Table, Value};

use super::inert::list;
use super::support::{Outcome, outcome};
use super::{choices, others};

/// Text for people.
const TEXT: [&str; 2] = ["name", "description"];

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

    /// Whether the key with this value gives something else, or an error that names the key.
    fn moves(&self, key: &str, value: &Value) -> bool {
        let mut table = self.values.clone();
        let n = knob::change(&mut table, key, &mut |_| Some(value.clone()));
        assert_eq!(n, 1, "{key}");
        let last = key.rsplit('.').next().unwrap_or(key);
        match Machine::parse(&table.to_string()) {
            Ok(machine) => outcome(&machine).map_or(true, |new| new != self.outcome),
            Err(e) => e.to_string().contains(last),
        }
    }

    /// Values of the key that move nothing. Of numbers it is enough that one moves something, and an
    /// error counts only where there is no other value: of names, each must.
    fn dead(&self, doc: &KeyDoc) -> Vec<String> {
        let value = knob::values(&self.values, &doc.path).pop().expect("every key has a value");
        let names = match doc.path.as_str() {
            "energy" => ENERGY.iter().map(|f| f.name.to_owned()).collect(),
            "dram.device" => DRAM.iter().map(|f| f.name.to_owned()).collect(),
            _ => choices(&doc.unit),
        };
        let tried = others(&value, &names);
        assert!(!tried.is_empty(), "{}: nothing to try", doc.path);
        let dead = |v: &&Value| !self.moves(&doc.path, v);
        if names.is_empty() && tried.iter().any(|v| self.moves(&doc.path, v)) {
            return Vec::new();
        }
        tried.iter().filter(dead).map(|v| format!("{}={v}", doc.path)).collect()
    }
}

/// Keys of a machine that move nothing, and those of them that move nothing either once their
/// condition is lifted.
fn dead_keys(file: &Embedded) -> (Vec<String>, Vec<String>) {
    let base = Base::of(file.text, &[]);
    let list = list();
    let docs = key_docs::<Machine>();
    let keys: Vec<&KeyDoc> =
        docs.iter().filter(|d| !d.table && !TEXT.contains(&d.path.as_str())).collect();
    let found: Vec<(Option<String>, Vec<String>)> = keys
        .par_iter()
        .map(|doc| {
            let dead = base.dead(doc);
            if dead.is_empty() {
                return (None, dead);
            }
            let still = match list["machine"].get(&doc.path) {
                Some(inert) => Base::of(file.text, &inert.lift).dead(doc),
                None => dead,
            };
            (Some(doc.path.clone()), still)
        })
        .collect();
    let (inert, dead): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    (inert.into_iter().flatten().collect(), dead.concat())
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
    // A condition that nobody meets any more leaves the list, unless it depends on another key.
    for (key, entry) in &list()["machine"] {
        let met = inert.contains(key) || entry.lift.iter().any(|l| l == "dram.model=bandwidth");
        assert!(met, "arch-configs/inert.toml: `{key}` is alive in every machine");
    }
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
            assert!(!base.dead(doc).is_empty(), "`{}` is no longer inert", doc.path);
        }
    }
}
