//! `arch`: lists, shows and checks machine files, energy tables, display presets, DRAM devices,
//! sweeps and presets of synthetic scenes.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::chart_args::{self, ChartArgs};
use super::failure::ConfigUsage;
use super::output_file::{self, Overwrite};
use super::{Context, Exit, Failure, inputs, out};
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, SWEEPS, SYNTH};
use powergs_base::config::schema::schema_with_base;
use powergs_base::config::{ConfigError, Embedded, key_docs, knob, layer, schema_of};
use powergs_chart::Format;
use powergs_core::machine::Machine;
use powergs_core::run::ConfigText;
use powergs_core::run::RunError;
use powergs_core::run::files::{is_yaml, raw, read};
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use powergs_frame::display::Display;
use powergs_report::document::{Cell, Column, Document, Shown, Table};
use powergs_report::machine;
use powergs_report::schema::schema as report_schema;
use powergs_scene::synth::Preset;
use powergs_study::sweep::file::SweepFile;

use check::kind_of;
use cost::Cost;

mod check;
mod cost;
mod diff;

pub use diff::differences;

/// Shown under `arch --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim arch list
  powergs-sim arch show gscore > mine.toml
  powergs-sim arch show gscore --set vru.cores=8 --set clock=800MHz
  powergs-sim arch show neo --resolved
  powergs-sim arch show gscore --figure -o gscore.svg
  powergs-sim arch diff gscore neo
  powergs-sim arch check mine.toml
  powergs-sim arch schema machine > machine.json

A first line `#:schema machine.json` in a TOML file gives editors completion.
powergs-sim explain KEY defines every key.";

/// Arguments of `arch`.
#[derive(Debug, clap::Args)]
pub struct ArchArgs {
    /// What to do
    #[command(subcommand)]
    pub verb: Verb,
}

/// What `arch` does.
#[derive(Debug, clap::Subcommand)]
pub enum Verb {
    /// List the machines, tables, displays, DRAM devices, sweeps and synthetic scenes that come
    /// with the program
    List,
    /// Print a file; with --resolved all of its keys, with --set as a run would use it
    Show {
        /// Machine: a name of `arch list`, or a TOML file
        #[arg(value_name = "NAME|FILE")]
        arch: String,
        /// Change a key; may be repeated
        #[arg(long = "set", value_name = "KEY=VALUE")]
        sets: Vec<String>,
        /// Every key, also those that its base has, with the comments of the files
        #[arg(long)]
        resolved: bool,
        /// Area and peak power of its blocks instead of the file
        #[arg(long, conflicts_with = "resolved")]
        cost: bool,
        /// A block diagram instead of the file: units, buffers, reads and writes, DRAM
        #[arg(long, conflicts_with_all = ["resolved", "cost"])]
        figure: bool,
        /// Where the diagram goes: a .svg, .png or .pdf file [default: NAME.svg]
        #[arg(long, short, value_name = "FILE", requires = "figure")]
        output: Option<PathBuf>,
        /// Whether it is replaced.
        #[command(flatten)]
        overwrite: Overwrite,
        /// How it is drawn.
        #[command(flatten)]
        charts: ChartArgs,
    },
    /// Print the keys in which two files of one kind differ
    Diff {
        /// A name of `arch list`, or a TOML file
        #[arg(value_name = "A")]
        a: String,
        /// Another of the same kind
        #[arg(value_name = "B")]
        b: String,
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
        /// That of what `replay --json` prints instead
        #[arg(long, conflicts_with = "kind")]
        report: bool,
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
    /// A sweep.
    Sweep,
    /// A preset of synthetic scenes.
    Synth,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 6] =
        [Kind::Machine, Kind::Energy, Kind::Display, Kind::Dram, Kind::Sweep, Kind::Synth];

    /// Its name on the command line and in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Machine => "machine",
            Kind::Energy => "energy",
            Kind::Display => "display",
            Kind::Dram => "dram",
            Kind::Sweep => "sweep",
            Kind::Synth => "synth",
        }
    }

    /// Those that come with the program.
    pub const fn files(self) -> &'static [Embedded] {
        match self {
            Kind::Machine => MACHINES,
            Kind::Energy => ENERGY,
            Kind::Display => DISPLAYS,
            Kind::Dram => DRAM,
            Kind::Sweep => SWEEPS,
            Kind::Synth => SYNTH,
        }
    }

    /// Its JSON schema.
    pub fn schema(self) -> Value {
        match self {
            Kind::Machine => schema_with_base::<Machine>(),
            Kind::Energy => schema_with_base::<EnergyTable>(),
            Kind::Display => schema_with_base::<Display>(),
            Kind::Dram => schema_with_base::<Device>(),
            Kind::Sweep => schema_of::<SweepFile>(),
            Kind::Synth => schema_with_base::<Preset>(),
        }
    }
}

/// Runs `arch`.
pub fn run(args: &ArchArgs, context: &Context) -> Result<Exit, Failure> {
    match &args.verb {
        Verb::List => list(context),
        Verb::Show { arch, sets, cost: true, .. } => show_cost(arch, sets, context),
        Verb::Show { arch, sets, figure: true, output, overwrite, charts, .. } => {
            let default = || {
                let stem = Path::new(arch).file_stem().unwrap_or_default();
                Path::new(stem).with_extension(Format::Svg.ending())
            };
            let path = output.clone().unwrap_or_else(default);
            overwrite.check(&path)?;
            let system = inputs::system(arch, sets, None)?;
            chart_args::write(&path, &machine::chart(system.machine()), charts.style())?;
            output_file::say(&path, format!("diagram of {}", system.machine().name), context)?;
            Ok(Exit::Done)
        }
        Verb::Show { arch, sets, resolved, .. } => show(arch, sets, *resolved, context),
        Verb::Diff { a, b } => diff::run(a, b, context),
        Verb::Check { files, sets } => check::run(files, sets, context),
        Verb::Schema { report: true, .. } => out::json(&report_schema()).map(|()| Exit::Done),
        Verb::Schema { kind, .. } => out::json(&kind.schema()).map(|()| Exit::Done),
    }
}

fn list(context: &Context) -> Result<Exit, Failure> {
    let mut rows = Vec::new();
    for kind in Kind::ALL {
        for file in kind.files() {
            rows.push(describe(kind, file)?);
        }
    }
    let table = |kind: Option<Kind>| {
        let columns = ["kind", "name", "node", "description"].map(Column::text);
        let [kinds, name, mut node, description] = columns;
        let of_kind = rows.iter().filter(|r| kind.is_none_or(|kind| r.kind == kind));
        if of_kind.clone().all(|r| r.node.is_none()) {
            node = node.on(Shown::Page);
        }
        let description = description.wraps();
        Table::new([kinds.on(Shown::Page), name, node, description]).rows(of_kind.map(|r| {
            let (kind, name) = (r.kind.name(), r.name);
            [kind.into(), name.into(), Cell::from(r.node.clone()), r.description.as_str().into()]
        }))
    };
    if context.global.json {
        return out::json(&table(None).json()).map(|()| Exit::Done);
    }
    let mut page = Document::new();
    for kind in Kind::ALL {
        page.heading(match kind {
            Kind::Machine => "Machines (--arch NAME)",
            Kind::Energy => "Energy tables (key `energy` of a machine)",
            Kind::Display => "Displays (--display NAME)",
            Kind::Dram => "DRAM devices (dram --device NAME)",
            Kind::Sweep => "Sweeps (sweep NAME)",
            Kind::Synth => "Synthetic scenes (synth NAME)",
        });
        page.table(table(Some(kind)));
    }
    out::document(&page).map(|()| Exit::Done)
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
            let system = inputs::system(file.name, &[], None)?;
            let node = system.energy_table().node.map(|n| n.to_string());
            (node, system.machine().description.clone())
        }
        Kind::Energy => {
            let table = EnergyTable::parse(file.text).map_err(wrong)?;
            (table.node.map(|n| n.to_string()), table.description)
        }
        Kind::Display => (None, Display::parse(file.text).map_err(wrong)?.description),
        Kind::Dram => (None, Device::parse(file.text).map_err(wrong)?.description),
        Kind::Sweep => (None, SweepFile::parse(file.text).map_err(wrong)?.question),
        Kind::Synth => (None, Preset::parse(file.text).map_err(wrong)?.description),
    };
    Ok(Row { kind, name: file.name, node, description })
}

/// A file by name or path, with all of its base, and what it is.
///
/// # Errors
/// As [`read`].
fn open(name: &str) -> Result<(ConfigText, Kind), RunError> {
    let all = |kinds: &[Kind]| -> Vec<Embedded> {
        kinds.iter().flat_map(|kind| kind.files()).copied().collect()
    };
    let file = raw("configuration file", name, &all(&Kind::ALL), None)?;
    if is_yaml(&file.origin) {
        return Ok((file, Kind::Energy));
    }
    // The base of a sweep is a machine.
    if kind_of(&file.text) == Kind::Sweep {
        return Ok((file, Kind::Sweep));
    }
    let others: Vec<Kind> = Kind::ALL.into_iter().filter(|kind| *kind != Kind::Sweep).collect();
    let whole = read("configuration file", name, &all(&others), None)?;
    let kind = kind_of(&whole.text);
    // Only a file of the same kind can be a base.
    Ok((read(kind.name(), name, kind.files(), None)?, kind))
}

fn show(arch: &str, sets: &[String], resolved: bool, context: &Context) -> Result<Exit, Failure> {
    let (file, kind) = open(arch)?;
    let as_written = sets.is_empty() && !resolved;
    if sets.is_empty() && !context.global.json && (as_written || kind != Kind::Sweep) {
        let text = match (resolved, kind) {
            (false, _) => file.own().into(),
            (true, Kind::Machine) => {
                let machine = Machine::parse(&file.text).usage(&file.origin)?;
                whole(&file.text, &machine)
            }
            (true, _) => layer::without_places(&file.text),
        };
        return out::text(&for_a_copy(&text)).map(|()| Exit::Done);
    }
    if kind == Kind::Sweep {
        let what = "is a sweep: its designs are shown with `sweep show`";
        return Err(Failure::new(Exit::Usage, format!("{}: {what}", file.origin)));
    }
    if kind == Kind::Synth {
        if !sets.is_empty() {
            let what = "is a preset of scenes, which has no --set: copy the file";
            return Err(Failure::new(Exit::Usage, format!("{}: {what}", file.origin)));
        }
        let preset = Preset::parse(&file.text).usage(&file.origin)?;
        let json = context.global.json;
        let shown = if json { out::json(&preset) } else { out::text(&for_a_copy(&file.text)) };
        return shown.map(|()| Exit::Done);
    }
    if kind == Kind::Dram {
        let device = Device::parse_with(&file.text, sets).usage(&file.origin)?;
        let json = context.global.json;
        let shown = if json { out::json(&device) } else { out::text(&device.to_toml()) };
        return shown.map(|()| Exit::Done);
    }
    let system = inputs::system(arch, sets, None)?;
    if context.global.json {
        return out::json(&system.machine().stated()).map(|()| Exit::Done);
    }
    out::text(&system.machine_toml()).map(|()| Exit::Done)
}

/// A machine file with every key that has an effect: those of its bases, with their comments, and
/// what a part has where no file says it.
fn whole(text: &str, machine: &Machine) -> String {
    let text = layer::without(text, |key| machine.leaves_out(key));
    let said: toml::Table = text.parse().unwrap_or_default();
    let stated = machine.stated();
    let unsaid = key_docs::<Machine>().into_iter().filter_map(|key| {
        let value = knob::values(&stated, &key.path).pop().filter(|_| !key.table)?;
        let is_said = !knob::values(&said, &key.path).is_empty();
        (!is_said).then(|| format!("{} = {value}  # where no file says it\n", key.path))
    });
    layer::plus(&text, &unsaid.collect::<String>())
}

/// A file as it is copied out of the program: its first line names a schema that a copy does not
/// have beside it, and says instead how to get one.
fn for_a_copy(text: &str) -> String {
    let schema = text.strip_prefix("#:schema ../schema/").and_then(|rest| rest.split_once('\n'));
    let Some((name, rest)) = schema else { return text.to_owned() };
    let kind = name.trim_end_matches(".json");
    format!(
        "# For completion in editors: `powergs-sim arch schema {kind} > {name}`, and a first line \
         `#:schema {name}`.\n{rest}"
    )
}

fn show_cost(arch: &str, sets: &[String], context: &Context) -> Result<Exit, Failure> {
    let system = inputs::system(arch, sets, None)?;
    let cost = Cost::new(system.machine(), system.energy_table(), system.prices());
    let json = context.global.json;
    let shown = if json { out::json(&cost.json()) } else { out::document(&cost.document()) };
    shown.map(|()| Exit::Done)
}
