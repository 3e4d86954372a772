//! Which keys act together, and the values that each of them takes.

use rayon::prelude::*;
use toml::Value;

use super::keys::{Key, number};
use crate::cli::{Exit, Failure};
use powergs_base::config::knob;
use powergs_base::config::suggest::nearest;
use powergs_core::run::System;
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::interactions::Factor;
use powergs_study::findings::sensitivity::keys::Keys;

/// Values of a number over its range.
const LEVELS: usize = 4;
/// Where no range is given: these times what the machine has, near enough to even steps of the
/// logarithm to be round numbers.
const FACTORS: [f64; LEVELS] = [0.5, 0.75, 1.25, 2.0];
/// Keys that are chosen where none is given.
const CHOSEN: usize = 12;
/// Names of whole files: they are never chosen, only taken where they are given.
const WHOLE: [&str; 2] = ["energy", "dram.device"];

/// What stands behind `--keys`: a key, or all that begin with it, and its values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wanted {
    /// As it was typed.
    pub text: String,
    /// The key; `*` at its end is any rest.
    pub key: String,
    /// The values.
    pub values: Values,
}

/// The values that a key is to take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Values {
    /// From half to double, or all names.
    Usual,
    /// `LOW..HIGH`.
    Range(String, String),
    /// `A|B|C`.
    List(Vec<String>),
}

/// Reads one item of `--keys`.
///
/// # Errors
/// What is wrong with it.
pub fn wanted(text: &str) -> Result<Wanted, String> {
    let (key, values) = text.split_once('=').map_or((text, None), |(k, v)| (k, Some(v)));
    let key = key.trim().to_owned();
    if key.is_empty() {
        return Err("a key is missing: write KEY, KEY=LOW..HIGH or KEY=A|B|C".into());
    }
    let trimmed = |text: &str| text.trim().to_owned();
    let values = match values {
        None => Values::Usual,
        Some(text) => match text.split_once("..") {
            Some((low, high)) => Values::Range(trimmed(low), trimmed(high)),
            None => Values::List(text.split('|').map(trimmed).collect()),
        },
    };
    Ok(Wanted { text: text.to_owned(), key, values })
}

impl Wanted {
    /// Whether this is about the key.
    pub fn is(&self, key: &Key) -> bool {
        match self.key.strip_suffix('*') {
            Some(start) => key.path.starts_with(start),
            None => key.path == self.key,
        }
    }
}

/// Those keys that are wanted; all, if none is given.
///
/// # Errors
/// Exit code 2: one that no key is.
pub fn only(keys: Vec<Key>, wanted: &[Wanted]) -> Result<Vec<Key>, Failure> {
    for w in wanted {
        if !keys.iter().any(|k| w.is(k)) {
            let near = nearest(&w.key, keys.iter().map(|k| k.path.as_str()));
            let near = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
            let what = "is no key that can be turned in the files of this machine";
            return Err(Failure::new(Exit::Usage, format!("--keys: `{}` {what}{near}", w.key)));
        }
    }
    let is_wanted = |key: &Key| wanted.is_empty() || wanted.iter().any(|w| w.is(key));
    Ok(keys.into_iter().filter(is_wanted).collect())
}

/// A key with its values, for machines.
#[derive(Debug, Clone)]
pub struct Levelled {
    /// The key.
    pub key: Key,
    /// Its values, ascending for numbers; at least two.
    pub levels: Vec<Value>,
}

impl Levelled {
    /// The same for reports.
    pub fn factor(&self) -> Factor {
        Factor {
            file: self.key.file.name(),
            key: self.key.path.clone(),
            value: knob::shown(&self.key.value),
            levels: self.levels.iter().map(knob::shown).collect(),
        }
    }
}

/// The keys that act together: those that are wanted, or the ones that move frame rate and energy
/// most. Keys with fewer than two values are left out.
///
/// # Errors
/// Exit code 2: a value that is no machine, or nothing to turn.
pub fn levelled(
    keys: &[Key],
    wanted: &[Wanted],
    found: &Keys,
    base: &System,
) -> Result<Vec<Levelled>, Failure> {
    let chosen: Vec<&Key> =
        if wanted.is_empty() { chosen(keys, found) } else { keys.iter().collect() };
    let values =
        |key: &Key| wanted.iter().rfind(|w| w.is(key)).map_or(&Values::Usual, |w| &w.values);
    let of = |key: &&Key| {
        let levels = match values(key) {
            Values::Usual => Ok(usual(key, base)),
            Values::Range(low, high) => range(key, base, low, high),
            Values::List(all) => list(key, base, all),
        };
        let usage = |why| Failure::new(Exit::Usage, format!("--keys {}: {why}", key.path));
        Ok(Levelled { key: (*key).clone(), levels: levels.map_err(usage)? })
    };
    let all = chosen.par_iter().map(of).collect::<Result<Vec<Levelled>, Failure>>()?;
    let all: Vec<Levelled> = all.into_iter().filter(|l| l.levels.len() > 1).collect();
    if all.is_empty() {
        let what = "no key has two values that are machines: nothing acts together";
        return Err(Failure::new(Exit::Usage, what.to_owned()));
    }
    Ok(all)
}

/// The keys that move frame rate and energy most, in the order of the files.
fn chosen<'a>(keys: &'a [Key], found: &Keys) -> Vec<&'a Key> {
    let effect = |key: &Key| {
        let is_row = |r: &&powergs_study::findings::sensitivity::keys::KeyRow| {
            r.key == key.path && r.file == key.file.name()
        };
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
        return Err(format!("`{low}..{high}` is no range of numbers; names are written A|B|C"));
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
        key.set(base, end).map_err(|why| format!("{} is no machine: {why}", knob::shown(end)))?;
    }
    levels.retain(|value| key.set(base, value).is_ok());
    Ok(levels)
}

fn list(key: &Key, base: &System, all: &[String]) -> Result<Vec<Value>, String> {
    let mut levels: Vec<Value> = Vec::new();
    for text in all {
        let value = knob::written(text);
        key.set(base, &value).map_err(|why| format!("{text} is no machine: {why}"))?;
        if !levels.contains(&value) {
            levels.push(value);
        }
    }
    Ok(levels)
}
