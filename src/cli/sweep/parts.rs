//! `sweep status` and `sweep merge`: what can be done with a sweep that is there.

use std::path::Path;

use serde_json::json;

use super::args::{MergeArgs, StatusArgs};
use super::confirm::{self, SweepConfirm};
use super::finish;
use super::meter::Meter;
use super::run::allowed;
use crate::cli::invocation::Started;
use crate::cli::{Context, Exit, Failure, out};
use powergs_base::format::counted;
use powergs_core::run::FileStore;
use powergs_report::document::Document;
use powergs_study::sweep::run::finish::Finished;
use powergs_study::sweep::run::parts::{PartCount, parts_of, reopen, take_over};
use powergs_study::sweep::run::search::search;
use powergs_study::sweep::run::{Existing, HandOut, OpenedSweep, Plan, SharedResults, SweepFolder};

/// The plan of a sweep, if the user lets it be made.
fn planned(sweep: &OpenedSweep<'_>, context: &Context) -> Result<Plan, Failure> {
    let meter = Meter::new(context);
    Plan::new(&sweep.designs, &meter).ok_or_else(interrupted)
}

pub(super) fn interrupted() -> Failure {
    Failure::new(Exit::Interrupted, "interrupted")
}

/// `sweep status`.
///
/// # Errors
/// Exit code 2 or 3: a folder that holds no sweep, or one whose files have changed.
pub fn status(args: &StatusArgs, context: &Context) -> Result<Exit, Failure> {
    let path = &args.folder;
    let store = FileStore::new(path);
    let sweep = reopen(&store)?;
    let mut records = SweepFolder::records_of(&store)?;
    if sweep.designs.is_adaptive() {
        let known = records.len();
        let done = Finished::read(&store, &sweep.state).is_some();
        let state = if done { "finished" } else { "not finished; run it again with --resume" };
        match context.global.json {
            true => out::json(&json!({ "results": known, "finished": done }))?,
            false => out::text(&format!("{known} results of an adaptive search, {state}\n"))?,
        }
        return Ok(Exit::Done);
    }
    let plan = planned(&sweep, context)?;
    let of = parts_of(&store);
    let count = PartCount::of(&sweep, &plan, &mut records, of)?;
    let excluded: u64 = plan.excluded.values().sum();
    if context.global.json {
        out::json(&json!({
            "designs_ok": count.ok,
            "designs_invalid": count.invalid,
            "designs_failed": count.failed,
            "designs_missing": count.missing,
            "designs_excluded": excluded,
            "parts": of,
            "parts_missing": count.parts,
            "damaged_records": records.damaged(),
            "finished": Finished::read(&store, &sweep.state).is_some(),
        }))?;
        return Ok(Exit::Done);
    }
    let all = count.ok + count.failed + count.missing;
    let mut facts = vec![("Simulated", format!("{} of {all} designs", count.ok + count.failed))];
    if count.failed > 0 {
        facts.push(("Failed", format!("{} of them: the simulation went wrong", count.failed)));
    }
    if count.invalid > 0 {
        facts.push(("Invalid", format!("{} configurations that cannot exist", count.invalid)));
    }
    if excluded > 0 {
        facts.push(("Excluded", format!("{excluded} by constraints")));
    }
    let duplicates: u64 = plan.duplicates.values().sum();
    if duplicates > 0 {
        facts.push(("Duplicates", format!("{duplicates} where an axis does not count")));
    }
    if !count.parts.is_empty() {
        let parts: Vec<String> = count.parts.iter().map(u32::to_string).collect();
        let what = match of {
            1 => "; run it again with --resume".to_owned(),
            _ => format!(", in parts {} of {of}", shortened(&parts)),
        };
        facts.push(("Missing", missing(&count) + &what));
    } else if Finished::read(&store, &sweep.state).is_none() {
        facts.push(("Missing", "the analysis; run it again with --resume".into()));
    }
    let mut page = Document::new();
    page.paragraph(sweep.file.question.trim());
    page.facts(facts);
    out::document(&page)?;
    Ok(Exit::Done)
}

/// What has no results yet.
fn missing(count: &PartCount) -> String {
    match count.missing {
        0 => "the baseline".to_owned(),
        n => counted(n, "design"),
    }
}

fn shortened(parts: &[String]) -> String {
    let more = parts.len().saturating_sub(12);
    let mut text = parts[..parts.len() - more].join(", ");
    if more > 0 {
        text += &format!(" and {more} more");
    }
    text
}

/// `sweep merge`.
///
/// # Errors
/// As [`status`], and where the folder cannot be written.
pub fn merge(args: &MergeArgs, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    let path: &Path = &args.folder;
    let store = FileStore::new(path);
    let mut sweep = reopen(&store)?;
    // With paths as they were typed, whichever process finishes the sweep.
    sweep.hand_out = HandOut::read(&store).or(sweep.hand_out);
    let mut folder = SweepFolder::open(&store, &sweep.state, Existing::Resume, None)?;
    for from in &args.from {
        take_over(&mut folder, &sweep, &FileStore::new(from))?;
    }
    let most = confirm::most(args.confirm, &sweep);
    let memory = allowed(&mut sweep, context);
    let mut shared = SharedResults::default();
    if sweep.designs.is_adaptive() {
        let meter = Meter::new(context);
        let plan = search(&mut sweep, &mut folder, &mut shared, memory, &meter)?;
        drop(meter);
        let Some(plan) = plan else { return Ok(Exit::Interrupted) };
        let confirm = SweepConfirm { most, shared: &mut shared, memory };
        return finish::finish(&mut folder, path, &mut sweep, &plan, confirm, started, context);
    }
    let plan = planned(&sweep, context)?;
    let of = parts_of(&store);
    let count = PartCount::of(&sweep, &plan, &mut folder.records, of)?;
    if !count.parts.is_empty() {
        let parts: Vec<String> = count.parts.iter().map(u32::to_string).collect();
        let (missing, parts) = (missing(&count), shortened(&parts));
        let what = format!("no results of {missing}, in parts {parts} of {of}");
        out::complain(format_args!("{}: {what}; run those parts again", path.display()));
        return Ok(Exit::GoalMissed);
    }
    let confirm = SweepConfirm { most, shared: &mut shared, memory };
    finish::finish(&mut folder, path, &mut sweep, &plan, confirm, started, context)
}
