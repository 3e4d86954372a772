//! What can stand at a place of the command line, beyond what its definition says: names of files
//! that come with the program, keys, columns, statistics.

use std::ffi::OsStr;

use clap::{Arg, Command};
use clap_complete::engine::{
    ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter,
};

use serde_json::Value;

use crate::cli::{compare, explain};
use powergs_base::config::assumptions::assumptions;
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, SWEEPS, SYNTH};
use powergs_base::config::schema::{choices, leaves};
use powergs_base::config::{Embedded, KeyDoc, key_docs, schema_of};
use powergs_chart::Sheet;
use powergs_core::flow;
use powergs_core::machine::Machine;
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use powergs_study::sweep::table::columns;

/// `command` with completers for the arguments that name something.
pub fn known(command: Command) -> Command {
    with_values("", command)
}

fn with_values(parents: &str, command: Command) -> Command {
    let path = format!("{parents} {}", command.get_name());
    let subcommands: Vec<String> =
        command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let within = if parents.is_empty() { " ".to_owned() } else { path.clone() };
    let mut command = command.mut_args(|arg| match values(path.trim(), &arg) {
        Some(completer) => arg.add(completer),
        None => arg,
    });
    for name in subcommands {
        command = command.mut_subcommand(name, |c| with_values(&within, c));
    }
    command
}

/// The completer of an argument of the command at `path`, without the program's name.
fn values(path: &str, arg: &Arg) -> Option<ArgValueCompleter> {
    let all = || [MACHINES, ENERGY, DISPLAYS, DRAM, SWEEPS, SYNTH].concat();
    Some(match (path, arg.get_id().as_str()) {
        ("arch show" | "arch check" | "arch diff", "arch" | "files" | "a" | "b") => {
            names(all(), &["toml", "yaml"])
        }
        (_, "arch" | "train_on") => names(MACHINES.to_vec(), &["toml"]),
        ("compare", "items") => names(MACHINES.to_vec(), &[]),
        ("compare", "workloads") => list(compare::workload_names),
        ("render", "order") => list(|| values_of("gsu.impl")),
        ("render", "pixels") => list(|| values_of("pixels.impl")),
        (_, "energy") => names(ENERGY.to_vec(), &["toml", "yaml", "yml"]),
        ("synth", "preset") => names(SYNTH.to_vec(), &["toml"]),
        (_, "display" | "preset") => names(DISPLAYS.to_vec(), &["toml"]),
        (_, "device") => names(DRAM.to_vec(), &["toml"]),
        ("sweep", "file") => names(SWEEPS.to_vec(), &["toml"]),
        ("dram", "sets") => ArgValueCompleter::new(ValueSettings(of_devices)),
        (_, "sets") => ArgValueCompleter::new(ValueSettings(of_machines)),
        ("sensitivity", "keys") => list(every_key),
        ("sensitivity", "only") => list(numbers),
        ("pareto", "minimize" | "maximize" | "colour") => list(results),
        (_, "chart_size") => list(chart_sizes),
        ("explain", "name") => list(explain::names),
        _ => return None,
    })
}

/// The values of a key of machines.
fn values_of(path: &str) -> Vec<Described> {
    let docs = key_docs::<Machine>().into_iter().find(|doc| doc.path == path);
    let choices = docs.map(|doc| doc.choices()).unwrap_or_default();
    choices.into_iter().map(|choice| (choice, String::new())).collect()
}

/// Named sizes of charts, and a width as an example of those that are written as numbers.
fn chart_sizes() -> Vec<Described> {
    let named = Sheet::ALL.map(|sheet| (sheet.to_string(), format!("{:.2} in", sheet.inches())));
    named.into_iter().chain([("3.5in".to_owned(), "any width".to_owned())]).collect()
}

/// A value and what it says.
type Described = (String, String);

fn candidate((value, help): Described) -> CompletionCandidate {
    let help = help.lines().next().unwrap_or_default().to_owned();
    CompletionCandidate::new(value).help((!help.is_empty()).then(|| help.into()))
}

fn begins(current: &OsStr, (value, _): &Described) -> bool {
    current.to_str().is_some_and(|typed| value.starts_with(typed))
}

/// One of a list.
fn list(values: fn() -> Vec<Described>) -> ArgValueCompleter {
    ArgValueCompleter::new(move |current: &OsStr| {
        values().into_iter().filter(|v| begins(current, v)).map(candidate).collect::<Vec<_>>()
    })
}

/// The names of `files`, or files with one of these endings; any file where there are none.
fn names(files: Vec<Embedded>, endings: &'static [&'static str]) -> ArgValueCompleter {
    ArgValueCompleter::new(move |current: &OsStr| {
        let known = files.iter().map(|file| (file.name.to_owned(), says(file)));
        let known = known.filter(|v| begins(current, v)).map(candidate);
        let ending = |path: &std::path::Path| {
            let ending = path.extension().and_then(OsStr::to_str);
            endings.is_empty() || ending.is_some_and(|e| endings.contains(&e))
        };
        known.chain(PathCompleter::any().filter(ending).complete(current)).collect::<Vec<_>>()
    })
}

/// The description of a file, or the question of a sweep.
fn says(file: &Embedded) -> String {
    let table: toml::Table = file.text.parse().unwrap_or_default();
    let text = table.get("description").or_else(|| table.get("question"));
    text.and_then(toml::Value::as_str).unwrap_or_default().to_owned()
}

/// Keys with what can be assigned to them, and what they mean.
type Assignments = Vec<(KeyDoc, Vec<String>)>;

/// `KEY=VALUE`.
struct ValueSettings(fn() -> Assignments);

impl ValueCompleter for ValueSettings {
    fn complete(&self, current: &OsStr) -> Vec<CompletionCandidate> {
        let typed = current.to_str().unwrap_or_default();
        let keys = (self.0)().into_iter();
        let offered: Vec<Described> = match typed.split_once('=') {
            None => keys.map(|(doc, _)| (format!("{}=", doc.path), doc.definition)).collect(),
            Some((key, _)) => {
                let values = keys.filter(|(doc, _)| doc.path == key).flat_map(|(_, values)| values);
                values.map(|value| (format!("{key}={value}"), String::new())).collect()
            }
        };
        offered.into_iter().filter(|v| begins(current, v)).map(candidate).collect()
    }
}

fn settings(docs: Vec<KeyDoc>, schema: &Value) -> Assignments {
    let leaves = leaves(schema);
    let values = |path: &str| -> Vec<String> {
        let names = |files: &[Embedded]| files.iter().map(|f| f.name.to_owned()).collect();
        match (path, leaves.iter().find(|(leaf, _)| leaf == path)) {
            ("energy", _) => names(ENERGY),
            ("dram.device", _) => names(DRAM),
            (_, Some((_, leaf))) if leaf["type"] == "boolean" => {
                ["true", "false"].map(str::to_owned).to_vec()
            }
            (_, Some((_, leaf))) => choices(leaf).into_iter().map(str::to_owned).collect(),
            (_, None) => Vec::new(),
        }
    };
    let single = |doc: &KeyDoc| !doc.table && !doc.path.contains(['*', '[']);
    let docs = docs.into_iter().filter(single);
    docs.map(|doc| {
        let values = values(&doc.path);
        (doc, values)
    })
    .collect()
}

fn of_machines() -> Assignments {
    settings(key_docs::<Machine>(), &schema_of::<Machine>())
}

fn of_devices() -> Assignments {
    settings(key_docs::<Device>(), &schema_of::<Device>())
}

fn of_tables() -> Assignments {
    settings(key_docs::<EnergyTable>(), &schema_of::<EnergyTable>())
}

fn every_key() -> Vec<Described> {
    let keys = of_machines().into_iter().chain(of_tables()).chain(of_devices());
    keys.map(|(doc, _)| (doc.path, doc.definition)).collect()
}

fn numbers() -> Vec<Described> {
    assumptions().iter().map(|(number, a)| (format!("A{number}"), a.text.clone())).collect()
}

fn results() -> Vec<Described> {
    columns(&[], flow::DEFAULT).into_iter().map(|column| (column.name, String::new())).collect()
}
