//! Which keys act together, and the values that each of them takes.

use std::str::FromStr;

use powergs_base::config::knob;
use powergs_base::config::suggest::nearest;
use powergs_core::machine::Machine;
use powergs_core::run::{RunError, System};
use rayon::prelude::*;
use toml::Value;

use super::key::{Key, number};
use crate::findings::sensitivity::Measure;
use crate::findings::sensitivity::interactions::Factor;
use crate::findings::sensitivity::keys::{KeyRow, Keys};

/// Values of a number over its range.
const LEVELS: usize = 4;
/// Where no range is given: these times what the machine has, near enough to even steps of the
/// logarithm to be round numbers.
const FACTORS: [f64; LEVELS] = [0.5, 0.75, 1.25, 2.0];
/// Keys that are chosen where none is given.
const CHOSEN: usize = 12;
/// Names of whole files: they are never chosen, only taken where they are given.
const WHOLE: [&str; 2] = ["energy", "dram.device"];

/// Which keys an experiment is about: one, or all that begin with the same letters; and the values
/// that they take together with others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeySelection {
    /// The key, or the beginning of keys with `*` behind it.
    pub key: String,
    /// The values.
    pub levels: Levels,
}

/// The values that a key takes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Levels {
    /// From half to double, or all names.
    Usual,
    /// From the first to the second, as in a file.
    Range(String, String),
    /// These, as in a file.
    List(Vec<String>),
}

impl FromStr for KeySelection {
    type Err = String;

    /// Reads `KEY`, `KEY=LOW..HIGH` or `KEY=A|B|C`.
    fn from_str(text: &str) -> Result<KeySelection, String> {
        let (key, values) = text.split_once('=').map_or((text, None), |(k, v)| (k, Some(v)));
        let key = key.trim().to_owned();
        if key.is_empty() {
            return Err("a key is missing: write KEY, KEY=LOW..HIGH or KEY=A|B|C".into());
        }
        let trimmed = |text: &str| text.trim().to_owned();
        let levels = match values {
            None => Levels::Usual,
            Some(text) => match text.split_once("..") {
                Some((low, high)) => Levels::Range(trimmed(low), trimmed(high)),
                None => Levels::List(text.split('|').map(trimmed).collect()),
            },
        };
        Ok(KeySelection { key, levels })
    }
}

impl KeySelection {
    /// Whether values stand behind the key.
    pub fn has_values(&self) -> bool {
        !matches!(self.levels, Levels::Usual)
    }

    fn matches(&self, key: &Key) -> bool {
        match self.key.strip_suffix('*') {
            Some(start) => key.path.starts_with(start),
            None => key.path == self.key,
        }
    }
}

/// The keys that are selected; all, if there is no selection.
///
/// # Errors
/// [`RunError::Request`]: a selection that matches no key.
pub(super) fn selected(
    keys: Vec<Key>,
    selection: &[KeySelection],
    machine: &Machine,
) -> Result<Vec<Key>, RunError> {
    for s in selection {
        if !keys.iter().any(|k| s.matches(k)) {
            if let Some(part) = machine.lacks(&s.key) {
                return Err(RunError::Request(format!("--keys: {}", part.absent(&s.key))));
            }
            let near = nearest(&s.key, keys.iter().map(|k| k.path.as_str()));
            let near = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
            let what = "is not a key that can be varied in the files of this machine";
            return Err(RunError::Request(format!("--keys: `{}` {what}{near}", s.key)));
        }
    }
    let is_selected = |key: &Key| selection.is_empty() || selection.iter().any(|s| s.matches(key));
    Ok(keys.into_iter().filter(is_selected).collect())
}

/// A key with the values that it takes.
#[derive(Debug, Clone)]
pub(super) struct FactorLevels {
    /// The key.
    pub(super) key: Key,
    /// Its values, ascending for numbers; at least two.
    pub(super) levels: Vec<Value>,
}

impl FactorLevels {
    /// The same as a result has it.
    pub(super) fn factor(&self) -> Factor {
        Factor {
            file: self.key.file.name(),
            key: self.key.path.clone(),
            value: knob::shown(&self.key.value),
            levels: self.levels.iter().map(knob::shown).collect(),
        }
    }
}

/// The keys that act together: those that are selected, or the ones that move frame rate and energy
/// most. Keys with fewer than two values are left out.
///
/// # Errors
/// [`RunError::Request`]: a value that is no machine, or no key with two values.
pub(super) fn factors(
    keys: &[Key],
    selection: &[KeySelection],
    found: &Keys,
    base: &System,
) -> Result<Vec<FactorLevels>, RunError> {
    let chosen: Vec<&Key> =
        if selection.is_empty() { chosen(keys, found) } else { keys.iter().collect() };
    let of = |key: &&Key| {
        let selected = selection.iter().rfind(|s| s.matches(key));
        let levels = match selected.map_or(&Levels::Usual, |s| &s.levels) {
            Levels::Usual => Ok(usual(key, base)),
            Levels::Range(low, high) => range(key, base, low, high),
            Levels::List(all) => list(key, base, all),
        };
        let wrong = |why| RunError::Request(format!("--keys {}: {why}", key.path));
        Ok(FactorLevels { key: (*key).clone(), levels: levels.map_err(wrong)? })
    };
    let all = chosen.par_iter().map(of).collect::<Result<Vec<FactorLevels>, RunError>>()?;
    let all: Vec<FactorLevels> = all.into_iter().filter(|f| f.levels.len() > 1).collect();
    if all.is_empty() {
        let what = "no key has two values that are machines: nothing acts together";
        return Err(RunError::Request(what.to_owned()));
    }
    Ok(all)
}

/// The keys that move frame rate and energy most, in the order of the files.
fn chosen<'a>(keys: &'a [Key], found: &Keys) -> Vec<&'a Key> {
    let effect = |key: &Key| {
        let is_row = |r: &&KeyRow| r.key == key.path && r.file == key.file.name();
        let row = found.rows.iter().find(is_row);
        row.map_or(0.0, |r| r.effect(Measure::Fps).max(r.effect(Measure::Energy)))
    };
    let all = keys.iter().filter(|k| !WHOLE.contains(&k.path.as_str()));
    let mut all: Vec<(f64, usize, &Key)> =
        all.enumerate().map(|(i, k)| (effect(k), i, k)).collect();
    all.retain(|(effect, ..)| *effect > 0.0);
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.truncate(CHOSEN);
    all.sort_by_key(|(_, i, _)| *i);
    all.into_iter().map(|(_, _, key)| key).collect()
}

/// Half to double of a number, or all names; those that are machines by themselves.
fn usual(key: &Key, base: &System) -> Vec<Value> {
    let is_machine = |value: &Value| key.set(base, value).is_ok();
    if !key.is_number() {
        let others = key.names.iter().filter(|v| is_machine(v)).cloned();
        return std::iter::once(key.value.clone()).chain(others).collect();
    }
    let mut levels: Vec<Value> =
        FACTORS.into_iter().filter_map(|f| knob::scaled(&key.value, f)).collect();
    levels.dedup();
    levels.retain(is_machine);
    if levels.len() < LEVELS {
        levels.push(key.value.clone());
        levels.sort_by(|a, b| number(a).partial_cmp(&number(b)).expect("no NaN in a file"));
    }
    levels
}

/// Even steps from `low` to `high`, of the logarithm where both are above zero.
fn range(key: &Key, base: &System, low: &str, high: &str) -> Result<Vec<Value>, String> {
    let ends = [low, high].map(knob::written);
    let unit = |v: &Value| v.as_str().and_then(|t| t.split_once(' ')).map(|(_, u)| u.to_owned());
    let numbers = ends.each_ref().map(number);
    let (Some(a), Some(b)) = (numbers[0], numbers[1]) else {
        return Err(format!("`{low}..{high}` is not a range of numbers; names are written A|B|C"));
    };
    if unit(&ends[0]) != unit(&ends[1]) {
        return Err(format!("write both ends of `{low}..{high}` in one unit"));
    }
    if a >= b {
        return Err(format!("`{low}..{high}` must ascend"));
    }
    let is_whole = a.fract() == 0.0 && b.fract() == 0.0;
    let bytes = unit(&ends[0]).is_none_or(|u| u.ends_with('B'));
    let between = |i: usize| {
        let t = i as f64 / (LEVELS - 1) as f64;
        let x = if a > 0.0 { a * (b / a).powf(t) } else { a + (b - a) * t };
        if is_whole && bytes { x.round() } else { format!("{x:.3e}").parse().unwrap_or(x) }
    };
    let shown = |x: f64| match (&ends[0], unit(&ends[0])) {
        (Value::Integer(_), _) if is_whole => Value::Integer(x as i64),
        (_, Some(unit)) => format!("{x} {unit}").into(),
        _ => Value::Float(x),
    };
    let [first, last] = ends.clone();
    let mut levels = vec![first];
    levels.extend((1..LEVELS - 1).map(between).map(shown));
    levels.push(last);
    levels.dedup();
    for end in &ends {
        key.set(base, end)
            .map_err(|why| format!("{}: invalid configuration: {why}", knob::shown(end)))?;
    }
    levels.retain(|value| key.set(base, value).is_ok());
    Ok(levels)
}

fn list(key: &Key, base: &System, all: &[String]) -> Result<Vec<Value>, String> {
    let mut levels: Vec<Value> = Vec::new();
    for text in all {
        let value = knob::written(text);
        key.set(base, &value).map_err(|why| format!("{text}: invalid configuration: {why}"))?;
        if !levels.contains(&value) {
            levels.push(value);
        }
    }
    Ok(levels)
}
