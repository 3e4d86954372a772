//! `arch`: lists, shows and checks machine files, energy tables, display presets and DRAM devices.

use serde_json::{Value, json};

use super::machine_file::{ConfigUsage, Text, energy_table, is_yaml, load_machine, read};
use super::{Context, Exit, Failure, out};
use crate::accel::Machine;
use crate::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES};
use crate::config::error::Place;
use crate::config::{ConfigError, Embedded, Problem, schema_of};
use crate::display::Display;
use crate::dram::Device;
use crate::energy::EnergyTable;
use crate::quantity::Hertz;
use crate::sim;

use cost::Cost;

mod cost;

/// Shown under `arch --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim arch list
  powergs-sim arch show gscore > mine.toml
  powergs-sim arch show gscore --set vru.cores=8 --set clock=800MHz
  powergs-sim arch check mine.toml
  powergs-sim arch schema machine > machine.json

A first line `#:schema machine.json` in a TOML file gives editors completion.
powergs-sim explain KEY defines every key.";

/// Arguments of `arch`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What to do
    #[command(subcommand)]
    pub verb: Verb,
}

/// What `arch` does.
#[derive(Debug, clap::Subcommand)]
pub enum Verb {
    /// List the machines, energy tables, displays and DRAM devices that come with the program
    List,
    /// Print a machine file; with --set or --resolved, as a run would use it
    Show {
        /// Machine: a name of `arch list`, or a TOML file
        #[arg(value_name = "NAME|FILE")]
        arch: String,
        /// Change a key; may be repeated
        #[arg(long = "set", value_name = "KEY=VALUE")]
        sets: Vec<String>,
        /// Every key in the order of the documentation, without comments
        #[arg(long)]
        resolved: bool,
        /// Area and peak power of its blocks instead of the file
        #[arg(long, conflicts_with = "resolved")]
        cost: bool,
    },
    /// Check files and report everything that is wrong; exit code 2 if anything is
    Check {
        /// Names of `arch list`, or TOML files of any kind
        #[arg(value_name = "NAME|FILE", required = true)]
        files: Vec<String>,
        /// Change a key of the machine files and DRAM devices; may be repeated
        #[arg(long = "set", value_name = "KEY=VALUE")]
        sets: Vec<String>,
    },
    /// Print the JSON schema of a kind of file
    Schema {
        /// The kind of file
        #[arg(value_enum, default_value = "machine")]
        kind: Kind,
    },
}

/// Kinds of configuration files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Kind {
    /// A machine.
    Machine,
    /// An energy table.
    Energy,
    /// A display preset.
    Display,
    /// A DRAM device.
    Dram,
}

impl Kind {
    const ALL: [Kind; 4] = [Kind::Machine, Kind::Energy, Kind::Display, Kind::Dram];

    /// Its name on the command line and in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Machine => "machine",
            Kind::Energy => "energy",
            Kind::Display => "display",
            Kind::Dram => "dram",
        }
    }

    const fn files(self) -> &'static [Embedded] {
        match self {
            Kind::Machine => MACHINES,
            Kind::Energy => ENERGY,
            Kind::Display => DISPLAYS,
            Kind::Dram => DRAM,
        }
    }

    /// Its JSON schema.
    pub fn schema(self) -> Value {
        match self {
            Kind::Machine => schema_of::<Machine>(),
            Kind::Energy => schema_of::<EnergyTable>(),
            Kind::Display => schema_of::<Display>(),
            Kind::Dram => schema_of::<Device>(),
        }
    }
}

/// Runs `arch`.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    match &args.verb {
        Verb::List => list(context),
        Verb::Show { arch, sets, cost: true, .. } => show_cost(arch, sets, context),
        Verb::Show { arch, sets, resolved, .. } => show(arch, sets, *resolved, context),
        Verb::Check { files, sets } => check(files, sets, context),
        Verb::Schema { kind } => out::json(&kind.schema()).map(|()| Exit::Done),
    }
}

fn list(context: &Context) -> Result<Exit, Failure> {
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        for file in kind.files() {
            rows.push(describe(kind, file)?);
        }
    }
    if context.global.json {
        let row = |r: &Row| {
            json!({ "kind": r.kind.name(), "name": r.name, "node": r.node,
            "description": r.description })
        };
        return out::json(&rows.iter().map(row).collect::<Vec<_>>()).map(|()| Exit::Done);
    }
    let mut text = String::new();
    for kind in Kind::ALL {
        let title = match kind {
            Kind::Machine => "Machines (--arch NAME)",
            Kind::Energy => "Energy tables (key `energy` of a machine)",
            Kind::Display => "Displays (--display NAME)",
            Kind::Dram => "DRAM devices (dram --device NAME)",
        };
        text.push_str(&format!("{title}\n"));
        let of_kind = || rows.iter().filter(|r| r.kind == kind);
        let width = of_kind().map(|r| r.name.len()).max().unwrap_or(0);
        for row in of_kind() {
            let (name, node) = (row.name, row.node.as_deref().unwrap_or(""));
            text.push_str(&format!("  {name:width$}  {node:5}  {}\n", row.description));
        }
    }
    out::text(&text).map(|()| Exit::Done)
}

struct Row {
    kind: Kind,
    name: &'static str,
    node: Option<String>,
    description: String,
}

fn describe(kind: Kind, file: &Embedded) -> Result<Row, Failure> {
    let wrong = |e: ConfigError| Failure::new(Exit::Internal, format!("{}: {e}", file.name));
    let (node, description) = match kind {
        Kind::Machine => {
            let loaded = load_machine(file.name, &[])?;
            (loaded.energy_table.node.map(|n| n.to_string()), loaded.machine.description)
        }
        Kind::Energy => {
            let table = EnergyTable::parse(file.text).map_err(wrong)?;
            (table.node.map(|n| n.to_string()), table.description)
        }
        Kind::Display => (None, Display::parse(file.text).map_err(wrong)?.description),
        Kind::Dram => (None, Device::parse(file.text).map_err(wrong)?.description),
    };
    Ok(Row { kind, name: file.name, node, description })
}

fn show(arch: &str, sets: &[String], resolved: bool, context: &Context) -> Result<Exit, Failure> {
    let all: Vec<Embedded> = Kind::ALL.iter().flat_map(|k| k.files()).copied().collect();
    let file = read("machine", arch, &all, None)?;
    if !resolved && sets.is_empty() && !context.global.json {
        return out::text(&file.text).map(|()| Exit::Done);
    }
    if kind_of(&file.text) == Kind::Dram {
        let device = Device::parse_with(&file.text, sets).usage(&file.origin)?;
        let json = context.global.json;
        let shown = if json { out::json(&device) } else { out::text(&device.to_toml()) };
        return shown.map(|()| Exit::Done);
    }
    let loaded = load_machine(arch, sets)?;
    if context.global.json {
        return out::json(&loaded.machine).map(|()| Exit::Done);
    }
    out::text(&loaded.resolved_toml).map(|()| Exit::Done)
}

fn show_cost(arch: &str, sets: &[String], context: &Context) -> Result<Exit, Failure> {
    let loaded = load_machine(arch, sets)?;
    let cost = Cost::new(&loaded.machine, &loaded.prices);
    let json = context.global.json;
    let shown = if json { out::json(&cost.json()) } else { out::text(&cost.text()) };
    shown.map(|()| Exit::Done)
}

/// What `check` found in one file.
struct Checked {
    file: Text,
    kind: Kind,
    result: Result<Good, Vec<Problem>>,
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

fn check(files: &[String], sets: &[String], context: &Context) -> Result<Exit, Failure> {
    let all: Vec<Embedded> = Kind::ALL.iter().flat_map(|k| k.files()).copied().collect();
    let mut checked = Vec::new();
    let mut unread = false;
    for name in files {
        match read("configuration file", name, &all, None) {
            Ok(file) => checked.push(check_one(file, sets)),
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
                let cost = good.cost.as_ref().map_or(String::new(), Cost::text);
                out::text(&format!("{origin}: ok ({})\n{cost}", good.summary))?;
            }
            Ok(_) => {}
            Err(problems) => {
                let error = ConfigError { problems: problems.clone() };
                out::complain(format_args!("error: {origin}: {error}"));
            }
        }
    }
    let good = !unread && checked.iter().all(|c| c.result.is_ok());
    Ok(if good { Exit::Done } else { Exit::Usage })
}

fn check_one(file: Text, sets: &[String]) -> Checked {
    let kind = if is_yaml(&file.origin) { Kind::Energy } else { kind_of(&file.text) };
    let result = match kind {
        Kind::Machine => check_machine(&file, sets),
        Kind::Energy if is_yaml(&file.origin) => check_reference_table(&file),
        Kind::Energy => EnergyTable::parse(&file.text)
            .map(|t| format!("energy table {}", t.name).into())
            .map_err(|e| e.problems),
        Kind::Display => Display::parse(&file.text)
            .map(|d| format!("display preset {}", d.name).into())
            .map_err(|e| e.problems),
        Kind::Dram => Device::parse_with(&file.text, sets)
            .map(|d| format!("DRAM device {}", d.name).into())
            .map_err(|e| e.problems),
    };
    Checked { file, kind, result }
}

/// A machine is right when its energy table can be found and has a price for its buffers, too.
fn check_machine(file: &Text, sets: &[String]) -> Result<Good, Vec<Problem>> {
    let mut machine = Machine::parse_with(&file.text, sets).map_err(|e| e.problems)?;
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
        vec![Problem { place: set.map_or(in_file, Place::Set), key: path.into(), message }]
    };
    let energy = |message: String| at_key("energy", "energy", message);
    link_device(&mut machine, file).map_err(|e| at_key("device", "dram.device", e))?;
    let table = read("energy table", &machine.energy, ENERGY, file.folder.as_deref())
        .map_err(|e| energy(e.to_string()))?;
    let (parsed, _) = energy_table(&table, machine.clock)
        .map_err(|e| energy(format!("the energy table is wrong: {e}")))?;
    let prices = sim::cost::prices(&parsed, &machine);
    let prices = prices.map_err(|e| energy(e.to_string()))?;
    let node = parsed.node.map_or(String::new(), |n| format!(", {n}"));
    let summary = format!("machine {}, energy table {}{node}", machine.name, parsed.name);
    Ok(Good { summary, cost: Some(Cost::new(&machine, &prices)) })
}

/// Reads a DRAM device that does not come with the program.
fn link_device(machine: &mut Machine, file: &Text) -> Result<(), String> {
    if machine.device.is_some() {
        return Ok(());
    }
    let text = read("DRAM device", &machine.dram.device, DRAM, file.folder.as_deref())
        .map_err(|e| e.to_string())?;
    let device = Device::parse(&text.text).map_err(|e| format!("{}: {e}", text.origin))?;
    machine.link(&device).map_err(|(_, message)| message)
}

/// A reference table of Accelergy: the clock matters for its leakage only.
fn check_reference_table(file: &Text) -> Result<Good, Vec<Problem>> {
    let place = Place::of(&file.text, 0..0);
    let problem = |message| vec![Problem { place, key: String::new(), message }];
    let (table, _) = energy_table(file, Hertz(1e9)).map_err(|e| {
        let message = e.to_string();
        let origin = format!("{}: ", file.origin);
        problem(message.strip_prefix(&origin).unwrap_or(&message).to_owned())
    })?;
    Ok(format!("energy reference table {}", table.name).into())
}

/// What a file is, by the tables that only one kind has.
fn kind_of(text: &str) -> Kind {
    let has = |start: &str| text.lines().any(|l| l.trim_start().starts_with(start));
    let machine = ["[geometry]", "[ccu]", "[gsu]", "[vru]", "[buffers"].iter().any(|t| has(t));
    let energy = ["[actions]", "[sram", "[leakage]", "[flop]"].iter().any(|t| has(t));
    if has("[organisation]") {
        return Kind::Dram;
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
    let problems = checked.result.as_ref().err().map_or(&[][..], Vec::as_slice);
    json!({
        "file": checked.file.origin,
        "kind": checked.kind.name(),
        "ok": problems.is_empty(),
        "problems": problems.iter().map(problem).collect::<Vec<_>>(),
        "cost": checked.result.as_ref().ok().and_then(|good| good.cost.as_ref()).map(Cost::json),
    })
}
