//! Machines with the knob of an assumption turned: files changed as TOML, read again and checked.

use toml::{Table, Value};

use crate::accel::Machine;
use crate::cli::machine_file::LoadedMachine;
use crate::cli::what_if::Variant;
use crate::config::assumptions::{Assumption, Knob, KnobFile};
use crate::config::embedded::{DRAM, ENERGY, MACHINES, find};
use crate::config::knob;
use crate::dram::Device;
use crate::energy::EnergyTable;
use crate::report::sensitivity::Fixed;
use crate::sim;

/// Half.
const LOW: f64 = 0.5;
/// One and a half times.
const HIGH: f64 = 1.5;

/// The three files of a machine, as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Files {
    machine: String,
    energy: String,
    device: String,
}

impl Files {
    /// Those of `loaded` with further `--set` values; another energy table or device must be one
    /// that comes with the program.
    ///
    /// # Errors
    /// Why that is no machine, in one line.
    pub fn of(loaded: &LoadedMachine, with: &[String]) -> Result<Files, String> {
        let machine = Machine::parse_with(&loaded.resolved_toml, with).map_err(one_line)?;
        let other = |kind: &str, name: &str, files| {
            let text = find(files, name).map(str::to_owned);
            text.ok_or_else(|| format!("no {kind} `{name}` comes with the program"))
        };
        let energy = match machine.energy == loaded.machine.energy {
            true => loaded.energy_toml.clone(),
            false => other("energy table", &machine.energy, ENERGY)?,
        };
        let device = match machine.dram.device == loaded.machine.dram.device {
            true => loaded.device_file.text.clone(),
            false => other("DRAM device", &machine.dram.device, DRAM)?,
        };
        Ok(Files { machine: machine.to_toml(), energy, device })
    }

    /// Those of another machine, which comes with the program.
    ///
    /// # Errors
    /// As [`Files::of`].
    pub fn of_other(name: &str, with: &[String]) -> Result<Files, String> {
        let text = find(MACHINES, name);
        let text = text.ok_or_else(|| format!("no machine `{name}` comes with the program"))?;
        let machine = Machine::parse_with(text, with).map_err(one_line)?;
        let text = |files, name: &str| {
            let text = find(files, name).map(str::to_owned);
            text.ok_or_else(|| format!("no file `{name}` comes with the program"))
        };
        let energy = text(ENERGY, &machine.energy)?;
        let device = text(DRAM, &machine.dram.device)?;
        Ok(Files { machine: machine.to_toml(), energy, device })
    }

    fn text(&mut self, file: KnobFile) -> &mut String {
        match file {
            KnobFile::Machine => &mut self.machine,
            KnobFile::Energy => &mut self.energy,
            KnobFile::Dram => &mut self.device,
        }
    }

    /// What the files have at the keys of `knob`, numbers or names, each once.
    pub fn values(&self, knob: &Knob) -> Vec<String> {
        let table = self.clone().text(knob.file).parse::<Table>().unwrap_or_default();
        let all = knob.keys.iter().flat_map(|key| knob::values(&table, key));
        let mut shown: Vec<String> = all.map(|v| knob::shown(&v)).collect();
        shown.dedup();
        shown
    }

    /// The files with every key of `knob` changed, and the values that came out, each once. A key
    /// whose value cannot be changed (a price that is zero) stays.
    fn turned(
        &self,
        knob: &Knob,
        mut to: impl FnMut(&Value) -> Option<Value>,
    ) -> Option<(Files, Vec<String>)> {
        let mut files = self.clone();
        let mut table: Table = files.text(knob.file).parse().ok()?;
        let mut shown = Vec::new();
        for key in &knob.keys {
            knob::change(&mut table, key, &mut |value| {
                let new = to(value)?;
                shown.push(knob::shown(&new));
                Some(new)
            });
        }
        shown.dedup();
        *files.text(knob.file) = table.to_string();
        (!shown.is_empty()).then_some((files, shown))
    }

    /// The machine of these files with its prices.
    ///
    /// # Errors
    /// Why they are none, in one line.
    pub fn variant(&self) -> Result<Variant, String> {
        let mut machine = Machine::parse(&self.machine).map_err(one_line)?;
        let device = Device::parse(&self.device).map_err(one_line)?;
        machine.link(&device).map_err(|(_, message)| message)?;
        let table = EnergyTable::parse(&self.energy).map_err(one_line)?;
        let prices = sim::cost::prices(&table, &machine).map_err(one_line)?;
        Ok(Variant { machine, prices })
    }
}

/// An error without its place in a file that nobody has.
fn one_line(error: impl std::fmt::Display) -> String {
    let text = error.to_string();
    let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.contains('|'));
    let without_place = |line: &str| {
        let rest = line.strip_prefix("line ").and_then(|l| l.split_once(": "));
        rest.map_or(line, |(_, what)| what).to_owned()
    };
    lines.map(without_place).collect::<Vec<_>>().join(" ")
}

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
