//! Machines with the knob of an assumption turned.

use powergs_base::config::assumptions::{Assumption, Knob};
use powergs_base::config::knob;
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{Change, System, SystemSpec};
use powergs_study::findings::sensitivity::Fixed;

/// Half.
const LOW: f64 = 0.5;
/// One and a half times.
const HIGH: f64 = 1.5;

/// One way to turn one knob: what it is set to, and the files.
#[derive(Debug, Clone)]
pub struct Way {
    /// What the keys are set to, as in a file.
    pub value: String,
    /// The machine with it; or why that is invalid.
    pub system: Result<System, String>,
}

/// A knob of an assumption with its ways.
#[derive(Debug, Clone)]
pub struct Turn {
    /// `A4`.
    pub number: u32,
    /// The assumption.
    pub assumption: &'static Assumption,
    /// The knob.
    pub knob: &'static Knob,
    /// What the keys have.
    pub value: String,
    /// The machine that the ways are compared with.
    pub base: System,
    /// Down.
    pub low: Option<Way>,
    /// Up, or to another name.
    pub high: Option<Way>,
}

/// A few of the values, as one text.
fn short(values: &[String]) -> String {
    match values {
        [one] => one.clone(),
        [first, .., last] => format!("{first} ... {last}"),
        [] => String::new(),
    }
}

/// All knobs of the assumptions of these numbers (all, if none is given) on a machine, and the
/// assumptions that have none on it.
pub fn turns(
    system: &System,
    all: impl Iterator<Item = (u32, &'static Assumption)>,
) -> (Vec<Turn>, Vec<Fixed>) {
    let (mut turns, mut fixed) = (Vec::new(), Vec::new());
    for (number, assumption) in all {
        let mut why = assumption.none.clone();
        let before = turns.len();
        for knob in &assumption.knobs {
            match of_knob(system, number, assumption, knob) {
                Ok(found) => turns.extend(found),
                Err(reason) => why = Some(reason),
            }
        }
        if turns.len() == before {
            let why = why.unwrap_or_else(|| "the machine has every value of the knob".to_owned());
            let text = assumption.text.clone();
            fixed.push(Fixed { number: format!("A{number}"), text, why });
        }
    }
    (turns, fixed)
}

fn of_knob(
    system: &System,
    number: u32,
    assumption: &'static Assumption,
    knob: &'static Knob,
) -> Result<Vec<Turn>, String> {
    let base = base(system, knob)?;
    let has = values(&base, knob);
    if has.is_empty() {
        return Err(format!("the {} file has no `{}`", knob.file.name(), knob.keys.join("`, `")));
    }
    let turn = |low: Option<Way>, high: Option<Way>| {
        let (value, base) = (short(&has), base.clone());
        Turn { number, assumption, knob, value, base, low, high }
    };
    let set = |text: &str| {
        let value = knob::written(text);
        changed(&base, knob, |_| Some(value.clone()))
    };
    if let Some(names) = &knob.values {
        let others = names.iter().filter(|name| has.iter().any(|h| h != *name));
        return Ok(others.map(|name| turn(None, set(name))).collect());
    }
    let scaled = |factor: f64| changed(&base, knob, |v| knob::scaled(v, factor));
    let side = |given: &Option<String>, factor| match given {
        Some(text) => set(text),
        None => scaled(factor),
    };
    let (low, high) = (side(&knob.low, LOW), side(&knob.high, HIGH));
    if low.is_none() && high.is_none() {
        return Err(format!(
            "`{}` is {}, which nothing scales",
            knob.keys.join("`, `"),
            short(&has)
        ));
    }
    Ok(vec![turn(low, high)])
}

/// The machine that the ways of a knob are compared with.
fn base(system: &System, knob: &Knob) -> Result<System, String> {
    let other = match &knob.on {
        Some(name) => {
            Some(System::load(&SystemSpec::named(name), &EmbeddedFiles).map_err(|e| e.message())?)
        }
        None => None,
    };
    let with: Result<Vec<Change>, String> = knob.with.iter().map(|set| set.parse()).collect();
    let base = other.as_ref().unwrap_or(system).with_from(&with?, &EmbeddedFiles);
    base.map_err(|error| error.message())
}

/// What a system has at the keys of `knob`, numbers or names, each once.
fn values(system: &System, knob: &Knob) -> Vec<String> {
    let table = system.table(knob.file.into()).unwrap_or_default();
    let all = knob.keys.iter().flat_map(|key| knob::values(&table, key));
    let mut shown: Vec<String> = all.map(|v| knob::shown(&v)).collect();
    shown.dedup();
    shown
}

/// A system with every key of `knob` changed; `None` if no value can be changed. A key whose value
/// cannot be changed (a price that is zero) stays.
fn changed(
    base: &System,
    knob: &Knob,
    mut to: impl FnMut(&toml::Value) -> Option<toml::Value>,
) -> Option<Way> {
    let mut table = base.table(knob.file.into())?;
    let mut shown = Vec::new();
    for key in &knob.keys {
        knob::change(&mut table, key, &mut |value| {
            let new = to(value)?;
            shown.push(knob::shown(&new));
            Some(new)
        });
    }
    shown.dedup();
    if shown.is_empty() {
        return None;
    }
    let system = base.with_table(knob.file.into(), &table, &EmbeddedFiles);
    Some(Way { value: short(&shown), system: system.map_err(|error| error.message()) })
}
