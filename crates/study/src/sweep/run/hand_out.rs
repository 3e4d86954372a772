//! What a user takes along from a sweep: the commands that give the rows of a design again to the
//! last digit, and its machine file.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
use toml::Value;

use super::opened::MODEL;
use super::request::SweepRequest;
use super::traces::SweepTrace;
use crate::sweep::file::{Settings, SweepFile, ZipValues};
use crate::sweep::key::{Domain, FileKind, Key, MACHINE};
use powergs_base::config::knob;
use powergs_base::shell;
use powergs_core::run::{RunError, Store};

/// Its name in the folder of a sweep.
const FILE: &str = "hand-out.json";

/// Keys whose values may be paths.
const PATHS: [&str; 4] = [MACHINE, "energy", "dram.device", "recorded.file"];

/// What all designs of a sweep have in common, named as commands name it: paths are relative to the
/// folder where the sweep was run, or whole.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct HandOut {
    /// The words of the command of the sweep, but `--confirm`.
    pub sweep: Vec<String>,
    /// Whether designs were simulated with `calibrated` in place of their own model of the DRAM,
    /// without being asked.
    pub is_calibrated: bool,
    /// Whether rows have another model of the DRAM than the machine files of their designs.
    pub has_other_model: bool,
    /// The machine that designs differ from.
    pub base: String,
    /// Traces, in the order of the sweep.
    pub traces: Vec<HandedTrace>,
    /// The frames of each, as `--frames` takes them.
    frames: Option<String>,
    /// Energy tables; none where every machine has its own.
    tables: Vec<HandedTable>,
    display: Option<String>,
    display_fps: f64,
    /// Keys that every design has, with their values in TOML.
    set: Vec<[String; 2]>,
    /// What the values of axes with several keys mean: axis, value, keys.
    pub variants: BTreeMap<String, BTreeMap<String, Vec<[String; 2]>>>,
    /// Files in the folder of the sweep file: as keys name them, and where they are.
    places: BTreeMap<String, String>,
}

/// A trace of a sweep.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct HandedTrace {
    /// What the table calls it.
    pub label: String,
    /// Its file.
    pub path: String,
    /// Its weight in means.
    pub weight: f64,
}

/// An energy table of a sweep.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct HandedTable {
    label: String,
    table: String,
    set: Vec<[String; 2]>,
}

/// A design, as a row of the results has it.
#[derive(Debug, Clone, Default)]
pub struct HandedDesign<'a> {
    /// Its number; `None` for the base machine.
    pub point: Option<u64>,
    /// The columns of its axes, and of keys that follow from them, as the table has them.
    pub cells: Vec<(&'a str, &'a str)>,
}

/// Which rows of a design.
#[derive(Debug, Clone, Copy)]
pub struct HandedRow<'a> {
    /// Label of the energy table.
    pub table: &'a str,
    /// The model of the DRAM that made it; empty where that is not known.
    pub model: &'a str,
    /// Label of its trace; `None` for what is made of all traces.
    pub trace: Option<&'a str>,
}

/// What a design adds to the commands of its sweep, and its machine file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HandedWords {
    /// `--arch gscore --set vru.cores=8`.
    pub machine: Vec<String>,
    /// `--set dram:timing.burst=8`: what no machine file can say.
    pub others: Vec<String>,
    /// The machine file.
    pub file: String,
}

impl HandOut {
    /// Of a sweep that was asked for: `file` as the request changes it, in `folder`.
    pub(super) fn new(
        request: &SweepRequest,
        file: &SweepFile,
        folder: Option<&Path>,
        traces: &[SweepTrace<'_>],
        is_calibrated: bool,
    ) -> HandOut {
        let frames = request.frames.map(|(start, end)| {
            format!("{start}..{}", end.map_or(String::new(), |end| end.to_string()))
        });
        // The model is that of the rows, not of the machine: commands name it.
        let has_other_model = request.dram_model.is_some() || is_calibrated;
        let mut set = literals(&file.set);
        set.retain(|[key, _]| !has_other_model || key != MODEL);
        let place = |name: &str| placed(name, folder);
        let table = |spec: &crate::sweep::file::EnergySpec| HandedTable {
            label: spec.label.clone(),
            table: place(&spec.table),
            set: literals(&spec.set),
        };
        let trace = |trace: &SweepTrace<'_>| HandedTrace {
            label: trace.label.label.clone(),
            path: trace.place.clone().unwrap_or_else(|| trace.input.name.clone()),
            weight: trace.label.weight,
        };
        let named = names_of_files(file).into_iter().map(|name| (name.clone(), place(&name)));
        HandOut {
            sweep: words(request, frames.as_deref()),
            is_calibrated,
            has_other_model,
            base: place(&file.base),
            traces: traces.iter().map(trace).collect(),
            frames,
            tables: file.energy.iter().map(table).collect(),
            // A path on the command line is not one in the file.
            display: request.display.clone().or_else(|| file.display.as_deref().map(place)),
            display_fps: file.display_fps,
            set,
            variants: variants(file),
            places: named.filter(|(name, place)| name != place).collect(),
        }
    }

    /// That of a sweep in a folder; `None` where it says nothing of it.
    pub fn read(folder: &dyn Store) -> Option<HandOut> {
        serde_json::from_str(&folder.read_text(FILE).ok()??).ok()
    }

    /// Keeps it in the folder of its sweep.
    ///
    /// # Errors
    /// [`RunError::Output`]: the folder cannot be written.
    pub fn keep(&self, folder: &dyn Store) -> Result<(), RunError> {
        let text = serde_json::to_string_pretty(self);
        let text = text.map_err(|e| RunError::Internal(format!("{FILE}: {e}")))?;
        folder.write(FILE, (text + "\n").as_bytes())
    }

    /// The commands that give a row of a design: one, or of what is made of several traces one for
    /// each.
    pub fn commands(&self, design: &HandedDesign<'_>, row: HandedRow<'_>) -> Vec<Vec<String>> {
        let HandedWords { machine, others, .. } = self.design(design, row.table);
        let replays = self.replays(row).into_iter();
        replays.map(|replay| [replay, machine.clone(), others.clone()].concat()).collect()
    }

    /// The beginnings of the commands, before the words of a design: one for each trace.
    pub fn replays(&self, row: HandedRow<'_>) -> Vec<Vec<String>> {
        let traces = self.traces.iter().filter(|t| row.trace.is_none_or(|own| own == t.label));
        let replay = |trace: &HandedTrace| {
            // A path is no flag.
            let dash = if trace.path.starts_with('-') { "./" } else { "" };
            let mut words = vec!["powergs-sim".to_owned(), "replay".to_owned()];
            words.push(format!("{dash}{}", trace.path));
            let mut flag = |name: &str, value: String| words.extend([name.to_owned(), value]);
            self.frames.iter().for_each(|frames| flag("--frames", frames.clone()));
            flag("--fps", self.display_fps.to_string());
            self.display.iter().for_each(|display| flag("--display", display.clone()));
            if let Some(table) = self.table(row.table) {
                flag("--energy", table.table.clone());
                for [key, literal] in &table.set {
                    let prefix = FileKind::Energy.prefix();
                    let key = key.strip_prefix(prefix).unwrap_or(key);
                    let value = knob::written(literal);
                    flag("--set", set(&format!("{prefix}{key}"), &value));
                }
            }
            if !row.model.is_empty() {
                flag("--dram-model", row.model.to_owned());
            }
            words
        };
        traces.map(replay).collect()
    }

    /// What a design adds to them under an energy table.
    pub fn design(&self, design: &HandedDesign<'_>, table: &str) -> HandedWords {
        let settings = self.settings(design);
        let own = settings.iter().find(|(key, _)| key == MACHINE);
        let base = own.map_or_else(|| self.base.clone(), |(_, name)| knob::shown(name));
        let mut machine = vec!["--arch".to_owned(), base.clone()];
        let (mut others, mut lines) = (Vec::new(), Vec::new());
        let end = design.point.map_or("baseline".to_owned(), |point| point.to_string());
        lines.push(format!("base = {}", literal(&base)));
        lines.push(format!("name = {}", literal(&format!("{}-{end}", word_of(&stem(&base))))));
        let named = self.table(table).map(|table| table.table.as_str());
        lines.extend(named.map(|name| format!("energy = {}", literal(name))));
        for (key, value) in settings.iter().filter(|(key, _)| key != MACHINE) {
            let word = ["--set".to_owned(), set(key, value)];
            if key.contains([':', '[', '*']) {
                others.extend(word);
                continue;
            }
            // Every command names the model of its row.
            if key != MODEL {
                machine.extend(word);
            }
            // A table of the sweep comes before that of a key.
            if key != "energy" || named.is_none() {
                lines.push(format!("{} = {value}", path(key)));
            }
        }
        HandedWords { machine, others, file: lines.join("\n") + "\n" }
    }

    /// Lines above a machine file that say how it gives the rows of its design.
    pub fn head(&self, row: HandedRow<'_>, others: &[String]) -> Vec<String> {
        let file = ["--arch".to_owned(), "FILE".to_owned()];
        let replays = self.replays(row).into_iter();
        let words = replays.map(|replay| [replay, file.to_vec(), others.to_vec()].concat());
        // A comment ends with its line, and holds no other control characters either.
        let plain = |text: String| text.replace(char::is_control, " ");
        words.map(|words| plain(format!("# {}", shell::line(words)))).collect()
    }

    /// What the commands of a row are together; nothing where it is of one trace.
    pub fn together(&self, trace: Option<&str>) -> String {
        if trace.is_some() || self.traces.len() < 2 {
            return String::new();
        }
        let weights: Vec<String> = self.traces.iter().map(|t| t.weight.to_string()).collect();
        match self.traces.iter().all(|t| t.weight == self.traces[0].weight) {
            true => "One command a trace: the row is the mean over them, or the worst.".to_owned(),
            false => format!(
                "One command a trace: the row is the mean over them with the weights {}, or the \
                 worst.",
                weights.join(", ")
            ),
        }
    }

    fn table(&self, label: &str) -> Option<&HandedTable> {
        self.tables.iter().find(|table| table.label == label)
    }

    /// Keys with their values: what all designs have, then what this one has.
    fn settings(&self, design: &HandedDesign<'_>) -> Vec<(String, Value)> {
        let mut all: Vec<(String, Value)> = Vec::new();
        let mut put = |key: &str, value: Value| {
            let value = match value {
                Value::String(name) if PATHS.contains(&key) => {
                    Value::String(self.places.get(&name).cloned().unwrap_or(name))
                }
                value => value,
            };
            all.retain(|(known, _)| known != key);
            all.push((key.to_owned(), value));
        };
        let written = |[key, literal]: &[String; 2]| (key.clone(), knob::written(literal));
        for (key, value) in self.set.iter().map(written) {
            put(&key, value);
        }
        // `-` stands where an axis does not count.
        let cells = design.cells.iter().filter(|(_, text)| !["", "-"].contains(text));
        for (name, text) in cells {
            match self.variants.get(*name) {
                Some(values) => {
                    let keys = values.get(*text).into_iter().flatten();
                    keys.map(written).for_each(|(key, value)| put(&key, value));
                }
                None => put(name, of_text(name, text)),
            }
        }
        all
    }
}

/// The command of a sweep.
fn words(request: &SweepRequest, frames: Option<&str>) -> Vec<String> {
    let mut words = vec!["powergs-sim".to_owned(), "sweep".to_owned(), request.file.clone()];
    if !request.traces.is_empty() {
        words.push("--traces".to_owned());
        words.extend(request.traces.iter().cloned());
    }
    let mut flag = |name: &str, value: String| words.extend([name.to_owned(), value]);
    frames.iter().for_each(|frames| flag("--frames", (*frames).to_owned()));
    request.sets.iter().for_each(|set| flag("--set", set.clone()));
    request.points.iter().for_each(|points| flag("--points", points.to_string()));
    request.display_fps.iter().for_each(|fps| flag("--fps", fps.to_string()));
    request.display.iter().for_each(|display| flag("--display", display.clone()));
    request.dram_model.iter().for_each(|model| flag("--dram-model", model.clone()));
    words
}

/// A file in the folder of the sweep file, where it is; anything else as it is called.
fn placed(name: &str, folder: Option<&Path>) -> String {
    // Files that come with the program have no dot in their names.
    let is_path = name.contains(['/', '\\', '.']);
    let found = folder.map(|folder| folder.join(name)).filter(|path| is_path && path.is_file());
    found.map_or_else(|| name.to_owned(), |path| path.display().to_string())
}

/// Values of the keys that may be paths, anywhere in a sweep file.
fn names_of_files(file: &SweepFile) -> Vec<String> {
    let mut found: Vec<&Value> = Vec::new();
    let of_settings = |settings: &Settings| -> Vec<String> {
        let own = settings.0.iter().filter(|(key, _)| PATHS.contains(&key.as_str()));
        own.filter_map(|(_, value)| value.as_str().map(str::to_owned)).collect()
    };
    let mut names = of_settings(&file.set);
    for axis in &file.axes {
        for variant in axis.variants.iter().flatten() {
            names.extend(of_settings(&variant.set));
        }
        if axis.key.as_deref().is_some_and(|key| PATHS.contains(&key)) {
            found.extend(axis.values.iter().flatten().map(|raw| &raw.0));
        }
        let rows = axis.zip.iter().flat_map(|zip| &zip.0);
        for (_, values) in rows.filter(|(key, _)| PATHS.contains(&key.as_str())) {
            match values {
                ZipValues::List(values) => found.extend(values),
                ZipValues::Range(_) => {}
            }
        }
    }
    names.extend(found.into_iter().filter_map(|value| value.as_str().map(str::to_owned)));
    names
}

/// What the values of axes with variants mean.
fn variants(file: &SweepFile) -> BTreeMap<String, BTreeMap<String, Vec<[String; 2]>>> {
    let of = |axis: &crate::sweep::file::AxisSpec| {
        let all = axis.variants.as_ref()?.iter().map(|v| (v.name.clone(), literals(&v.set)));
        Some((axis.name.clone()?, all.collect()))
    };
    file.axes.iter().filter_map(of).collect()
}

/// Keys with their values in TOML.
fn literals(settings: &Settings) -> Vec<[String; 2]> {
    settings.0.iter().map(|(key, value)| [key.clone(), value.to_string()]).collect()
}

/// The value that a cell of the table shows.
fn of_text(key: &str, text: &str) -> Value {
    // A table in CSV has an apostrophe before what a spreadsheet would take for a formula.
    let is_formula = |rest: &&str| rest.starts_with(['=', '+', '-', '@', '\t', '\r']);
    let text = text.strip_prefix('\'').filter(is_formula).unwrap_or(text);
    match Key::known(key).map(|(_, domain)| domain) {
        // Whatever it looks like: a file may be called `8`.
        Some(Domain::Text | Domain::Choice(_) | Domain::Measure(_) | Domain::Part) => text.into(),
        Some(Domain::Number(..)) => text.parse().map_or_else(|_| knob::written(text), Value::Float),
        Some(Domain::Integer(..) | Domain::Truth | Domain::List) | None => knob::written(text),
    }
}

/// `vru.cores=8`: without quotes where the value is understood without them.
fn set(key: &str, value: &Value) -> String {
    let plain = knob::shown(value);
    match knob::written(&plain) == *value {
        true => format!("{key}={plain}"),
        false => format!("{key}={value}"),
    }
}

/// A text in TOML.
fn literal(text: &str) -> Value {
    Value::String(text.to_owned())
}

/// A dotted path in TOML.
fn path(key: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    let part = |part: &str| match !part.is_empty() && part.chars().all(is_bare) {
        true => part.to_owned(),
        false => literal(part).to_string(),
    };
    key.split('.').map(part).collect::<Vec<_>>().join(".")
}

/// A name as machines may have it: what is no letter, digit, `-`, `_` or `.` becomes `-`.
fn word_of(name: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    name.chars().map(|c| if is_plain(c) { c } else { '-' }).collect()
}

/// What a machine is called: the name of its file without folder and ending.
fn stem(machine: &str) -> String {
    Path::new(machine).file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}
