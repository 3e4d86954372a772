//! `again`: runs the command that made a folder once more, and compares what comes out.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

use clap::Parser;
use serde::Deserialize;
use serde_json::json;

use super::{Cli, Command, Context, Exit, Failure, OrExit, invocation, out};
use powergs_report::document::{Cell, Column, Document, Table};
use powergs_report::format::{percent, significant};

/// Shown under `again --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim again reports/demo
  powergs-sim again reports/units/run.toml --in ~/paper
  powergs-sim again runs/snow --out runs/snow-again

The command is that of invocation.toml in the folder. This program runs it where
it ran then, and writes to a temporary folder or --out. All files are compared
but the record of what was typed and the stores of unfinished work. Pages and
pictures say which build made them: with another build only tables must agree.
Exit code 0: the same; 1: other numbers, or files that only one side has.";

/// Arguments of `again`.
#[derive(Debug, clap::Args)]
pub struct AgainArgs {
    /// A folder that replay, compare, sensitivity, sweep, optimize or codesign wrote, or its
    /// run.toml
    #[arg(value_name = "DIR|run.toml")]
    pub folder: PathBuf,
    /// Run the command here [default: the folder where it ran]
    #[arg(long = "in", value_name = "DIR")]
    pub place: Option<PathBuf>,
    /// Keep the new results in this folder
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// `invocation.toml`, as far as it is needed.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
struct TypedCommand {
    command: Vec<String>,
    working_folder: PathBuf,
}

/// Which build made a folder.
#[derive(Debug, Default, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", default)]
struct MadeBy {
    tool_version: String,
    model_version: i64,
    commit: String,
}

/// How a file of both folders differs.
#[derive(Debug, Clone, PartialEq)]
enum FileChange {
    /// Other bytes.
    Bytes,
    /// Cells of a table: how many, and the largest relative difference of numbers.
    Cells(usize, f64),
}

/// What came out.
#[derive(Debug, Default)]
struct AgainOutcome {
    same: usize,
    changed: BTreeMap<String, FileChange>,
    gone: Vec<String>,
    new: Vec<String>,
}

/// Files and folders that say what was typed, or hold unfinished work.
const PASSED_OVER: [&str; 6] =
    ["invocation.toml", "records", "checkpoints", "models", "pairs", "slurm"];

/// Longest file of this kind that is read.
const RECORD_MAX: u64 = 1 << 20;

/// Runs it and compares.
pub fn run(args: &AgainArgs, context: &Context) -> Result<Exit, Failure> {
    let folder = match args.folder.extension() {
        Some(end) if end == "toml" => args.folder.parent().unwrap_or(Path::new(".")),
        _ => &args.folder,
    };
    let invocation: TypedCommand = record(&folder.join("invocation.toml"))?;
    let before: MadeBy = record(&folder.join("run.toml"))?;
    let kept = match &args.out {
        Some(out) if out.exists() => {
            let what = format!("--out {}: is there already; name another folder", out.display());
            return Err(Failure::new(Exit::Usage, what));
        }
        Some(out) => std::path::absolute(out).or_exit(Exit::Usage, out.display())?,
        None => PathBuf::new(),
    };
    let temporary = tempfile::tempdir().or_exit(Exit::Usage, "a temporary folder")?;
    let fresh = if args.out.is_some() { kept } else { temporary.path().join("again") };
    let words = words(folder, &invocation.command, &fresh)?;
    let place = args.place.clone().unwrap_or(invocation.working_folder);
    if !place.is_dir() {
        let what = format!(
            "{}: the command ran here, and it is not there now; say where with --in",
            place.display()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    if !context.global.quiet {
        out::complain(format_args!("again: powergs-sim {}", words.join(" ")));
    }
    let program = invocation::program().or_exit(Exit::Internal, "this program")?;
    let mut process = Process::new(program);
    process.args(&words).current_dir(&place);
    let status = process.status().or_exit(Exit::Internal, "this program")?;
    if context.is_cancelled() {
        return Ok(Exit::Interrupted);
    }
    // A goal that was missed then may be missed now, and what was written is compared.
    if !fresh.is_dir() || !matches!(status.code(), Some(0 | 1)) {
        let what = format!("{}: the command fails now, as it says above", folder.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    let after: MadeBy = record(&fresh.join("run.toml"))?;
    let outcome = compared(folder, &fresh)?;
    let numbers = outcome.changed.values().any(|change| matches!(change, FileChange::Cells(..)));
    let files = !outcome.gone.is_empty() || !outcome.new.is_empty();
    let bytes = before == after && !outcome.changed.is_empty();
    tell(&outcome, [&before, &after], context)?;
    Ok(if numbers || files || bytes { Exit::GoalMissed } else { Exit::Done })
}

/// A small TOML file.
fn record<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<T, Failure> {
    let size = fs::metadata(path).map(|found| found.len());
    let size = size.or_exit(Exit::BadInput, format_args!("{}", path.display()))?;
    if size > RECORD_MAX {
        let what = format!("{}: {size} bytes are no record of a run", path.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    let text = fs::read_to_string(path).or_exit(Exit::BadInput, path.display())?;
    toml::from_str(&text).or_exit(Exit::BadInput, path.display())
}

/// The command without the program, with its folder replaced.
fn words(folder: &Path, command: &[String], fresh: &Path) -> Result<Vec<String>, Failure> {
    let mut words = Vec::new();
    let mut old = command.iter().skip(1);
    while let Some(word) = old.next() {
        match word.as_str() {
            "--out" | "-o" => drop(old.next()),
            "--force" | "--resume" | "--json" | "--quiet" | "-q" => {}
            word if word.starts_with("--out=") => {}
            // What follows are files, whatever they are called.
            "--" => break,
            word => words.push(word.to_owned()),
        }
    }
    words.extend(["--quiet".to_owned(), "--out".to_owned(), fresh.display().to_string()]);
    let files: Vec<String> = old.cloned().collect();
    if !files.is_empty() {
        words.push("--".to_owned());
        words.extend(files);
    }
    let line = || format!("{}: powergs-sim {}", folder.display(), words.join(" "));
    let whole = ["powergs-sim"].into_iter().chain(words.iter().map(String::as_str));
    let cli = Cli::try_parse_from(whole).map_err(|why| {
        let why = why.to_string();
        let why = why.lines().next().unwrap_or_default().trim_start_matches("error: ");
        Failure::new(Exit::BadInput, format!("{}: this version refuses it: {why}", line()))
    })?;
    match cli.command {
        Command::Replay(_)
        | Command::Compare(_)
        | Command::Sensitivity(_)
        | Command::Sweep(_)
        | Command::Optimize(_)
        | Command::Codesign(_) => Ok(words),
        _ => Err(Failure::new(Exit::BadInput, format!("{}: it writes no folder", line()))),
    }
}

/// All files below a folder that are compared, by their path in it.
fn files(folder: &Path) -> Result<BTreeMap<String, PathBuf>, Failure> {
    let (mut found, mut open) = (BTreeMap::new(), vec![folder.to_owned()]);
    while let Some(place) = open.pop() {
        for entry in fs::read_dir(&place).or_exit(Exit::BadInput, place.display())? {
            let path = entry.or_exit(Exit::BadInput, place.display())?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if PASSED_OVER.contains(&name.as_str()) || name.starts_with('.') {
                continue;
            }
            if path.is_dir() {
                open.push(path);
            } else {
                let inside = path.strip_prefix(folder).unwrap_or(&path);
                found.insert(inside.display().to_string(), path);
            }
        }
    }
    Ok(found)
}

fn compared(before: &Path, after: &Path) -> Result<AgainOutcome, Failure> {
    let (old, mut new) = (files(before)?, files(after)?);
    let mut outcome = AgainOutcome::default();
    for (name, path) in old {
        let Some(other) = new.remove(&name) else {
            outcome.gone.push(name);
            continue;
        };
        let read = |path: &Path| fs::read(path).or_exit(Exit::BadInput, path.display());
        let (a, b) = (read(&path)?, read(&other)?);
        if a == b {
            outcome.same += 1;
        } else {
            let table = if name.ends_with(".csv") { cells(&a, &b) } else { None };
            outcome.changed.insert(name, table.unwrap_or(FileChange::Bytes));
        }
    }
    outcome.new = new.into_keys().collect();
    Ok(outcome)
}

/// How two tables of the same shape differ.
fn cells(a: &[u8], b: &[u8]) -> Option<FileChange> {
    let reader = |bytes| csv::ReaderBuilder::new().has_headers(false).from_reader(bytes);
    let (mut a, mut b) = (reader(a), reader(b));
    let (mut a, mut b) = (a.records(), b.records());
    let (mut changed, mut largest) = (0, 0.0_f64);
    loop {
        let (row, other) = match (a.next(), b.next()) {
            (None, None) => return Some(FileChange::Cells(changed, largest)),
            (Some(Ok(row)), Some(Ok(other))) if row.len() == other.len() => (row, other),
            _ => return Some(FileChange::Cells(usize::MAX, f64::INFINITY)),
        };
        for (x, y) in row.iter().zip(&other).filter(|(x, y)| x != y) {
            changed += 1;
            let relative = match (x.parse::<f64>(), y.parse::<f64>()) {
                (Ok(x), Ok(y)) => (x - y).abs() / x.abs().max(y.abs()),
                _ => f64::INFINITY,
            };
            largest = largest.max(relative);
        }
    }
}

fn tell(outcome: &AgainOutcome, made: [&MadeBy; 2], context: &Context) -> Result<(), Failure> {
    if context.global.json {
        let changed = outcome.changed.iter().map(|(name, change)| match change {
            FileChange::Bytes => json!({ "file": name, "what": "bytes" }),
            FileChange::Cells(n, largest) => {
                json!({ "file": name, "cells": n, "largest_relative": largest })
            }
        });
        return out::json(&json!({
            "same_files": outcome.same,
            "changed": changed.collect::<Vec<_>>(),
            "gone": outcome.gone,
            "new": outcome.new,
        }));
    }
    if context.global.quiet {
        return Ok(());
    }
    let mut page = Document::new();
    let by = |made: &MadeBy| {
        let MadeBy { tool_version, model_version, commit } = made;
        format!("powergs-sim {tool_version}, models {model_version}, commit {commit}")
    };
    let mut facts = vec![("before", by(made[0])), ("now", by(made[1]))];
    facts.push(("same files", outcome.same.to_string()));
    for (name, files) in [("only before", &outcome.gone), ("only now", &outcome.new)] {
        if !files.is_empty() {
            facts.push((name, files.join(", ")));
        }
    }
    page.facts(facts);
    let columns = [Column::text("file"), Column::text("what differs")];
    let row = |(name, change): (&String, &FileChange)| {
        let what = match change {
            FileChange::Bytes if made[0] != made[1] => "bytes: another build made it".to_owned(),
            FileChange::Bytes => "bytes".to_owned(),
            FileChange::Cells(usize::MAX, _) => "other rows or columns".to_owned(),
            FileChange::Cells(n, largest) if largest.is_finite() => {
                let most = if *largest < 1e-4 { significant(*largest) } else { percent(*largest) };
                format!("{n} numbers, by {most} at most")
            }
            FileChange::Cells(n, _) => format!("{n} cells, texts among them"),
        };
        [Cell::from(name.as_str()), what.into()]
    };
    page.table(Table::new(columns).rows(outcome.changed.iter().map(row)));
    let same = outcome.changed.is_empty() && outcome.gone.is_empty() && outcome.new.is_empty();
    page.paragraph(if same { "The same bytes." } else { "" });
    out::document(&page)
}
