//! `arch check`: everything that is wrong with files.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};

use super::Kind;
use super::cost::Cost;
use crate::cli::{Context, Exit, Failure, out};
use powergs_base::config::embedded::{DRAM, ENERGY};
use powergs_base::config::error::Place;
use powergs_base::config::{ConfigError, Problem};
use powergs_base::quantity::Hertz;
use powergs_core::machine::Machine;
use powergs_core::run::ConfigText;
use powergs_core::run::files::{DiskFiles, is_yaml, read};
use powergs_core::run::system::{self, energy_table};
use powergs_core::sim;
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use powergs_frame::display::Display;
use powergs_report::document::Document;
use powergs_scene::synth::Preset;
use powergs_study::sweep::file::SweepFile;
use powergs_study::sweep::run::opened::lies_in;
use powergs_study::sweep::space::Space;

/// What `check` found in one file.
struct Checked {
    file: ConfigText,
    kind: Kind,
    result: Result<Good, ConfigError>,
}

/// A file that is right.
struct Good {
    summary: String,
    /// Of a machine.
    cost: Option<Cost>,
}

impl From<String> for Good {
    fn from(summary: String) -> Good {
        Good { summary, cost: None }
    }
}

/// Runs `arch check`.
pub fn run(files: &[String], sets: &[String], context: &Context) -> Result<Exit, Failure> {
    let mut checked = Vec::new();
    let mut unread = false;
    for name in files {
        match super::open(name) {
            Ok((file, kind)) => checked.push(check_one(file, kind, sets)),
            Err(failure) => {
                unread = true;
                out::complain(format_args!("error: {failure}"));
            }
        }
    }
    if context.global.json {
        out::json(&checked.iter().map(checked_json).collect::<Vec<_>>())?;
    }
    for one in &checked {
        let origin = &one.file.origin;
        match &one.result {
            Ok(good) if !context.global.json && !context.global.quiet => {
                let mut page = Document::new();
                page.title(format!("{origin}: ok ({})", good.summary));
                page.extend(good.cost.as_ref().map(Cost::document).unwrap_or_default());
                one.file.decimal_sizes().into_iter().for_each(|doubt| {
                    page.paragraph(format!("Warning: {doubt}."));
                });
                out::document(&page)?;
            }
            Ok(_) => {}
            Err(error) => {
                out::complain(format_args!("error: {origin}: {error}"));
            }
        }
    }
    let good = !unread && checked.iter().all(|c| c.result.is_ok());
    Ok(if good { Exit::Done } else { Exit::Usage })
}

fn check_one(file: ConfigText, kind: Kind, sets: &[String]) -> Checked {
    let result = match kind {
        Kind::Machine => check_machine(&file, sets),
        Kind::Energy if is_yaml(&file.origin) => check_reference_table(&file),
        Kind::Energy => {
            EnergyTable::parse(&file.text).map(|t| format!("energy table {}", t.name).into())
        }
        Kind::Display => {
            Display::parse(&file.text).map(|d| format!("display preset {}", d.name).into())
        }
        Kind::Dram => {
            Device::parse_with(&file.text, sets).map(|d| format!("DRAM device {}", d.name).into())
        }
        Kind::Sweep => check_sweep(&file),
        Kind::Synth => Preset::parse(&file.text)
            .map(|p| format!("preset of synthetic scenes {}", p.name).into()),
    };
    Checked { file, kind, result }
}

/// A machine is right when its energy table can be found and has a price for its buffers, too.
fn check_machine(file: &ConfigText, sets: &[String]) -> Result<Good, ConfigError> {
    let mut machine = Machine::parse_with(&file.text, sets)?;
    let at_key = |key: &str, path: &str, message: String| {
        let set = sets.iter().find(|s| s.starts_with(&format!("{path}="))).cloned();
        let at = file.text.lines().scan(0, |at, line| {
            let start = *at;
            *at += line.len() + 1;
            Some((start, line))
        });
        let (start, width) = at
            .filter(|(_, l)| l.trim_start().starts_with(key))
            .map(|(start, l)| (start, l.trim_end().len()))
            .next()
            .unwrap_or((0, 1));
        let in_file = Place::of(&file.text, start..start + width);
        let place = set.map_or(in_file, Place::Set);
        ConfigError::new(vec![Problem { place, key: path.into(), message }])
    };
    let energy = |message: String| at_key("energy", "energy", message);
    file.clone().attach(&mut machine, &DiskFiles).map_err(|e| {
        let message = e.message();
        at_key("file", "recorded.file", message)
    })?;
    let folder = file.folder_of(system::DEVICE, sets);
    link_device(&mut machine, folder.as_deref()).map_err(|e| at_key("device", "dram.device", e))?;
    let folder = file.folder_of(system::ENERGY, sets);
    let table = read("energy table", &machine.energy, ENERGY, folder.as_deref())
        .map_err(|e| energy(e.to_string()))?;
    let parsed = energy_table(&table, machine.clock)
        .map_err(|e| energy(format!("the energy table is wrong: {e}")))?;
    let prices = sim::cost::prices(&parsed, &machine);
    let prices = prices.map_err(|e| at_key(e.key(), e.key(), e.to_string()))?;
    let node = parsed.node.map_or(String::new(), |n| format!(", {n}"));
    let summary = format!("machine {}, energy table {}{node}", machine.name, parsed.name);
    Ok(Good { summary, cost: Some(Cost::new(&machine, &parsed, &prices)) })
}

/// A sweep is right when it spans a space. Its traces are not opened.
fn check_sweep(file: &ConfigText) -> Result<Good, ConfigError> {
    let (mut sweep, problems) = SweepFile::parse_around(&file.text)?;
    lies_in(&mut sweep, file.folder.as_deref());
    let space = Space::whole(&sweep, problems, Arc::new(DiskFiles))?;
    let points = space.lattice().points();
    Ok(format!("sweep of {}, a space of {points} points", sweep.base).into())
}

/// Reads a DRAM device that does not come with the program.
fn link_device(machine: &mut Machine, folder: Option<&Path>) -> Result<(), String> {
    if machine.device.is_some() || !machine.dram.has_device() {
        return Ok(());
    }
    let text =
        read("DRAM device", &machine.dram.device, DRAM, folder).map_err(|e| e.to_string())?;
    let device = Device::parse(&text.text).map_err(|e| format!("{}: {e}", text.origin))?;
    machine.link(&device).map_err(|(_, message)| message)
}

/// A reference table of Accelergy: the clock matters for its leakage only.
fn check_reference_table(file: &ConfigText) -> Result<Good, ConfigError> {
    let place = Place::of(&file.text, 0..0);
    let problem = |message| ConfigError::new(vec![Problem { place, key: String::new(), message }]);
    let table = energy_table(file, Hertz(1e9)).map_err(|e| {
        let message = e.to_string();
        let origin = format!("{}: ", file.origin);
        problem(message.strip_prefix(&origin).unwrap_or(&message).to_owned())
    })?;
    Ok(format!("energy reference table {}", table.name).into())
}

/// What a file is, by the tables that only one kind has.
pub fn kind_of(text: &str) -> Kind {
    let has = |start: &str| text.lines().any(|l| l.trim_start().starts_with(start));
    if ["[[axes]]", "[sampling]", "question"].iter().any(|t| has(t)) {
        return Kind::Sweep;
    }
    let machine = ["[geometry]", "[ccu]", "[gsu]", "[vru]", "[buffers"].iter().any(|t| has(t));
    let energy = ["[actions]", "[sram", "[leakage]", "[flop]"].iter().any(|t| has(t));
    if has("[organisation]") {
        return Kind::Dram;
    }
    if has("scenery") || has("[rig]") {
        return Kind::Synth;
    }
    match (machine, energy) {
        (false, true) => Kind::Energy,
        (false, false) if has("red") || has("scale") || has("static") => Kind::Display,
        _ => Kind::Machine,
    }
}

fn checked_json(checked: &Checked) -> Value {
    let problem = |p: &Problem| {
        let (line, column, set) = match &p.place {
            Place::File { line, column, .. } => (Some(line), Some(column), None),
            Place::Set(set) => (None, None, Some(set)),
        };
        json!({ "key": p.key, "line": line, "column": column, "set": set, "message": p.message })
    };
    let problems = checked.result.as_ref().err().map_or(&[][..], |e| &e.problems);
    json!({
        "file": checked.file.origin,
        "kind": checked.kind.name(),
        "ok": problems.is_empty(),
        "problems": problems.iter().map(problem).collect::<Vec<_>>(),
        "cost": checked.result.as_ref().ok().and_then(|good| good.cost.as_ref()).map(Cost::json),
    })
}
