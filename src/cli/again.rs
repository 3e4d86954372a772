//! `again`: runs the command that made a folder once more, and compares what comes out.

pub(in crate::cli) mod difference;
pub(in crate::cli) mod inputs;
pub(in crate::cli) mod words;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command as Process;

use serde::Deserialize;
use serde_json::json;

use super::{Context, Exit, Failure, OrExit, invocation, out};
use difference::{AgainOutcome, CellChanges, FileChange, compared};
use inputs::RecordedInputs;
use powergs_base::shell;
use powergs_report::document::{Cell, Column, Document, Table};
use words::{Repeat, repeated};

/// Shown under `again --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim again reports/demo
  powergs-sim again reports/units/run.toml --in ~/paper
  powergs-sim again runs/snow --out runs/snow-again

The command is that of invocation.toml in the folder. This program runs it where
it ran then, or in the inputs that `pack` put into the folder, and writes to a
temporary folder or --out; files of other flags go to a temporary folder, and
--store is left out. Inputs that are other files now are named first. All files
are compared but the record of what was typed, the stores of unfinished work and
the reports of pareto; links are not followed.
Pages and pictures say which build made them: with another build only tables
must agree.
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

/// The record of what was typed.
pub(in crate::cli) const INVOCATION: &str = "invocation.toml";
/// The folder of an unpacked archive that has the files which the command reads.
pub(in crate::cli) const PACKED_INPUTS: &str = "inputs";

/// `invocation.toml`, as far as it is needed.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(in crate::cli) struct TypedCommand {
    /// The program and its arguments.
    pub command: Vec<String>,
    /// Where it ran: in an unpacked archive a path inside of the folder that has this file.
    pub working_folder: PathBuf,
    /// In an unpacked archive: paths of the command that files of the folder have as they were
    /// typed, and these.
    #[serde(default)]
    pub moved: BTreeMap<String, String>,
}

impl TypedCommand {
    /// The folder where the command of `folder` ran, unless `place` is it.
    ///
    /// # Errors
    /// Exit code 2: it is not there.
    pub(in crate::cli) fn place(
        &self,
        folder: &Path,
        place: Option<&Path>,
    ) -> Result<PathBuf, Failure> {
        let place = place.map_or_else(|| folder.join(&self.working_folder), Path::to_owned);
        if place.is_dir() {
            return Ok(place);
        }
        let what = format!(
            "{}: the command ran here, and it is not there now; say where with --in",
            place.display()
        );
        Err(Failure::new(Exit::Usage, what))
    }
}

/// Which build made a folder.
#[derive(Debug, Default, Clone, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", default)]
struct MadeBy {
    tool_version: String,
    model_version: i64,
    commit: String,
}

/// Longest file of this kind that is read.
const RECORD_MAX: u64 = 1 << 20;

/// Runs it and compares.
pub fn run(args: &AgainArgs, context: &Context) -> Result<Exit, Failure> {
    let folder = match args.folder.extension() {
        Some(end) if end == "toml" => args.folder.parent().unwrap_or(Path::new(".")),
        _ => &args.folder,
    };
    let invocation: TypedCommand = record(&folder.join(INVOCATION))?;
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
    let files = temporary.path().join("files");
    fs::create_dir(&files).or_exit(Exit::Usage, "a temporary folder")?;
    let how = Repeat::Into { fresh: &fresh, files: &files };
    let again = repeated(folder, &invocation.command, &how)?;
    let place = invocation.place(folder, args.place.as_deref())?;
    let inputs = RecordedInputs::of(&record(&folder.join("run.toml"))?);
    for what in inputs.replaced(&again.values, &place).iter().chain(&again.notes) {
        out::complain(format_args!("again: {what}"));
    }
    if !context.global.quiet {
        out::complain(format_args!("again: powergs-sim {}", shell::line(&again.words)));
    }
    let program = invocation::program().or_exit(Exit::Internal, "this program")?;
    let mut process = Process::new(program);
    // The whole run, wherever this one is started.
    process.args(&again.words).current_dir(&place).env_remove("POWERGS_SHARD");
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
    let other_inputs = inputs.differences(&RecordedInputs::of(&record(&fresh.join("run.toml"))?));
    let outcome = compared(folder, &fresh, &invocation.moved)?;
    let numbers = outcome.changed.values().any(|change| *change != FileChange::Bytes);
    let files = !outcome.gone.is_empty() || !outcome.new.is_empty();
    let bytes = before == after && !outcome.changed.is_empty();
    tell(&outcome, &other_inputs, [&before, &after], context)?;
    Ok(if numbers || files || bytes { Exit::GoalMissed } else { Exit::Done })
}

/// A small TOML file.
///
/// # Errors
/// Exit code 3: it is no such file.
pub(in crate::cli) fn record<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<T, Failure> {
    let found = fs::metadata(path).or_exit(Exit::BadInput, path.display())?;
    if !found.is_file() {
        let what = format!("{}: not a regular file", path.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    let size = found.len();
    if size > RECORD_MAX {
        let what = format!("{}: {size} bytes are no record of a run", path.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    let text = fs::read_to_string(path).or_exit(Exit::BadInput, path.display())?;
    toml::from_str(&text).or_exit(Exit::BadInput, path.display())
}

fn tell(
    outcome: &AgainOutcome,
    other_inputs: &[String],
    made: [&MadeBy; 2],
    context: &Context,
) -> Result<(), Failure> {
    if context.global.json {
        let changed = outcome.changed.iter().map(|(name, change)| match change {
            FileChange::Bytes => json!({ "file": name, "what": "bytes" }),
            FileChange::Shape => json!({ "file": name, "what": "rows or columns" }),
            FileChange::Cells(CellChanges { cells, texts, worst }) => json!({
                "file": name,
                "cells": cells,
                "texts": texts,
                "largest_relative": worst.as_ref().map(|worst| worst.share),
                "largest_in": worst.as_ref().map(|worst| &worst.name),
                "largest_values": worst.as_ref().map(|worst| worst.values),
            }),
        });
        return out::json(&json!({
            "other_inputs": other_inputs,
            "same_files": outcome.same,
            "changed": changed.collect::<Vec<_>>(),
            "gone": outcome.gone,
            "new": outcome.new,
            "passed_over": outcome.passed_over,
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
    let mut facts = Vec::new();
    if !other_inputs.is_empty() {
        facts.push(("other inputs", other_inputs.join("; ")));
    }
    facts.extend([("before", by(made[0])), ("now", by(made[1]))]);
    facts.push(("same files", outcome.same.to_string()));
    for (name, files) in [
        ("only before", &outcome.gone),
        ("only now", &outcome.new),
        ("not opened", &outcome.passed_over),
    ] {
        if !files.is_empty() {
            facts.push((name, files.join(", ")));
        }
    }
    page.facts(facts);
    let columns = [Column::text("file"), Column::text("what differs").wraps()];
    let row = |(name, change): (&String, &FileChange)| {
        let what = match change {
            FileChange::Bytes if made[0] != made[1] => "bytes: another build made it".to_owned(),
            FileChange::Bytes => "bytes".to_owned(),
            FileChange::Shape => "other rows or columns".to_owned(),
            FileChange::Cells(changes) => changes.text(),
        };
        [Cell::from(name.as_str()), what.into()]
    };
    page.table(Table::new(columns).rows(outcome.changed.iter().map(row)));
    let same = outcome.changed.is_empty() && outcome.gone.is_empty() && outcome.new.is_empty();
    page.paragraph(if same { "The same bytes." } else { "" });
    out::document(&page)
}
