//! `sweep status`, `sweep merge` and `sweep show`: what can be done with a sweep that is there.

use std::fs;
use std::path::Path;

use serde_json::json;

use super::args::{Definition, MergeArgs, ShowArgs, StatusArgs};
use super::finish;
use super::folder::{self, RECORDS, Shard, SweepFolder};
use super::opened::Opened;
use super::plan::Plan;
use super::records::Records;
use super::run::{plan, usage};
use super::search;
use super::state::State;
use super::store::Store;
use crate::cli::invocation::Started;
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_report::format::wrapped;
use powergs_study::sweep::design::Design;
use powergs_study::sweep::journal::Record;
use powergs_study::sweep::table::{Cell, FIRST};

/// What was typed to begin a sweep, in its folder.
const DEFINITION: &str = "definition.json";

impl SweepFolder {
    /// Keeps what the sweep was begun with, so that it can be opened from its folder alone.
    ///
    /// # Errors
    /// Exit code 2: the folder cannot be written.
    pub fn remember(&self, definition: &Definition) -> Result<(), Failure> {
        let absolute = |path: &str| {
            let exists = Path::new(path).exists() || path.contains(['*', '?', '[']);
            let whole = std::path::absolute(path).ok().filter(|_| exists);
            whole.map_or(path.to_owned(), |p| p.display().to_string())
        };
        let frames = definition.frames.map(|f| (f.start, f.end));
        let json = json!({
            "file": definition.file.as_deref().map(absolute),
            "traces": definition.traces.iter().map(|t| absolute(t)).collect::<Vec<_>>(),
            "frames": frames,
            "sets": definition.sets,
            "points": definition.points,
        });
        let text = serde_json::to_string_pretty(&json).or_exit(Exit::Internal, DEFINITION)?;
        crate::cli::aside::write_aside(&self.path.join(DEFINITION), |w| {
            w.write_all(text.as_bytes())
        })
    }
}

/// Opens the sweep of a folder.
fn reopened(path: &Path) -> Result<Opened, Failure> {
    let Some(then) = State::read(path)? else {
        return Err(usage(format_args!("{}: holds no sweep", path.display())));
    };
    let place = path.join(DEFINITION);
    let text = fs::read_to_string(&place).or_exit(Exit::BadInput, place.display())?;
    let wrong = || Failure::new(Exit::BadInput, format!("{}: damaged", place.display()));
    let json: serde_json::Value =
        serde_json::from_str(&text).or_exit(Exit::BadInput, place.display())?;
    let list =
        |key: &str| -> Option<Vec<String>> { serde_json::from_value(json[key].clone()).ok() };
    let frames: Option<(usize, Option<usize>)> =
        serde_json::from_value(json["frames"].clone()).map_err(|_| wrong())?;
    let definition = Definition {
        file: json["file"].as_str().map(str::to_owned),
        traces: list("traces").ok_or_else(wrong)?,
        frames: frames.map(|(start, end)| crate::cli::camera_file::FrameRange { start, end }),
        sets: list("sets").ok_or_else(wrong)?,
        points: json["points"].as_u64(),
    };
    let opened = Opened::open(&definition)?;
    folder::same(path, &then, &opened.state)?;
    Ok(opened)
}

/// The plan of a sweep, if the user lets it be made.
fn replanned(opened: &Opened, context: &Context) -> Result<Plan, Failure> {
    plan(opened, context).ok_or_else(|| Failure::new(Exit::Interrupted, "interrupted"))
}

/// How many results there are.
#[derive(Debug, Default)]
struct Count {
    ok: u64,
    failed: u64,
    missing: u64,
    /// Parts of the last division into shards that have something missing.
    parts: Vec<u32>,
}

fn count(opened: &Opened, plan: &Plan, records: &mut Records, of: u32) -> Result<Count, Failure> {
    let mut count = Count { failed: plan.invalid.len() as u64, ..Count::default() };
    for number in 1..=of {
        let before = count.missing;
        for &design in plan.machines(Shard { number, of }).iter().flatten() {
            let mut found = [false; 2];
            for trace in &opened.traces {
                for table in 0..plan.tables {
                    match records.get(plan.key(design as usize, table, trace.hash))? {
                        Some(Record::Ok(_)) => {}
                        Some(Record::Failed(_)) => found[0] = true,
                        None => found[1] = true,
                    }
                }
            }
            match found {
                [_, true] => count.missing += 1,
                [true, false] => count.failed += 1,
                [false, false] => count.ok += 1,
            }
        }
        if count.missing > before {
            count.parts.push(number);
        }
    }
    Ok(count)
}

/// How many parts the journals of a folder are of: the largest number that was used.
fn parts_of(path: &Path) -> u32 {
    let entries = fs::read_dir(path.join(RECORDS)).into_iter().flatten().flatten();
    let of = entries.filter_map(|e| {
        let name = e.file_name().to_string_lossy().into_owned();
        name.strip_suffix(".jsonl")?.rsplit_once("-of-")?.1.parse().ok()
    });
    of.max().unwrap_or(1)
}

/// `sweep status`.
///
/// # Errors
/// Exit code 2 or 3: a folder that holds no sweep, or one whose files have changed.
pub fn status(args: &StatusArgs, context: &Context) -> Result<Exit, Failure> {
    let path = &args.folder;
    let opened = reopened(path)?;
    let mut records = Records::open(&path.join(RECORDS), None)?;
    if opened.is_adaptive() {
        let known = records.index.len();
        let done = finish::Finished::read(path, &opened.state).is_some();
        let state = if done { "finished" } else { "not finished; run it again with --resume" };
        match context.global.json {
            true => out::json(&json!({ "results": known, "finished": done }))?,
            false => out::text(&format!("{known} results of an adaptive search, {state}\n"))?,
        }
        return Ok(Exit::Done);
    }
    let plan = replanned(&opened, context)?;
    let of = parts_of(path);
    let count = count(&opened, &plan, &mut records, of)?;
    let excluded: u64 = plan.excluded.values().sum();
    if context.global.json {
        out::json(&json!({
            "designs_ok": count.ok,
            "designs_failed": count.failed,
            "designs_missing": count.missing,
            "designs_excluded": excluded,
            "parts": of,
            "parts_missing": count.parts,
            "damaged_records": records.index.damaged,
            "finished": finish::Finished::read(path, &opened.state).is_some(),
        }))?;
        return Ok(Exit::Done);
    }
    let all = count.ok + count.failed + count.missing;
    let mut text = format!("{}\n\n", wrapped(opened.file.question.trim(), 80));
    text += &format!("Done        {} of {all} designs\n", count.ok + count.failed);
    if count.failed > 0 {
        text += &format!("            {} of them failed\n", count.failed);
    }
    text += &format!(
        "Left out    {excluded} by constraints, or because an axis does not count there\n"
    );
    if count.missing > 0 {
        text += &format!("Missing     {} designs", count.missing);
        let parts: Vec<String> = count.parts.iter().map(u32::to_string).collect();
        text += &match of {
            1 => "; run it again with --resume\n".to_owned(),
            _ => format!(", in parts {} of {of}\n", shortened(&parts)),
        };
    }
    out::text(&text)?;
    Ok(Exit::Done)
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
    let path = &args.folder;
    let mut opened = reopened(path)?;
    let mut folder = SweepFolder::open(path, &opened.state, folder::Existing::Resume, None)?;
    for from in &args.from {
        let Some(then) = State::read(from)? else {
            return Err(usage(format_args!("{}: holds no sweep", from.display())));
        };
        folder::same(from, &then, &opened.state)?;
        let mut records = Records::open(&from.join(RECORDS), None)?;
        let mut keys: Vec<u128> = records.index.keys().collect();
        keys.sort_unstable();
        for key in keys {
            if let Some(record) = records.get(key)? {
                folder.records.append(key, &record)?;
            }
        }
    }
    if opened.is_adaptive() {
        let mut store = Store::open(None, &opened.state, Shard::WHOLE)?;
        let plan = search::run(&mut opened, &mut folder, &mut store, 1 << 28, context)?;
        let Some(plan) = plan else { return Ok(Exit::Interrupted) };
        return finish::finish(&mut folder, &mut opened, &plan, started, context);
    }
    let plan = replanned(&opened, context)?;
    let of = parts_of(path);
    let count = count(&opened, &plan, &mut folder.records, of)?;
    if count.missing > 0 {
        let parts: Vec<String> = count.parts.iter().map(u32::to_string).collect();
        let what = format!(
            "{} designs are missing, in parts {} of {of}",
            count.missing,
            shortened(&parts)
        );
        out::complain(format_args!("{}: {what}; run those parts again", path.display()));
        return Ok(Exit::GoalMissed);
    }
    finish::finish(&mut folder, &mut opened, &plan, started, context)
}

/// `sweep show`.
///
/// # Errors
/// As [`status`], and for a design that is not there.
pub fn show(args: &ShowArgs, context: &Context) -> Result<Exit, Failure> {
    let opened = reopened(&args.folder)?;
    let (point, design) = found(&opened, args, context)?;
    let columns = opened.axis_columns();
    let cells = opened.axis_cells(point);
    if args.toml {
        out::text(&machine_file(&opened, point, &design, &cells))?;
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
fn machine_file(opened: &Opened, point: Option<u64>, design: &Design, cells: &[Cell]) -> String {
    let name = point.map_or("Baseline".to_owned(), |p| format!("Point {p}"));
    let mut text = format!("# {name} of the sweep `{}`, {:032x}.\n", opened.name, design.id);
    for (column, cell) in opened.axis_columns().iter().zip(cells) {
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

type Found = (Option<u64>, Design);

/// The design of an id, the beginning of one, or a number.
fn found(opened: &Opened, args: &ShowArgs, context: &Context) -> Result<Found, Failure> {
    if args.id == "baseline" {
        return Ok((None, opened.baseline()));
    }
    let points = opened.space.lattice().points();
    if let Some(point) = args.id.parse::<u64>().ok().filter(|&p| p < points && args.id.len() < 12) {
        let what = format!("point {point}");
        return Ok((Some(point), opened.space.design(point).or_exit(Exit::Usage, what)?));
    }
    let is_hex = args.id.len() >= 4 && args.id.chars().all(|c| c.is_ascii_hexdigit());
    if !is_hex {
        let what = "give an id of the table (4 digits of it at least), a point, or `baseline`";
        return Err(usage(format_args!("`{}`: {what}", args.id)));
    }
    let plan = replanned(opened, context)?;
    let begins = |id: u128| format!("{id:032x}").starts_with(&args.id.to_lowercase());
    let mut fits = plan.designs.iter().filter(|d| begins(d.id));
    let Some(first) = fits.next() else {
        return Err(usage(format_args!("no design `{}` in {}", args.id, args.folder.display())));
    };
    if fits.any(|d| d.id != first.id) {
        return Err(usage(format_args!(
            "several designs begin with `{}`: give more of it",
            args.id
        )));
    }
    let design = opened.design(first.point).or_exit(Exit::Internal, "design")?;
    Ok((first.point, design))
}
