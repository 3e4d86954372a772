//! Which files a command reads: those that were typed, and those that these name.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::layout::lexical;
use super::record::PackRecord;
use crate::cli::again::words::{RepeatedCommand, TypedValue};
use crate::cli::optimize::photo_cameras;
use crate::cli::scene_file::name_of;
use crate::cli::{Exit, Failure, OrExit};
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, SWEEPS, SYNTH, find};
use powergs_study::sweep::run::trace_files;

/// Files that a command reads at most.
const FILES_MAX: usize = 200_000;
/// Longest text that may name files, bytes: a streamed scene has a list of its parts.
const TEXT_MAX: u64 = 64 << 20;
/// Longest path in a file, bytes.
const PATH_MAX: usize = 4_096;
/// What a training run says of itself, and how many folders above a model it is looked for.
const TRAINER: (&str, usize) = ("cfg_args", 3);

/// What was typed with an absolute path, outside of the working folder: it gets a place of its own.
#[derive(Debug)]
pub(super) struct TypedApart {
    /// What was typed, or the part of a pattern before its first `*` or `?`.
    pub path: PathBuf,
    /// What is read for it.
    pub files: BTreeSet<PathBuf>,
}

/// All files that a command reads.
#[derive(Debug, Default)]
pub(super) struct PackReads {
    /// Those that relative paths lead to.
    pub here: BTreeSet<PathBuf>,
    /// Those of absolute paths, by what was typed.
    pub apart: BTreeMap<String, TypedApart>,
    /// Folders of reports among what was typed.
    pub reports: Vec<PathBuf>,
}

impl PackReads {
    /// Every file; one that is read in two ways is there twice.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let apart = self.apart.values().flat_map(|apart| &apart.files);
        self.here.iter().chain(apart).map(PathBuf::as_path)
    }
}

/// Whether a command trains models: its record has one hash of all inputs.
pub(super) fn trains(command: &RepeatedCommand) -> bool {
    command.words.first().is_some_and(|name| ["optimize", "codesign"].contains(&name.as_str()))
}

/// The files that a command of `folder` reads which ran in `place`.
pub(super) fn of(
    command: &RepeatedCommand,
    place: &Path,
    folder: &Path,
    record: &PackRecord,
) -> Result<PackReads, Failure> {
    let trains = trains(command);
    let has_cameras = command.values.iter().any(|value| value.of == "cameras");
    let mut reads = PackReads::default();
    for value in &command.values {
        for text in texts(&value.text) {
            let mut finder = ReadsFinder { folder, record, files: BTreeSet::new() };
            let path = finder.typed(value, text, place)?;
            let Some(path) = path else { continue };
            if trains && value.is_path {
                finder.of_trainer(&path);
                if value.of == "images" && !has_cameras {
                    finder.cameras_of(&path)?;
                }
            }
            let is_report = path.is_dir() && path.join("run.toml").is_file();
            reads.reports.extend(is_report.then(|| path.clone()));
            // A model may be called like a folder that it is in.
            let is_inside =
                path.strip_prefix(place).is_ok_and(|inside| name_of(inside) == name_of(&path));
            if Path::new(text).is_absolute() && !is_inside {
                let apart = TypedApart { path, files: finder.files };
                reads.apart.insert(text.to_owned(), apart);
            } else {
                reads.here.extend(finder.files);
            }
            break;
        }
    }
    if reads.files().count() > FILES_MAX {
        let what = format!("its command reads more than {FILES_MAX} files; pack them by hand");
        return Err(Failure::new(Exit::BadInput, format!("{}: {what}", folder.display())));
    }
    Ok(reads)
}

/// What of a value may be a path: the whole of it, and what follows `NAME=` or `KEY=`.
pub(super) fn texts(value: &str) -> impl Iterator<Item = &str> {
    let behind = value.split_once('=').map(|(_, behind)| behind);
    [value].into_iter().chain(behind).filter(|text| !text.is_empty())
}

/// Whether a file that comes with the program has this name: it is taken before any other.
pub(super) fn is_embedded(name: &str) -> bool {
    [MACHINES, ENERGY, DRAM, DISPLAYS, SWEEPS, SYNTH]
        .iter()
        .any(|files| find(files, name).is_some())
}

/// The part of a pattern before its first name with a `*` or `?`; `None` for a plain path.
pub(super) fn before_stars(pattern: &str) -> Option<PathBuf> {
    let has_star = |name: &std::ffi::OsStr| name.to_string_lossy().contains(['*', '?']);
    let names = Path::new(pattern).iter();
    let before: PathBuf = names.clone().take_while(|name| !has_star(name)).collect();
    names.clone().any(has_star).then_some(before)
}

/// Looks for the files of one value.
struct ReadsFinder<'a> {
    /// The folder that is packed: it is no input of itself.
    folder: &'a Path,
    record: &'a PackRecord,
    files: BTreeSet<PathBuf>,
}

impl ReadsFinder<'_> {
    /// Takes what a text of the command names; the path, if it names anything.
    fn typed(
        &mut self,
        value: &TypedValue,
        text: &str,
        place: &Path,
    ) -> Result<Option<PathBuf>, Failure> {
        if is_embedded(text) || text.len() > PATH_MAX {
            return Ok(None);
        }
        let path = lexical(&place.join(text))?;
        // A word that a file happens to be called does not make it an input.
        let is_meant = value.is_path || text.contains(['/', '.']);
        if path.is_file() && (is_meant || self.is_recorded(&path)) {
            same_place(&place.join(text), &path)?;
            // Photos that a list of cameras names are read where their folder is given.
            self.take(&path, value.of != "cameras")?;
            return Ok(Some(path));
        }
        if path.is_dir() && (value.is_path || text != value.text) {
            same_place(&place.join(text), &path)?;
            self.take_folder(&path)?;
            return Ok(Some(path));
        }
        match before_stars(text) {
            Some(before) if !path.exists() => {
                let found = trace_files(text, Some(place)).unwrap_or_default();
                for file in &found {
                    self.take(&lexical(file)?, true)?;
                }
                let before = lexical(&place.join(before))?;
                Ok((!found.is_empty()).then_some(before))
            }
            _ => Ok(None),
        }
    }

    fn is_recorded(&self, path: &Path) -> bool {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        self.record.inputs.has_name(&name)
    }

    /// Takes a file, and what it names.
    fn take(&mut self, path: &Path, with_named: bool) -> Result<(), Failure> {
        let mut open = vec![path.to_owned()];
        while let Some(file) = open.pop() {
            if !self.files.insert(file.clone()) || !with_named {
                continue;
            }
            if self.files.len() > FILES_MAX {
                break;
            }
            for name in named(&file)? {
                open.extend(self.beside(&file, &name)?);
            }
        }
        Ok(())
    }

    /// The files that `file` means by a text in it.
    fn beside(&self, file: &Path, text: &str) -> Result<Vec<PathBuf>, Failure> {
        let folder = file.parent().unwrap_or(Path::new("/"));
        for text in texts(text).filter(|text| text.len() <= PATH_MAX && !is_embedded(text)) {
            let path = lexical(&folder.join(text))?;
            let is_input = self.record.inputs.is_empty() || self.is_recorded(&path);
            let found = match before_stars(text) {
                Some(_) if !path.exists() => trace_files(text, Some(folder)).unwrap_or_default(),
                _ if path.is_file() && is_input => vec![path],
                _ => continue,
            };
            if found.is_empty() {
                continue;
            }
            if Path::new(text).is_absolute() {
                let what = format!(
                    "names `{text}` by an absolute path, which other computers do not have; write \
                     it as seen from this file, and make the folder anew"
                );
                return Err(Failure::new(Exit::BadInput, format!("{}: {what}", file.display())));
            }
            same_place(&folder.join(text), &lexical(&folder.join(text))?)?;
            return found.iter().map(|path| lexical(path)).collect();
        }
        Ok(Vec::new())
    }

    /// Takes all files of a folder. Links to files are read; those to folders may lead back.
    fn take_folder(&mut self, folder: &Path) -> Result<(), Failure> {
        let mut open = vec![folder.to_owned()];
        while let Some(place) = open.pop() {
            for entry in fs::read_dir(&place).or_exit(Exit::BadInput, place.display())? {
                let path = entry.or_exit(Exit::BadInput, place.display())?.path();
                let is_hidden = path.file_name().is_some_and(|n| n.as_encoded_bytes()[0] == b'.');
                if path == self.folder || is_hidden {
                    continue;
                }
                let is_link = path.is_symlink();
                if path.is_file() {
                    self.files.insert(path);
                } else if path.is_dir() && !is_link {
                    open.push(path);
                } else {
                    let what = "a link to a folder, or no file, among the inputs; put the files \
                                in its place";
                    return Err(Failure::new(
                        Exit::BadInput,
                        format!("{}: {what}", path.display()),
                    ));
                }
                if self.files.len() > FILES_MAX {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Takes what the training run of a model says of its background.
    fn of_trainer(&mut self, path: &Path) {
        let own = if path.is_dir() { Some(path) } else { path.parent() };
        let folders = own.into_iter().flat_map(Path::ancestors).take(TRAINER.1);
        let found = folders.map(|folder| folder.join(TRAINER.0)).find(|file| file.is_file());
        self.files.extend(found);
    }

    /// Takes the cameras that belong to a folder of photos.
    fn cameras_of(&mut self, photos: &Path) -> Result<(), Failure> {
        let Some(folder) = photo_cameras(photos).filter(|folder| folder != photos) else {
            return Ok(());
        };
        for entry in fs::read_dir(&folder).or_exit(Exit::BadInput, folder.display())? {
            let path = entry.or_exit(Exit::BadInput, folder.display())?.path();
            let end = path.extension().unwrap_or_default();
            if path.is_file() && ["json", "bin", "txt"].iter().any(|known| end == *known) {
                self.files.insert(path);
            }
        }
        let sparse = folder.join("sparse");
        if sparse.is_dir() { self.take_folder(&sparse) } else { Ok(()) }
    }
}

/// Refuses a path with `..` behind a link: it means another file where it is unpacked.
fn same_place(path: &Path, lexical: &Path) -> Result<(), Failure> {
    match (fs::canonicalize(path), fs::canonicalize(lexical)) {
        (Ok(a), Ok(b)) if a != b => {
            let what = "goes up from a link to a folder; name the file without the link";
            Err(Failure::new(Exit::BadInput, format!("{}: {what}", path.display())))
        }
        _ => Ok(()),
    }
}

/// The texts in a file that may name other files.
fn named(file: &Path) -> Result<Vec<String>, Failure> {
    let end = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let length = file.metadata().or_exit(Exit::BadInput, file.display())?.len();
    if !["toml", "json", "gltf"].contains(&end.as_str()) || length > TEXT_MAX {
        return Ok(Vec::new());
    }
    let Ok(text) = fs::read_to_string(file) else { return Ok(Vec::new()) };
    let mut found = Vec::new();
    if end == "toml" {
        let table: toml::Table = text.parse().unwrap_or_default();
        of_toml(&toml::Value::Table(table), &mut found);
    } else {
        of_json(&serde_json::from_str(&text).unwrap_or_default(), &mut found);
    }
    Ok(found)
}

fn of_toml(value: &toml::Value, found: &mut Vec<String>) {
    match value {
        toml::Value::String(text) => found.push(text.clone()),
        toml::Value::Array(items) => items.iter().for_each(|item| of_toml(item, found)),
        toml::Value::Table(table) => table.values().for_each(|item| of_toml(item, found)),
        _ => {}
    }
}

fn of_json(value: &serde_json::Value, found: &mut Vec<String>) {
    match value {
        serde_json::Value::String(text) => found.push(text.clone()),
        serde_json::Value::Array(items) => items.iter().for_each(|item| of_json(item, found)),
        serde_json::Value::Object(table) => table.values().for_each(|item| of_json(item, found)),
        _ => {}
    }
}
