//! `sweep status`, `sweep merge` and `sweep show`: what can be done with a sweep that is there.

use std::path::Path;

use serde_json::json;

use super::args::{MergeArgs, ShowArgs, StatusArgs};
use super::confirm::{self, SweepConfirm};
use super::finish;
use super::meter::Meter;
use super::run::allowed;
use crate::cli::invocation::Started;
use crate::cli::{Context, Exit, Failure, out};
use powergs_base::format::counted;
use powergs_core::run::FileStore;
use powergs_report::document::Document;
use powergs_study::sweep::design::Design;
use powergs_study::sweep::run::finish::Finished;
use powergs_study::sweep::run::parts::{FoundDesign, PartCount, find, parts_of, reopen, take_over};
use powergs_study::sweep::run::search::search;
use powergs_study::sweep::run::{Existing, OpenedSweep, Plan, SharedResults, SweepFolder};
use powergs_study::sweep::table::{Cell, FIRST};

/// The plan of a sweep, if the user lets it be made.
fn planned(sweep: &OpenedSweep<'_>, context: &Context) -> Result<Plan, Failure> {
    let meter = Meter::new(context);
    Plan::new(&sweep.designs, &meter).ok_or_else(interrupted)
}

fn interrupted() -> Failure {
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

/// `sweep show`.
///
/// # Errors
/// As [`status`], and for a design that is not there.
pub fn show(args: &ShowArgs, context: &Context) -> Result<Exit, Failure> {
    let sweep = reopen(&FileStore::new(&args.folder))?;
    let place = args.folder.display().to_string();
    let found = find(&sweep.designs, &args.id, &place, &Meter::new(context))?;
    let FoundDesign::Found(point, design) = found else { return Err(interrupted()) };
    let columns = sweep.designs.columns();
    let cells = sweep.designs.cells(point);
    if args.toml {
        out::text(&machine_file(&sweep, point, &design, &cells))?;
        return Ok(Exit::Done);
    }
    let name = point.map_or("baseline".to_owned(), |p| p.to_string());
    if context.global.json {
        let settings: serde_json::Map<String, serde_json::Value> =
            columns.iter().zip(&cells).map(|(c, cell)| (c.name.clone(), json_of(cell))).collect();
        out::json(&json!({
            FIRST[0].0: point, "id": format!("{:032x}", design.id), "settings": settings,
        }))?;
        return Ok(Exit::Done);
    }
    let mut text = format!("point  {name}\nid     {:032x}\n\n", design.id);
    let width = columns.iter().map(|c| c.name.len()).max().unwrap_or(0);
    for (column, cell) in columns.iter().zip(&cells) {
        text += &format!("{:width$}  {}\n", column.name, cell.text());
    }
    text += "\nIts machine file: --toml\n";
    out::text(&text)?;
    Ok(Exit::Done)
}

/// The machine file of a design, with what it is above it, and the keys of other files that the
/// sweep changes.
fn machine_file(
    sweep: &OpenedSweep<'_>,
    point: Option<u64>,
    design: &Design,
    cells: &[Cell],
) -> String {
    let name = point.map_or("Baseline".to_owned(), |p| format!("Point {p}"));
    let mut text = format!("# {name} of the sweep `{}`, {:032x}.\n", sweep.name, design.id);
    for (column, cell) in sweep.designs.columns().iter().zip(cells) {
        if column.name.contains(':') {
            text += &format!("# In another file: {} = {}\n", column.name, cell.text());
        } else if !column.name.ends_with(".si") {
            text += &format!("# {} = {}\n", column.name, cell.text());
        }
    }
    text + "\n" + &design.resolved_machine_toml()
}

fn json_of(cell: &Cell) -> serde_json::Value {
    match cell {
        Cell::Empty => serde_json::Value::Null,
        Cell::Text(text) => json!(text),
        Cell::Integer(n) => json!(n),
        Cell::Real(x) => json!(x),
        Cell::Truth(yes) => json!(yes),
    }
}
