//! The end of a sweep: its table, what is said of it, and a note that it is whole.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::cli::invocation::Started;
use crate::cli::{Context, Exit, Failure, out, pareto};
use powergs_report::document::{Block, Document, Text};
use powergs_study::sweep::run::finish::{Finished, write_sources};
use powergs_study::sweep::run::results::{self, CSV, PARQUET, Tally};
use powergs_study::sweep::run::{Cause, OpenedSweep, Plan, SweepFolder};

/// What the analysis says on a terminal.
const ANSWER: &str = "analysis.txt";

/// How an answer begins where the question of the sweep file has none.
const NO_ANSWER: &str = "No analysis: ";

/// The summary for a terminal, kept so that a finished sweep says the same again.
const SUMMARY: &str = "summary.txt";

/// Writes everything that a finished sweep has, and says so.
///
/// # Errors
/// Exit code 2: the folder cannot be written.
pub fn finish(
    folder: &mut SweepFolder<'_>,
    path: &Path,
    sweep: &OpenedSweep<'_>,
    plan: &Plan,
    started: Started,
    context: &Context,
) -> Result<Exit, Failure> {
    let mut analysis = pareto::OfSweep::new(sweep);
    let (tally, table) = results::write(folder, sweep, plan, &mut |row| analysis.row(row))?;
    if tally.missing > 0 {
        let what = "results are missing; run it again with --resume";
        out::complain(format_args!("{}: {} designs: {what}", path.display(), tally.missing));
        return Ok(Exit::GoalMissed);
    }
    let store = folder.store;
    store.write(SUMMARY, summary(sweep, plan, tally).terminal(pareto::WIDTH).as_bytes())?;
    write_sources(sweep, store)?;
    store.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let answer = match analysis.answer(folder, path, sweep, plan, context) {
        Ok(answer) => answer,
        Err(pareto::Unanswered::Interrupted) => return Ok(Exit::Interrupted),
        // The table is whole all the same: a question can be asked anew.
        Err(pareto::Unanswered::Question(failure)) => format!("{NO_ANSWER}{failure}\n"),
        // A full disk, for instance: the sweep is not finished, and --resume makes the rest.
        Err(pareto::Unanswered::Failed(failure)) => return Err(failure),
    };
    store.write(ANSWER, answer.as_bytes())?;
    let finished = Finished::new(sweep, plan, tally, table);
    finished.write(store)?;
    say(&finished, path, context)
}

/// Whether a folder that is marked as finished has everything that is said of it.
pub fn is_whole(path: &Path) -> bool {
    let answer = fs::read_to_string(path.join(ANSWER));
    let answered =
        |answer: String| answer.starts_with(NO_ANSWER) || path.join(pareto::REPORT).is_file();
    path.join(SUMMARY).is_file() && answer.is_ok_and(answered)
}

/// What a sweep says of its results.
fn summary(sweep: &OpenedSweep<'_>, plan: &Plan, tally: Tally) -> Document {
    let s = |n: u64| if n == 1 { "" } else { "s" };
    let done = tally.ok + tally.failed;
    let mut designs = format!("{done} design{} and the baseline simulated", s(done));
    let [excluded, duplicates] =
        [&plan.excluded, &plan.duplicates].map(|counts| counts.values().sum::<u64>());
    for (n, what) in [
        (tally.failed, "of them failed"),
        (tally.invalid, "invalid"),
        (excluded, "excluded"),
        (duplicates, "duplicates"),
    ] {
        if n > 0 {
            designs += &format!(", {n} {what}");
        }
    }
    let mut items: Vec<Text> = Vec::new();
    let excluded = plan.excluded.iter().map(|(why, n)| format!("{n} excluded by {why}"));
    items.extend(excluded.map(Text::from));
    let duplicates = plan.duplicates.iter();
    items.extend(
        duplicates
            .map(|(axis, n)| format!("{n} duplicates: axis `{axis}` does not count there").into()),
    );
    items.extend(plan.causes.iter().map(|(cause, Cause { points, example: (point, why) })| {
        format!("{points} invalid: {cause}, e.g. point {point}: {why}").into()
    }));
    let carried = sweep.designs.space.carried();
    items.extend(carried.into_iter().map(|(key, expression)| {
        format!("carried along: {}", super::dry_run::carried(key, expression)).into()
    }));
    let mut page = Document::new();
    page.add(Block::Quote(sweep.file.question.trim().into()));
    page.paragraph(designs + ".");
    page.add(Block::List(items));
    page
}

/// Says what a finished sweep has.
///
/// Exit code 4 where the simulator contradicted itself.
///
/// # Errors
/// Those of standard output.
pub fn say(finished: &Finished, path: &Path, context: &Context) -> Result<Exit, Failure> {
    if context.global.json {
        out::json(&json(finished, path))?;
    } else if !context.global.quiet {
        let text = fs::read_to_string(path.join(SUMMARY)).unwrap_or_default();
        out::text(&text)?;
        let answer = fs::read_to_string(path.join(ANSWER)).unwrap_or_default();
        let (table, report) = (path.join(CSV), path.join(pareto::REPORT));
        let report = Some(report).filter(|r| r.exists());
        let report = report.map_or(String::new(), |r| format!("\nreport  {}\n", r.display()));
        out::text(&format!("Table: {}\n\n{answer}{report}", table.display()))?;
    }
    if finished.defects > 0 {
        out::complain(format_args!(
            "internal error: on {} designs the simulator contradicted itself; the column `reason` \
             of {} says how. This is a mistake in the simulator, not in your input; please \
             report it with the sweep file and the traces.",
            finished.defects,
            path.join(CSV).display()
        ));
        return Ok(Exit::Internal);
    }
    Ok(Exit::Done)
}

fn json(finished: &Finished, path: &Path) -> Value {
    json!({
        "folder": path.display().to_string(),
        "designs_ok": finished.ok,
        "designs_invalid": finished.invalid,
        "designs_failed": finished.failed,
        "designs_excluded": finished.excluded,
        "designs_with_internal_errors": finished.defects,
        "results_csv": path.join(CSV).display().to_string(),
        "results_parquet": path.join(PARQUET).display().to_string(),
    })
}
