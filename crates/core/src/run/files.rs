//! Configuration files: those that come with the program, by name, and any others, by path.
//!
//! One rule for every path: a file that is named in a file lies beside the file that names it
//! ([`placed_in`]); only what a caller names, on a command line for instance, is of the working
//! folder. What a run reads does not depend on where it is started.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use powergs_base::config::document::TEXT_MAX;
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, Embedded, MACHINES, find};
use powergs_base::config::knob;
use powergs_base::config::layer::{self, BASE, DEPTH_MAX, base_of, circle};
use powergs_base::config::suggest::{by_likeness, nearest};
use powergs_base::format::wrapped;

use super::error::RunError;
use super::input::Input;
use crate::machine::{Machine, NO_DEVICE};

/// A kind of configuration file that a system is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FileKind {
    /// The machine.
    Machine,
    /// Its energy table.
    Energy,
    /// Its DRAM device.
    Dram,
    /// The display.
    Display,
}

impl FileKind {
    /// All kinds.
    pub const ALL: [FileKind; 4] =
        [FileKind::Machine, FileKind::Energy, FileKind::Dram, FileKind::Display];

    /// What stands before the keys of the file, with the colon; nothing for the machine.
    pub const fn prefix(self) -> &'static str {
        match self {
            FileKind::Machine => "",
            FileKind::Energy => "energy:",
            FileKind::Dram => "dram:",
            FileKind::Display => "display:",
        }
    }

    /// Its name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            FileKind::Machine => "machine",
            FileKind::Energy => "energy table",
            FileKind::Dram => "DRAM device",
            FileKind::Display => "display preset",
        }
    }

    /// What it is in reports and records.
    pub const fn role(self) -> &'static str {
        match self {
            FileKind::Machine => "machine",
            FileKind::Energy => "energy",
            FileKind::Dram => "dram",
            FileKind::Display => "display",
        }
    }

    /// The files of this kind that come with the program.
    pub(crate) const fn embedded(self) -> &'static [Embedded] {
        match self {
            FileKind::Machine => MACHINES,
            FileKind::Energy => ENERGY,
            FileKind::Dram => DRAM,
            FileKind::Display => DISPLAYS,
        }
    }
}

/// A configuration text and where it came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConfigText {
    /// What error messages call it: the path, or the name of an embedded file.
    pub origin: String,
    /// The folder that it lies in, for paths inside it; `None` for embedded files.
    pub folder: Option<PathBuf>,
    /// The text, complete: with all of the base that it names.
    pub text: String,
    /// The bases that it has, as they were read: origin and text, the nearest first.
    pub bases: Vec<(String, String)>,
    /// The text as it was read, where it has a base.
    own: Option<String>,
    /// Files that it names and that were read for it: no configuration.
    attached: Vec<Input>,
}

impl ConfigText {
    /// A text without a base.
    pub fn new(origin: String, folder: Option<PathBuf>, text: String) -> ConfigText {
        ConfigText { origin, folder, text, bases: Vec::new(), own: None, attached: Vec::new() }
    }

    /// The text as it was read.
    pub fn own(&self) -> &str {
        self.own.as_deref().unwrap_or(&self.text)
    }

    /// What to look at again: sizes that are powers of two of kB or MB, as papers write them that
    /// mean KiB and MiB.
    pub fn decimal_sizes(&self) -> Option<String> {
        fn walk(key: &str, value: &toml::Value, found: &mut Vec<(String, String, String)>) {
            match value {
                toml::Value::Table(table) => {
                    for (name, value) in table {
                        let dot = if key.is_empty() { "" } else { "." };
                        walk(&format!("{key}{dot}{name}"), value, found);
                    }
                }
                toml::Value::String(text) => {
                    let Some((number, unit)) = text.trim().split_once(' ') else { return };
                    let binary = match unit.trim() {
                        "kB" | "KB" => "KiB",
                        "MB" => "MiB",
                        _ => return,
                    };
                    // 2 KB and below says nothing of how somebody counts.
                    let is_binary = |n: &u32| n.is_power_of_two() && *n >= 4;
                    if let Some(n) = number.parse().ok().filter(is_binary) {
                        found.push((key.to_owned(), text.clone(), format!("{n} {binary}")));
                    }
                }
                _ => {}
            }
        }
        let mut found = Vec::new();
        walk("", &toml::Value::Table(self.own().parse().ok()?), &mut found);
        let (key, text, meant) = found.first()?;
        let more = match found.len() - 1 {
            0 => String::new(),
            n => format!(", and {n} more such"),
        };
        Some(format!(
            "{}: `{key}` = \"{text}\"{more}: a KB is 1000 B here; write \"{meant}\" where a \
             paper's KB is 1024 B",
            self.origin
        ))
    }

    /// Reads what a machine of this file needs besides it.
    ///
    /// # Errors
    /// [`RunError::Config`]: a file that cannot be read, or what is wrong with it.
    pub fn attach(&mut self, machine: &mut Machine, files: &dyn Files) -> Result<(), RunError> {
        let (flow, mut attached) = (machine.flow(), Vec::new());
        let folder = self.folder_of(RUN_KEY, &[]);
        let read = flow.attach(machine, &mut |name| {
            let file = files.open(name, folder.as_deref())?;
            let mut again = files.open(name, folder.as_deref())?;
            attached.push(Input::hash("run", name, &mut again).map_err(|e| e.to_string())?);
            Ok(file)
        });
        files.note(&attached);
        self.attached = attached;
        read.map_err(|e| RunError::config(&self.origin, e))
    }

    /// The folder of what a key names: that of the file in which the key stands, which may be a
    /// base; `None`, the working folder, for a key of `sets` (`key=value`), for embedded files and
    /// for texts in memory.
    pub fn folder_of(&self, key: &str, sets: &[String]) -> Option<PathBuf> {
        if sets.iter().any(|set| set.split('=').next().is_some_and(|own| own.trim() == key)) {
            return None;
        }
        let states = |text: &str| {
            let table = text.parse::<toml::Table>();
            table.is_ok_and(|table| !knob::values(&table, key).is_empty())
        };
        if self.bases.is_empty() || states(self.own()) {
            return self.folder.clone();
        }
        let is_embedded =
            |name: &str| FileKind::ALL.iter().any(|kind| find(kind.embedded(), name).is_some());
        match self.bases.iter().find(|(_, text)| states(text)) {
            Some((origin, _)) if is_embedded(origin) => None,
            Some((origin, _)) => Path::new(origin).parent().map(Path::to_path_buf),
            None => self.folder.clone(),
        }
    }

    /// Hashes of it, of its bases and of what was attached, as they were read.
    pub fn inputs(&self, role: &'static str) -> Vec<Input> {
        let own = Input::of_text(role, &self.origin, self.own());
        let bases = self.bases.iter().map(|(origin, text)| Input::of_text(role, origin, text));
        [own].into_iter().chain(bases).chain(self.attached.iter().cloned()).collect()
    }

    /// Hashes of what was attached.
    pub fn attached(&self) -> &[Input] {
        &self.attached
    }

    /// A text of this kind that is in no file, on the base that it names.
    ///
    /// # Errors
    /// As [`read`].
    pub fn in_memory(kind: FileKind, text: String) -> Result<ConfigText, RunError> {
        let origin = format!("{} in memory", kind.name());
        let read =
            |base: &str, folder: Option<&Path>| raw(kind.name(), base, kind.embedded(), folder);
        ConfigText::new(origin, None, text).on_its_base(read)
    }

    /// The text on that of the base that it names, which `read` finds.
    fn on_its_base(
        self,
        read: impl Fn(&str, Option<&Path>) -> Result<ConfigText, RunError>,
    ) -> Result<ConfigText, RunError> {
        if is_yaml(&self.origin) {
            return Ok(self);
        }
        let mut chain: Vec<ConfigText> = Vec::new();
        let mut last = self.clone();
        while let Some(name) = base_of(&last.text) {
            let place = last.origin.clone();
            let base = read(&name, last.folder.as_deref()).map_err(|e| {
                let message = format!("`{BASE}` = \"{name}\": {}", e.message());
                RunError::Config { place: place.clone(), message }
            })?;
            let known: Vec<&str> =
                [&self].into_iter().chain(&chain).map(|file| file.origin.as_str()).collect();
            if chain.len() == DEPTH_MAX || known.contains(&base.origin.as_str()) {
                return Err(RunError::config(place, circle(known.into_iter(), &base.origin)));
            }
            chain.push(base.clone());
            last = base;
        }
        self.on_bases(chain.into_iter().map(|file| (file.origin, file.text)).collect())
    }

    /// The text on its bases, each with its origin, the nearest first.
    ///
    /// # Errors
    /// [`RunError::Config`]: a base that is no TOML, or files with more keys than are merged.
    pub fn on_bases(self, bases: Vec<(String, String)>) -> Result<ConfigText, RunError> {
        let mut below: Option<(&str, String)> = None;
        let own = ("", self.text.as_str());
        let files = bases.iter().map(|(origin, text)| (origin.as_str(), text.as_str()));
        for (origin, text) in [own].into_iter().chain(files).rev() {
            let whole = match &below {
                None => text.to_owned(),
                Some((base, whole)) => layer::on(base, whole, origin, text)
                    .map_err(|e| RunError::config(&self.origin, e))?,
            };
            below = Some((origin, whole));
        }
        let text = below.map_or_else(String::new, |(_, text)| text);
        let own = (!bases.is_empty()).then_some(self.text);
        Ok(ConfigText { own, text, bases, ..self })
    }
}

/// The key of a machine file that names a run.
pub const RUN_KEY: &str = "recorded.file";

/// Where configuration files come from.
pub trait Files: Send + Sync {
    /// The file of this name or path; a relative path is one in `folder`, or in the working folder
    /// where there is none ([`placed_in`]).
    ///
    /// # Errors
    /// [`RunError::Config`]: an unknown name (with the known ones), or a file that cannot be read
    /// as text.
    fn read(
        &self,
        kind: FileKind,
        name: &str,
        folder: Option<&Path>,
    ) -> Result<ConfigText, RunError>;

    /// Opens a file that is no configuration; a relative path as in [`Files::read`].
    ///
    /// # Errors
    /// That it cannot be opened, and why.
    fn open(&self, path: &str, folder: Option<&Path>) -> Result<Box<dyn Read>, String> {
        let (name, path) = (path, placed_in(path, folder));
        let wrong = |e: std::io::Error| format!("{}: {e}{}", path.display(), other(name, &path));
        // What has no end, or waits for a writer, would never be read.
        if !path.metadata().map_err(wrong)?.is_file() {
            return Err(format!("{}: not a regular file", path.display()));
        }
        Ok(Box::new(BufReader::new(File::open(&path).map_err(wrong)?)))
    }

    /// Hears of files that results depend on besides those that are [read](Files::read).
    fn note(&self, _files: &[Input]) {}
}

/// The files that come with the program, and no others.
#[derive(Debug, Clone, Copy, Default)]
pub struct EmbeddedFiles;

impl Files for EmbeddedFiles {
    fn read(&self, kind: FileKind, name: &str, _: Option<&Path>) -> Result<ConfigText, RunError> {
        let files = kind.embedded();
        let Some(text) = find(files, name) else {
            let message = unknown(kind.name(), name, files);
            return Err(RunError::Config { place: String::new(), message });
        };
        let file = ConfigText::new(name.to_owned(), None, text.to_owned());
        file.on_its_base(|base, _| raw(kind.name(), base, files, None))
    }
}

/// The files that come with the program by name, all others by path.
#[derive(Debug, Clone, Copy, Default)]
pub struct DiskFiles;

impl Files for DiskFiles {
    fn read(
        &self,
        kind: FileKind,
        name: &str,
        folder: Option<&Path>,
    ) -> Result<ConfigText, RunError> {
        read(kind.name(), name, kind.embedded(), folder)
    }
}

fn unknown(kind: &str, name: &str, embedded: &[Embedded]) -> String {
    let near = nearest(name, embedded.iter().map(|f| f.name));
    let near = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
    format!("no {kind} `{name}`{near}\n{}", listed(name, embedded))
}

/// Characters of a line of names.
const LINE: usize = 76;

/// The names of files in lines, those that are most like `name` first.
fn listed(name: &str, embedded: &[Embedded]) -> String {
    let names = by_likeness(name, embedded.iter().map(|file| file.name));
    let text = wrapped(&format!("known: {}", names.join(", ")), LINE);
    format!("  {}", text.replace('\n', "\n  "))
}

/// Where a file lies that a file in `folder` calls `name`; `None` is the working folder.
pub fn placed_in(name: &str, folder: Option<&Path>) -> PathBuf {
    folder.map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
}

/// What to add where there is no file at `path`, and the working folder has one of this name.
fn other(name: &str, path: &Path) -> String {
    let is_other = path != Path::new(name) && !path.exists() && Path::new(name).exists();
    match is_other {
        true => format!(
            "; `{name}` in the working folder is not taken: what a file names lies beside that file"
        ),
        false => String::new(),
    }
}

/// Reads an embedded file by name, or any other by path, [`placed_in`] a `folder` if there is one,
/// on the base that it names; `kind` is what messages call such a file.
///
/// # Errors
/// [`RunError::Config`]: an unknown name (with the known ones), a file that cannot be read as text,
/// bases that go round in a circle.
pub fn read(
    kind: &str,
    name: &str,
    embedded: &[Embedded],
    folder: Option<&Path>,
) -> Result<ConfigText, RunError> {
    let file = raw(kind, name, embedded, folder)?;
    file.on_its_base(|base, folder| raw(kind, base, embedded, folder))
}

/// As [`read`], but as the file says it: what `base` means is for its reader.
///
/// # Errors
/// As [`read`].
pub fn raw(
    kind: &str,
    name: &str,
    embedded: &[Embedded],
    folder: Option<&Path>,
) -> Result<ConfigText, RunError> {
    if let Some(text) = find(embedded, name) {
        return Ok(ConfigText::new(name.to_owned(), None, text.to_owned()));
    }
    let path = placed_in(name, folder);
    if !path.exists() && !is_path(name) {
        let message = format!("{}\n  or give a TOML file", unknown(kind, name, embedded));
        return Err(RunError::Config { place: String::new(), message });
    }
    let text = read_text(&path).map_err(|e| {
        let message = e.message() + &other(name, &path);
        RunError::config(path.display(), message)
    })?;
    let folder = path.parent().map(Path::to_path_buf);
    Ok(ConfigText::new(path.display().to_string(), folder, text))
}

/// Reads a text file that is small enough for a configuration.
///
/// # Errors
/// [`RunError::Config`]: it cannot be read, or is no text.
pub(crate) fn read_text(path: &Path) -> Result<String, RunError> {
    let mut bytes = Vec::new();
    let place = path.display();
    let file = File::open(path).map_err(|e| RunError::config(place.to_string(), e))?;
    file.take(TEXT_MAX as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(|e| RunError::config(place.to_string(), e))?;
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        RunError::config(
            place.to_string(),
            format_args!("byte {at} is not UTF-8: this is not a configuration file"),
        )
    })
}

/// Whether a name looks like that of a file, and not like one that comes with the program.
fn is_path(name: &str) -> bool {
    name.contains(['/', '\\']) || name.ends_with(".toml") || is_yaml(name)
}

/// The name or path by which what a file in `folder` calls `name` is found from the working folder:
/// that of an embedded file as it is, any other as a path. What is neither stays as it is, for its
/// reader to refuse.
pub fn found_as(kind: FileKind, name: &str, folder: Option<&Path>) -> String {
    let is_ours = find(kind.embedded(), name).is_some();
    let is_none = kind == FileKind::Dram && name == NO_DEVICE;
    let path = placed_in(name, folder);
    match !is_ours && !is_none && (is_path(name) || path.exists()) {
        true => path.display().to_string(),
        false => name.to_owned(),
    }
}

/// Whether a file is read as a reference table of Accelergy.
pub fn is_yaml(name: &str) -> bool {
    let end = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
    end == "yaml" || end == "yml"
}
