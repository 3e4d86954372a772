//! The end of a sweep: the table, and a note that it is whole.

use std::fs;
use std::io::Read;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::folder::SweepFolder;
use super::opened::Opened;
use super::output::{self, CSV, PARQUET, Tally};
use super::plan::Plan;
use super::state::State;
use super::summary;
use crate::cli::aside::write_aside;
use crate::cli::invocation::Started;
use crate::cli::{Context, Exit, Failure, OrExit, out, pareto};

/// What the analysis says on a terminal.
const ANSWER: &str = "analysis.txt";

/// Its name in the folder.
const FILE: &str = "finished.toml";

/// A sweep that is whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Finished {
    /// Hash of the state that it was made from.
    state: String,
    /// Hash of its table.
    results: String,
    /// Designs with all results.
    pub ok: u64,
    /// Designs that failed.
    pub failed: u64,
    /// Designs that constraints exclude.
    pub excluded: u64,
}

impl Finished {
    /// What a folder says of this state; `None` if it is not whole, or its table was changed.
    pub fn read(folder: &Path, state: &State) -> Option<Finished> {
        let text = fs::read_to_string(folder.join(FILE)).ok()?;
        let finished: Finished = toml::from_str(&text).ok()?;
        let same = finished.state == format!("{:032x}", state.hash())
            && finished.results == hash(&folder.join(CSV)).ok()?
            && folder.join(PARQUET).exists();
        same.then_some(finished)
    }
}

/// Designs that constraints exclude, as a finished sweep in `folder` says; `None` if it says
/// nothing.
pub fn excluded(folder: &Path) -> Option<u64> {
    let text = fs::read_to_string(folder.join(FILE)).ok()?;
    Some(toml::from_str::<Finished>(&text).ok()?.excluded)
}

fn hash(path: &Path) -> std::io::Result<String> {
    let mut hash = xxhash_rust::xxh3::Xxh3::new();
    let mut file = fs::File::open(path)?;
    let mut buffer = vec![0; 1 << 18];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(format!("{:032x}", hash.digest128())),
            n => hash.update(&buffer[..n]),
        }
    }
}

/// Writes everything that a finished sweep has, and says so.
///
/// # Errors
/// Exit code 2: the folder cannot be written.
pub fn finish(
    folder: &mut SweepFolder,
    opened: &mut Opened,
    plan: &Plan,
    started: Started,
    context: &Context,
) -> Result<Exit, Failure> {
    let path = folder.path.clone();
    let tally = output::write(folder, opened, plan)?;
    if tally.missing > 0 {
        let what = "results are missing; run it again with --resume";
        out::complain(format_args!("{}: {} designs: {what}", path.display(), tally.missing));
        return Ok(Exit::GoalMissed);
    }
    summary::write(&path, opened, plan, tally)?;
    write_aside(&path.join("run.toml"), |w| w.write_all(opened.state.toml().as_bytes()))?;
    write_aside(&path.join("sweep.toml"), |w| w.write_all(opened.file.text().as_bytes()))?;
    let invocation = started.invocation_toml();
    write_aside(&path.join("invocation.toml"), |w| w.write_all(invocation.as_bytes()))?;
    let finished = Finished {
        state: format!("{:032x}", opened.state.hash()),
        results: hash(&path.join(CSV)).or_exit(Exit::Usage, path.display())?,
        ok: tally.ok,
        failed: tally.failed,
        excluded: plan.excluded.values().sum(),
    };
    let answer = match pareto::analyse(&path, finished.excluded, context) {
        Ok(Some(answer)) => answer.terminal,
        Ok(None) => return Ok(Exit::Interrupted),
        // The table is whole all the same: a question can be asked anew.
        Err(failure) => format!("No analysis: {failure}\n"),
    };
    write_aside(&path.join(ANSWER), |w| w.write_all(answer.as_bytes()))?;
    // Last: a run that is killed before it is continued, and makes everything above anew.
    let text = toml::to_string(&finished).or_exit(Exit::Internal, FILE)?;
    write_aside(&path.join(FILE), |w| w.write_all(text.as_bytes()))?;
    say(&finished, &path, context)
}

/// Says what a finished sweep has.
///
/// # Errors
/// Those of standard output.
pub fn say(finished: &Finished, path: &Path, context: &Context) -> Result<Exit, Failure> {
    if context.global.json {
        out::json(&json(finished, path))?;
    } else if !context.global.quiet {
        let text = fs::read_to_string(path.join(summary::TERMINAL)).unwrap_or_default();
        out::text(&text)?;
        let answer = fs::read_to_string(path.join(ANSWER)).unwrap_or_default();
        let (table, report) = (path.join(CSV), path.join(pareto::REPORT));
        let report = Some(report).filter(|r| r.exists());
        let report = report.map_or(String::new(), |r| format!("\nreport  {}\n", r.display()));
        out::text(&format!("Table: {}\n\n{answer}{report}", table.display()))?;
    }
    Ok(Exit::Done)
}

fn json(finished: &Finished, path: &Path) -> Value {
    json!({
        "folder": path.display().to_string(),
        "designs_ok": finished.ok,
        "designs_failed": finished.failed,
        "designs_excluded": finished.excluded,
        "results_csv": path.join(CSV).display().to_string(),
        "results_parquet": path.join(PARQUET).display().to_string(),
    })
}

/// A tally as it is printed.
pub fn tally_text(tally: Tally, excluded: u64) -> String {
    let mut text = format!("{} designs", tally.ok);
    if tally.failed > 0 {
        text += &format!(", {} failed", tally.failed);
    }
    if excluded > 0 {
        text += &format!(", {excluded} left out");
    }
    text
}
