//! Machines with the knob of an assumption turned.

use super::files::Files;
use crate::cli::machine_file::LoadedMachine;
use powergs_base::config::assumptions::{Assumption, Knob};
use powergs_base::config::knob;
use powergs_report::sensitivity::Fixed;

/// Half.
const LOW: f64 = 0.5;
/// One and a half times.
const HIGH: f64 = 1.5;

/// One way to turn one knob: what it is set to, and the files.
#[derive(Debug, Clone)]
pub struct Way {
    /// What the keys are set to, as in a file.
    pub value: String,
    /// The files.
    pub files: Files,
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
    pub base: Files,
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
    loaded: &LoadedMachine,
    all: impl Iterator<Item = (u32, &'static Assumption)>,
) -> (Vec<Turn>, Vec<Fixed>) {
    let (mut turns, mut fixed) = (Vec::new(), Vec::new());
    for (number, assumption) in all {
        let mut why = assumption.none.clone();
        let before = turns.len();
        for knob in &assumption.knobs {
            match of_knob(loaded, number, assumption, knob) {
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
    loaded: &LoadedMachine,
    number: u32,
    assumption: &'static Assumption,
    knob: &'static Knob,
) -> Result<Vec<Turn>, String> {
    let base = match &knob.on {
        Some(other) => Files::of_other(other, &knob.with)?,
        None => Files::of(loaded, &knob.with)?,
    };
    let has = base.values(knob);
    if has.is_empty() {
        return Err(format!("the {} file has no `{}`", knob.file.name(), knob.keys.join("`, `")));
    }
    let turn = |low: Option<Way>, high: Option<Way>| {
        let (value, base) = (short(&has), base.clone());
        Turn { number, assumption, knob, value, base, low, high }
    };
    let way = |(files, values): (Files, Vec<String>)| Way { value: short(&values), files };
    let set = |text: &str| {
        let value = knob::written(text);
        base.turned(knob, |_| Some(value.clone())).map(way)
    };
    if let Some(names) = &knob.values {
        let others = names.iter().filter(|name| has.iter().any(|h| h != *name));
        return Ok(others.map(|name| turn(None, set(name))).collect());
    }
    let scaled = |factor: f64| base.turned(knob, |v| knob::scaled(v, factor)).map(way);
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
