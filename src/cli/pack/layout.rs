//! Where inputs are in the archive, and the command that reads them there.
//!
//! What relative paths lead to keeps its place around the working folder, so that files which name
//! each other still do: `inputs/work`. What was typed with an absolute path gets a folder of its
//! own: `inputs/1`, `inputs/2`, …; the command is written with paths to them. Where a record of
//! the folder has such a path, `moved` says which one it is now, and nothing else in the archive
//! says where inputs were.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use super::archive::{PackEntry, PackSource};
use super::reads::{PackReads, texts};
use crate::cli::again::words::{Repeat, TypedValue, repeated};
use crate::cli::again::{INVOCATION, PACKED_INPUTS, TypedCommand};
use crate::cli::scene_file::name_of;
use crate::cli::{Exit, Failure, OrExit};

/// Files of a folder that may say what was typed.
const RECORDS: [&str; 4] = ["run.toml", "sweep.toml", "summary.md", "summary.txt"];
/// The folder of what relative paths lead to.
const WORK: &str = "work";

/// A path from the root, without `.` and `..`. Links are not followed: a path means the same names
/// wherever it is.
pub(super) fn lexical(path: &Path) -> Result<PathBuf, Failure> {
    let whole = std::path::absolute(path).or_exit(Exit::Usage, path.display())?;
    let mut plain = PathBuf::new();
    for part in whole.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    Ok(plain)
}

/// Where everything is.
pub(super) struct PackLayout<'a> {
    reads: &'a PackReads,
    place: &'a Path,
    /// The folder that becomes `inputs/work`.
    root: PathBuf,
    /// What was typed with absolute paths: the folder that becomes `inputs/N`, by N from 1.
    apart: BTreeMap<&'a str, (usize, PathBuf)>,
}

impl<'a> PackLayout<'a> {
    /// The layout of what a command reads which ran in `place`.
    pub(super) fn of(place: &'a Path, reads: &'a PackReads) -> PackLayout<'a> {
        let folders = reads.here.iter().filter_map(|file| file.parent());
        let root = folders.fold(place.to_owned(), |root, folder| common(&root, folder));
        let apart = reads.apart.iter().enumerate().map(|(i, (typed, apart))| {
            let folders = apart.files.iter().filter_map(|file| file.parent());
            let own = apart.path.parent().unwrap_or(&apart.path).to_owned();
            let mut root = folders.fold(own, |root, folder| common(&root, folder));
            // A model that is called like a folder around it keeps that folder.
            let is_named = |root: &Path| {
                let inside = apart.path.strip_prefix(root);
                inside.is_ok_and(|inside| name_of(inside) == name_of(&apart.path))
            };
            while !is_named(&root) && root.pop() {}
            (typed.as_str(), (i + 1, root))
        });
        PackLayout { reads, place, root, apart: apart.collect() }
    }

    /// The working folder in the archive.
    fn working_folder(&self) -> Result<String, Failure> {
        within(PACKED_INPUTS, WORK, &self.root, self.place)
    }

    /// Inputs as entries, and the working folder, which may be empty.
    pub(super) fn entries(&self) -> Result<Vec<PackEntry>, Failure> {
        let mut entries =
            vec![PackEntry { name: self.working_folder()?, source: PackSource::Folder }];
        let mut add = |folder: &str, root: &Path, file: &Path| {
            let name = within(PACKED_INPUTS, folder, root, file)?;
            entries.push(PackEntry { name, source: PackSource::File(file.to_owned()) });
            Ok::<(), Failure>(())
        };
        self.reads.here.iter().try_for_each(|file| add(WORK, &self.root, file))?;
        for (typed, (number, root)) in &self.apart {
            for file in &self.reads.apart[*typed].files {
                add(&number.to_string(), root, file)?;
            }
        }
        Ok(entries)
    }

    /// `invocation.toml` of the archive: the same command in the packed inputs.
    pub(super) fn invocation(
        &self,
        folder: &Path,
        typed: &TypedCommand,
    ) -> Result<Vec<u8>, Failure> {
        let path = folder.join(INVOCATION);
        let text = std::fs::read_to_string(&path).or_exit(Exit::BadInput, path.display())?;
        let mut table: toml::Table = text.parse().or_exit(Exit::BadInput, path.display())?;
        table.insert("working-folder".into(), self.working_folder()?.into());
        let is_apart = |value: &TypedValue| self.renamed(value) != value.text;
        let renamed = |value: &TypedValue| self.renamed(value);
        let written = repeated(folder, &typed.command, &Repeat::Written(&renamed))?;
        // The words as they were typed, unless they name places of this computer.
        let program = Path::new(typed.command.first().map_or("powergs-sim", String::as_str));
        let program = program.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let names_places = typed.command.iter().skip(1).any(|word| is_absolute(word));
        let words = match written.values.iter().any(is_apart) || names_places {
            true => written.words,
            false => typed.command.iter().skip(1).cloned().collect(),
        };
        let words: Vec<String> = [program].into_iter().chain(words).collect();
        let moved = self.moved(folder, &written.values);
        if !moved.is_empty() {
            table.insert("moved".into(), toml::Value::Table(moved));
        }
        table.insert("command".into(), words.into());
        let head = "# Packed: the command reads the files in `inputs`. `powergs-sim again FOLDER`, \
                    with the folder of\n# this file, runs it once more and compares.\n";
        Ok(format!("{head}{table}").into_bytes())
    }

    /// Paths in the archive with what was typed for them, where files of the folder have that.
    fn moved(&self, folder: &Path, values: &[TypedValue]) -> toml::Table {
        let mut moved = toml::Table::new();
        let renamed = values.iter().flat_map(|value| texts(&value.text));
        let renamed: Vec<(&str, String)> =
            renamed.filter_map(|text| Some((text, self.relative(text)?))).collect();
        for name in RECORDS {
            let Ok(text) = std::fs::read_to_string(folder.join(name)) else { continue };
            for (then, now) in renamed.iter().filter(|(then, _)| text.contains(then)) {
                moved.insert(now.clone(), (*then).into());
            }
        }
        moved
    }

    /// What is typed in the archive in place of a value.
    fn renamed(&self, value: &TypedValue) -> String {
        for text in texts(&value.text) {
            let Some(other) = self.relative(text) else { continue };
            let before = &value.text[..value.text.len() - text.len()];
            return format!("{before}{other}");
        }
        value.text.clone()
    }

    /// An absolute path as it is seen from the working folder of the archive; `None` for what is
    /// no such path.
    fn relative(&self, text: &str) -> Option<String> {
        let path =
            Path::new(text).is_absolute().then(|| lexical(Path::new(text)).ok()).flatten()?;
        let Some((number, root)) = self.apart.get(text) else {
            let inside = slashed(path.strip_prefix(self.place).ok()?)?;
            return Some(if inside.is_empty() { ".".to_owned() } else { inside });
        };
        let inside = slashed(path.strip_prefix(root).ok()?)?;
        // Up from the working folder, and from `work`.
        let depth = self.place.strip_prefix(&self.root).map_or(0, |p| p.components().count()) + 1;
        let up = "../".repeat(depth);
        Some(format!("{up}{number}/{inside}").trim_end_matches('/').to_owned())
    }
}

/// Whether a word is a path from the root, or has one behind `=` or behind `-o`.
fn is_absolute(word: &str) -> bool {
    let behind_short = word.get(2..).filter(|_| word.starts_with('-'));
    texts(word).chain(behind_short).any(|text| Path::new(text).is_absolute())
}

/// The longest folder that two paths are in.
fn common(a: &Path, b: &Path) -> PathBuf {
    a.components().zip(b.components()).take_while(|(a, b)| a == b).map(|(a, _)| a).collect()
}

/// The name in the archive of what is at `path` in `root`.
fn within(first: &str, folder: &str, root: &Path, path: &Path) -> Result<String, Failure> {
    let inside = path.strip_prefix(root).ok().and_then(slashed).ok_or_else(|| {
        let what = "a name that is not UTF-8 cannot be packed; rename it";
        Failure::new(Exit::BadInput, format!("{}: {what}", path.display()))
    })?;
    let dot = if inside.is_empty() { "" } else { "/" };
    Ok(format!("{first}/{folder}{dot}{inside}"))
}

/// A relative path with slashes.
fn slashed(path: &Path) -> Option<String> {
    let names: Option<Vec<&str>> = path.iter().map(|name| name.to_str()).collect();
    Some(names?.join("/"))
}
