//! The keys of a machine's files, and the values that each is perturbed to: near ones for the
//! elasticity, far ones, other names.

use rayon::prelude::*;
use toml::{Table, Value};

use powergs_base::config::assumptions::{KnobFile, assumptions};
use powergs_base::config::embedded::{DRAM, ENERGY};
use powergs_base::config::inert::inert;
use powergs_base::config::{KeyDoc, key_docs, knob};
use powergs_core::machine::Machine;
use powergs_core::machine::{DramModel, Optional};
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{Change, System};
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;

use crate::findings::sensitivity::keys::{NotTried, Reach};

/// Last parts of keys that are text for people.
const TEXT: [&str; 4] = ["name", "description", "source", "scale-source"];
/// Relative steps that are tried after the one that was asked for.
const NEAR: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// Factors that are tried for the far values, the wanted one first.
const FAR: [[f64; 3]; 2] = [[0.5, 0.75, 0.25], [2.0, 1.25, 4.0]];
/// What a key that is 0 (off) is set to where no part of a machine says it; others are set to 1 of
/// their unit.
const OFF: [(&str, &str); 1] = [("schedule.merge-below", "256")];

/// A key with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Key {
    /// The file that has it.
    pub(super) file: KnobFile,
    /// Dotted; `[]` behind a name is every item of a list.
    pub(super) path: String,
    /// Its value.
    pub(super) value: Value,
    /// Other names; empty for a number.
    pub(super) names: Vec<Value>,
}

/// A key with another value.
#[derive(Debug, Clone)]
pub(super) struct KeyCandidate {
    /// How far.
    pub(super) reach: Reach,
    /// The value.
    pub(super) value: Value,
    /// Over the value of the machine, for numbers.
    pub(super) ratio: Option<f64>,
    /// The machine with it; or why that is invalid.
    pub(super) system: Result<System, String>,
}

impl Key {
    /// Whether it has a number that is not zero.
    pub(super) fn is_number(&self) -> bool {
        knob::scaled(&self.value, 2.0).is_some()
    }

    /// The key with another value.
    pub(super) fn change(&self, value: &Value) -> Change {
        Change { file: self.file.into(), path: self.path.clone(), value: value.clone() }
    }

    /// The machine with this value; or why that is invalid.
    pub(super) fn set(&self, base: &System, value: &Value) -> Result<System, String> {
        let mut changes = vec![self.change(value)];
        if self.path == "record.id-bits" {
            // What their bytes move is asked, not how many splats these frames have.
            let path = "record.id-check".to_owned();
            changes.push(Change { path, value: Value::Boolean(false), ..changes[0].clone() });
        }
        let system = base.with_from(&changes, &EmbeddedFiles);
        system.map_err(|error| error.message())
    }

    /// Why the key may move nothing, where that is known.
    pub(super) fn reason(&self) -> Option<String> {
        let listed = inert().get(self.file.name()).and_then(|keys| keys.get(&self.path));
        let quoted = format!("`{}`", self.path);
        let mentioned = || {
            let all = assumptions().values().filter_map(|a| a.none.as_ref());
            all.into_iter().find(|none| none.contains(&quoted)).cloned()
        };
        listed.map(|i| i.when.clone()).or_else(mentioned)
    }

    /// The values that it is perturbed to, each with the machine.
    pub(super) fn candidates(&self, base: &System, step: f64) -> Vec<KeyCandidate> {
        if !self.is_number() {
            let one = |value: &Value| KeyCandidate {
                reach: Reach::Name,
                value: value.clone(),
                ratio: None,
                system: self.set(base, value),
            };
            return self.names.iter().map(one).collect();
        }
        let steps: Vec<f64> =
            std::iter::once(step).chain(NEAR.into_iter().filter(|&s| s > step)).collect();
        let down: Vec<f64> = steps.iter().map(|s| 1.0 - s).chain([0.25]).collect();
        let up: Vec<f64> = steps.iter().map(|s| 1.0 + s).chain([4.0]).collect();
        let near = [down, up].into_iter().filter_map(|f| self.first(base, Reach::Near, &f));
        let far = FAR.iter().filter_map(|f| self.first(base, Reach::Far, f));
        near.chain(far).collect()
    }

    /// The first of some factors that is a machine; if none is, the first with the reason.
    fn first(&self, base: &System, reach: Reach, factors: &[f64]) -> Option<KeyCandidate> {
        let mut refused = None;
        let mut tried: Vec<Value> = Vec::new();
        for &factor in factors {
            let Some(value) = knob::scaled(&self.value, factor) else { continue };
            let ratio = number(&value).zip(number(&self.value)).map(|(new, old)| new / old);
            // What is rounded to zero has no logarithm.
            if tried.contains(&value) || ratio.is_none_or(|r| r <= 0.0) {
                continue;
            }
            tried.push(value.clone());
            let system = self.set(base, &value);
            let is_valid = system.is_ok();
            let candidate = KeyCandidate { reach, value, ratio, system };
            if is_valid {
                return Some(candidate);
            }
            refused.get_or_insert(candidate);
        }
        refused
    }
}

/// The number in a value, without its unit.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Integer(n) => Some(*n as f64),
        Value::Float(x) => Some(*x),
        Value::String(text) => text.split_once(' ')?.0.parse().ok(),
        _ => None,
    }
}

/// Every key that can be perturbed, and the files that cannot matter.
pub(super) fn all(base: &System) -> (Vec<Key>, Vec<NotTried>) {
    let (mut keys, mut not_tried) = (Vec::new(), Vec::new());
    let docs = [key_docs::<Machine>(), key_docs::<EnergyTable>(), key_docs::<Device>()];
    let model = base.machine().dram.model;
    for (file, docs) in KnobFile::ALL.into_iter().zip(docs) {
        if file == KnobFile::Dram && model == DramModel::Bandwidth {
            let why = match base.device() {
                Some(_) => {
                    "`dram.model` is `bandwidth`, which takes only the peak rate and prices from it"
                }
                None => "`dram.device` is `none`",
            };
            let why = why.to_owned();
            not_tried.push(NotTried { file: file.name(), keys: "the DRAM device".into(), why });
            continue;
        }
        let mut found = Vec::new();
        leaves(&base.table(file.into()).unwrap_or_default(), "", &mut found);
        // What is of a part that the machine lacks can move nothing; the key that brings it may.
        let is_of_machine = file == KnobFile::Machine;
        found.retain(|(path, _)| !is_of_machine || base.machine().lacks(path).is_none());
        for (path, value) in found {
            let last = path.rsplit('.').next().unwrap_or(&path);
            let names = others(&path, &value, &docs);
            let key = Key { file, path: path.clone(), value, names };
            if !TEXT.contains(&last) && (key.is_number() || !key.names.is_empty()) {
                keys.push(key);
            }
        }
    }
    (keys, not_tried)
}

fn leaves(table: &Table, prefix: &str, found: &mut Vec<(String, Value)>) {
    for (name, value) in table {
        let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        match value {
            Value::Table(inner) => leaves(inner, &path, found),
            Value::Array(items) => {
                if let Some(Value::Table(first)) = items.first() {
                    leaves(first, &format!("{path}[]"), found);
                }
            }
            value => found.push((path, value.clone())),
        }
    }
}

/// The other names of a key; for a number that is 0, what it is when it is on.
fn others(path: &str, value: &Value, docs: &[KeyDoc]) -> Vec<Value> {
    let files = match path {
        "energy" => ENERGY,
        "dram.device" => DRAM,
        _ => &[],
    };
    let names = files.iter().map(|f| Value::from(f.name));
    let mut names: Vec<Value> = names.filter(|n| n != value).collect();
    let is_key = |doc: &&KeyDoc| doc.path == path;
    let unit = docs.iter().find(is_key).map_or("", |d| d.unit.as_str());
    let choices = unit.strip_prefix("one of ").unwrap_or("").split(", ");
    names.extend(choices.filter(|n| !n.is_empty()).map(Value::from).filter(|n| n != value));
    let of_parts = Optional::all().flat_map(|part| part.with).filter_map(|set| set.split_once('='));
    let mut off = of_parts.chain(OFF).filter(|(key, _)| *key == path);
    let off = off.next().map(|(_, on)| knob::written(on));
    match value {
        Value::Boolean(b) => names.push(Value::Boolean(!b)),
        Value::Integer(0) => names.push(off.unwrap_or(Value::Integer(1))),
        Value::Float(x) if *x == 0.0 => names.push(off.unwrap_or(Value::Float(1.0))),
        Value::String(text) if text.starts_with("0 ") => {
            names.push(off.unwrap_or_else(|| text.replacen('0', "1", 1).into()));
        }
        _ => {}
    }
    names
}

/// All keys with their candidates, in the order of the files.
pub(super) fn candidates(keys: &[Key], base: &System, step: f64) -> Vec<Vec<KeyCandidate>> {
    keys.par_iter().map(|key| key.candidates(base, step)).collect()
}
