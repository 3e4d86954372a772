//! How the files of two folders differ.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::{INVOCATION, PACKED_INPUTS};
use crate::cli::pareto::QUESTION;
use crate::cli::{Exit, Failure, OrExit};
use powergs_base::format::{counted, significant};
use powergs_study::sweep::unit::Unit;

/// How a file of both folders differs.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum FileChange {
    /// Other bytes.
    Bytes,
    /// A table with other rows or columns.
    Shape,
    /// Cells of a table.
    Cells(CellChanges),
}

/// Cells of a table that differ.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct CellChanges {
    /// How many.
    pub cells: usize,
    /// How many of them are texts.
    pub texts: usize,
    /// The number that differs most, as a share of the larger one.
    pub worst: Option<ChangedNumber>,
}

/// A number that differs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ChangedNumber {
    /// What it is: its column, or in long tables the name in its row.
    pub name: String,
    /// Before and now.
    pub values: [f64; 2],
    /// The difference as a share of the larger one.
    pub share: f64,
}

/// What came out.
#[derive(Debug, Default)]
pub(super) struct AgainOutcome {
    /// Files with the same bytes.
    pub same: usize,
    pub changed: BTreeMap<String, FileChange>,
    pub gone: Vec<String>,
    pub new: Vec<String>,
    /// Links, pipes and devices: they are not looked at.
    pub passed_over: Vec<String>,
}

/// Files and folders that say what was typed and where, or hold unfinished work or what `pack` put
/// there.
pub(in crate::cli) const PASSED_OVER: [&str; 8] = [
    INVOCATION,
    "definition.json",
    "records",
    "checkpoints",
    "models",
    "pairs",
    "slurm",
    PACKED_INPUTS,
];

/// What is below a folder.
#[derive(Debug, Default)]
struct FolderFiles {
    /// Files by their path in it.
    files: BTreeMap<String, PathBuf>,
    /// Links, pipes and devices.
    others: Vec<String>,
}

/// All files below a folder that its command wrote. Links are not followed: they may lead back.
fn files(folder: &Path) -> Result<FolderFiles, Failure> {
    let (mut found, mut open) = (FolderFiles::default(), vec![folder.to_owned()]);
    while let Some(place) = open.pop() {
        for entry in fs::read_dir(&place).or_exit(Exit::BadInput, place.display())? {
            let entry = entry.or_exit(Exit::BadInput, place.display())?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if PASSED_OVER.contains(&name.as_str()) || name.starts_with('.') {
                continue;
            }
            let (path, kind) = (entry.path(), entry.file_type());
            let kind = kind.or_exit(Exit::BadInput, path.display())?;
            let inside = path.strip_prefix(folder).unwrap_or(&path).display().to_string();
            if kind.is_file() {
                found.files.insert(inside, path);
            } else if !kind.is_dir() {
                found.others.push(inside);
            } else if !path.join(QUESTION).is_file() {
                // What `pareto` wrote is of another command.
                open.push(path);
            }
        }
    }
    found.others.sort();
    Ok(found)
}

/// The files of two folders, compared one by one. In the new ones paths of `moved` count as what
/// was typed for them.
///
/// # Errors
/// Exit code 3: a file that cannot be read.
pub(super) fn compared(
    before: &Path,
    after: &Path,
    moved: &BTreeMap<String, String>,
) -> Result<AgainOutcome, Failure> {
    let (old, new) = (files(before)?, files(after)?);
    let mut outcome = AgainOutcome { passed_over: old.others, ..AgainOutcome::default() };
    let mut new = new.files;
    for (name, path) in old.files {
        let Some(other) = new.remove(&name) else {
            outcome.gone.push(name);
            continue;
        };
        let read = |path: &Path| fs::read(path).or_exit(Exit::BadInput, path.display());
        let (a, mut b) = (read(&path)?, read(&other)?);
        if a != b && !moved.is_empty() {
            b = as_typed(b, moved);
        }
        if a == b {
            outcome.same += 1;
        } else {
            let is_table = name.ends_with(".csv");
            let change = if is_table { cells(&a, &b) } else { FileChange::Bytes };
            outcome.changed.insert(name, change);
        }
    }
    outcome.new = new.into_keys().collect();
    Ok(outcome)
}

/// A text with what was typed in place of the paths of an unpacked archive; other files as are.
fn as_typed(bytes: Vec<u8>, moved: &BTreeMap<String, String>) -> Vec<u8> {
    match String::from_utf8(bytes) {
        Ok(text) => {
            let put = |text: String, (now, then): (&String, &String)| text.replace(now, then);
            moved.iter().fold(text, put).into_bytes()
        }
        Err(e) => e.into_bytes(),
    }
}

/// How two tables differ.
fn cells(a: &[u8], b: &[u8]) -> FileChange {
    let reader = |bytes| csv::ReaderBuilder::new().has_headers(false).from_reader(bytes);
    let (mut a, mut b) = (reader(a), reader(b));
    let (mut a, mut b) = (a.records(), b.records());
    let mut changes = CellChanges::default();
    let mut head: Option<csv::StringRecord> = None;
    loop {
        let (row, other) = match (a.next(), b.next()) {
            (None, None) => return FileChange::Cells(changes),
            (Some(Ok(row)), Some(Ok(other))) if row.len() == other.len() => (row, other),
            _ => return FileChange::Shape,
        };
        let head = head.get_or_insert_with(|| row.clone());
        for (i, (x, y)) in row.iter().zip(&other).enumerate().filter(|(_, (x, y))| x != y) {
            changes.cells += 1;
            let (Ok(x), Ok(y)) = (x.parse::<f64>(), y.parse::<f64>()) else {
                changes.texts += 1;
                continue;
            };
            let share = if x == y { 0.0 } else { (x - y).abs() / x.abs().max(y.abs()) };
            if changes.worst.as_ref().is_none_or(|worst| share > worst.share) {
                let name = name(head, &row, i);
                changes.worst = Some(ChangedNumber { name, values: [x, y], share });
            }
        }
    }
}

/// What a cell is: its column where that has a unit in its name; else what its row is called.
fn name(head: &csv::StringRecord, row: &csv::StringRecord, column: usize) -> String {
    let own = &head[column];
    if Unit::of_column(own).is_some() {
        return own.to_owned();
    }
    let of_row = row.iter().find(|text| Unit::of_column(text).is_some());
    of_row.unwrap_or(own).to_owned()
}

impl CellChanges {
    /// In words.
    pub(super) fn text(&self) -> String {
        let cells = match self.texts {
            0 => counted(self.cells, "number"),
            _ => format!("{}, texts among them", counted(self.cells, "cell")),
        };
        let Some(ChangedNumber { name, values, share }) = &self.worst else { return cells };
        let unit = Unit::of_column(name).map(Unit::name).filter(|unit| *unit != "1");
        let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
        let [then, now] = values;
        format!("{cells}, by {} at most ({name}: {then}{unit}, now {now}{unit})", shown(*share))
    }
}

/// A share in percent that never looks like none.
fn shown(share: f64) -> String {
    match share * 100.0 {
        percent if percent >= 0.01 || percent == 0.0 => format!("{} %", significant(percent)),
        percent => format!("{percent:.1e} %"),
    }
}
