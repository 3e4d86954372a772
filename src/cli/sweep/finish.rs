//! The end of a sweep: its table, what is said of it, and a note that it is whole.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::confirm::{self, SweepConfirm};
use crate::cli::invocation::Started;
use crate::cli::{Context, Exit, Failure, dram_model, out, pareto};
use powergs_base::format::counted;
use powergs_report::document::{Block, Document, Shown};
use powergs_study::sweep::run::finish::{Finished, write_sources};
use powergs_study::sweep::run::results::{self, CSV, PARQUET, Planned, Tally};
use powergs_study::sweep::run::{Cause, OpenedSweep, Plan, SweepFolder};

/// How many designs there were and why not more: a sentence a line, kept so that a finished sweep
/// says the same again.
const SUMMARY: &str = "summary.txt";

/// Writes everything that a finished sweep has, and says so.
///
/// # Errors
/// Exit code 2: the folder cannot be written.
pub fn finish(
    folder: &mut SweepFolder<'_>,
    path: &Path,
    sweep: &mut OpenedSweep<'_>,
    plan: &Plan,
    confirm: SweepConfirm<'_>,
    started: Started,
    context: &Context,
) -> Result<Exit, Failure> {
    let most = confirm.most;
    confirm::forget(path)?;
    let interrupted = || {
        let what = "interrupted; what is done is kept: go on with --resume, or merge again";
        let less = if most > 0 { "; --confirm 0 leaves `banked` out" } else { "" };
        out::complain(format_args!("{}: {what}{less}", path.display()));
        Ok(Exit::Interrupted)
    };
    let mut confirmed = Ok(None);
    if most > 0 {
        let mut analysis = pareto::OfSweep::new(sweep, most);
        let all = Planned::of(plan);
        let tally = results::each_row(sweep, all, &mut folder.records, |row| {
            analysis.row(&row);
            Ok(())
        })?;
        if tally.missing == 0 {
            confirmed = analysis.confirmed(folder, path, sweep, plan, confirm, context);
        }
    }
    let (confirmed, unanswered) = match confirmed {
        Ok(confirmed) => (confirmed, None),
        Err(pareto::Unanswered::Interrupted) => return interrupted(),
        Err(pareto::Unanswered::Failed(failure)) => return Err(failure),
        Err(pareto::Unanswered::Question(failure)) => (None, Some(failure)),
    };
    let planned = Planned { plan, confirmed: confirmed.as_ref().map(|(plan, _)| plan) };
    let mut analysis = pareto::OfSweep::new(sweep, most);
    let (tally, table) = results::write(folder, sweep, planned, &mut |row| analysis.row(row))?;
    if tally.missing > 0 {
        let what = "results are missing; run it again with --resume";
        out::complain(format_args!(
            "{}: {}: {what}",
            path.display(),
            counted(tally.missing, "design")
        ));
        return Ok(Exit::GoalMissed);
    }
    let store = folder.store;
    store.write(SUMMARY, summary(sweep, plan, tally).as_bytes())?;
    write_sources(sweep, store)?;
    store.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let confirmation = confirmed.as_ref().map(|(_, confirmation)| confirmation);
    let answer = match unanswered {
        Some(failure) => Err(pareto::Unanswered::Question(failure)),
        None => analysis.answer(folder, path, sweep, planned, confirmation, context),
    };
    let answer = match answer {
        Ok(answer) => Ok(answer),
        Err(pareto::Unanswered::Interrupted) => return interrupted(),
        // The table is whole all the same: a question can be asked anew.
        Err(pareto::Unanswered::Question(failure)) => Err(failure),
        // A full disk, for instance: the sweep is not finished, and --resume makes the rest.
        Err(pareto::Unanswered::Failed(failure)) => return Err(failure),
    };
    let finished = Finished::new(sweep, plan, tally, table, answer.is_ok(), most);
    finished.write(store)?;
    say(&finished, answer, path, context)
}

/// Whether a folder that is marked as finished has everything that is said of it, with `most`
/// designs confirmed.
pub fn is_whole(finished: &Finished, most: u16, path: &Path) -> bool {
    let confirmed = most == 0 || path.join(confirm::JSON).is_file();
    let answered = path.join(pareto::REPORT).is_file() && confirmed;
    path.join(SUMMARY).is_file() && finished.confirm == most && (answered || !finished.answered)
}

/// Says once more what a finished sweep has.
///
/// # Errors
/// Those of standard output.
pub fn again(finished: &Finished, path: &Path, context: &Context) -> Result<Exit, Failure> {
    say(finished, pareto::once_more(path), path, context)
}

/// What a sweep says of its designs, a sentence a line.
fn summary(sweep: &OpenedSweep<'_>, plan: &Plan, tally: Tally) -> String {
    let done = counted(tally.ok + tally.failed, "design");
    let mut designs = format!("{done} and the baseline simulated");
    let [excluded, duplicates] =
        [&plan.excluded, &plan.duplicates].map(|counts| counts.values().sum::<u64>());
    for (n, what) in [
        (tally.failed, "of them failed"),
        (tally.invalid, "invalid"),
        (excluded, "excluded"),
        (duplicates, if duplicates == 1 { "duplicate" } else { "duplicates" }),
    ] {
        if n > 0 {
            designs += &format!(", {n} {what}");
        }
    }
    let mut lines = vec![designs + "."];
    lines.extend(plan.excluded.iter().map(|(why, n)| format!("{n} excluded by {why}")));
    lines.extend(plan.duplicates.iter().map(|(axis, n)| {
        format!("{}: axis `{axis}` does not count there", counted(n, "duplicate"))
    }));
    lines.extend(plan.causes.iter().map(|(cause, Cause { points, example: (point, why) })| {
        format!("{points} invalid: {cause}, e.g. point {point}: {why}")
    }));
    let baseline = sweep.designs.base_is_first.as_ref().map(super::dry_run::baseline);
    lines.extend(baseline.map(|what| format!("Baseline: {what}")));
    lines.extend(sweep.is_calibrated.then(|| dram_model::NOTE.to_owned()));
    let carried = sweep.designs.space.carried();
    lines.extend(carried.into_iter().map(|(key, expression)| {
        format!("carried along: {}", super::dry_run::carried(key, expression))
    }));
    let one_line = |line: String| line.split_whitespace().collect::<Vec<_>>().join(" ") + "\n";
    lines.into_iter().map(one_line).collect()
}

/// Says what a finished sweep has: `answer` is its analysis, or why there is none.
///
/// Exit code 4 where the simulator contradicted itself.
///
/// # Errors
/// Those of standard output.
fn say(
    finished: &Finished,
    answer: Result<Document, Failure>,
    path: &Path,
    context: &Context,
) -> Result<Exit, Failure> {
    if context.global.json {
        out::json(&json(finished, path))?;
    } else if !context.global.quiet {
        let text = fs::read_to_string(path.join(SUMMARY)).unwrap_or_default();
        let mut lines = text.lines();
        let mut page = Document::new();
        page.paragraph(lines.next().unwrap_or_default());
        page.add(Block::List(lines.map(Into::into).collect()));
        match answer {
            Ok(answer) => page.extend(answer),
            Err(failure) => page.paragraph(format!("No analysis: {failure}")),
        }
        let places = [
            ("table", path.join(CSV)),
            ("confirmed", path.join(confirm::CSV)),
            ("report", path.join(pareto::REPORT)),
        ];
        let places = places.into_iter().filter(|(_, path)| path.exists());
        let places = places.map(|(name, path)| (name.into(), path.display().to_string().into()));
        page.on(Shown::Terminal, Block::Facts(places.collect()));
        out::document(&page)?;
    }
    if finished.defects > 0 {
        out::complain(format_args!(
            "internal error: on {} the simulator contradicted itself; the column `reason` \
             of {} says how. This is a mistake in the simulator, not in your input; please \
             report it with the sweep file and the traces.",
            counted(finished.defects, "design"),
            path.join(CSV).display()
        ));
        return Ok(Exit::Internal);
    }
    Ok(Exit::Done)
}

fn json(finished: &Finished, path: &Path) -> Value {
    let confirmed = fs::read(path.join(confirm::JSON)).ok();
    let confirmed: Value =
        confirmed.and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
    json!({
        "folder": path.display().to_string(),
        "designs_ok": finished.ok,
        "designs_invalid": finished.invalid,
        "designs_failed": finished.failed,
        "designs_excluded": finished.excluded,
        "designs_with_internal_errors": finished.defects,
        "confirmed": confirmed,
        "results_csv": path.join(CSV).display().to_string(),
        "results_parquet": path.join(PARQUET).display().to_string(),
    })
}
