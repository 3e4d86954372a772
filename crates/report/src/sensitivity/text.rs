//! The experiment for people: on the terminal (80 columns) and as a page.

use std::fmt::Write;

use crate::format::{shortened, significant, wrapped};
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_study::findings::sensitivity::{Change, Fixed, Row, Sensitivity, Side};

/// Traces beside each other on the terminal; more go below.
const ABREAST: usize = 2;
/// Columns of a number.
const CELL: usize = 6;
/// Columns of the knob.
const KNOB: usize = 27;
/// Changes below this are none.
const LEAST: f64 = 0.0005;
/// Widest line.
const WIDTH: usize = 80;

/// The table on the terminal, the rows that move nothing named below it.
pub fn terminal(all: &Sensitivity, folder: Option<&str>) -> String {
    let mut text = format!("what assumptions move on {}, %\n", all.machine);
    if let Some(note) = all.incomplete_note() {
        let _ = writeln!(text, "{note}");
    }
    for trace in &all.traces {
        let area = trace.base.area_mm2.map_or(String::new(), |a| format!(", {a:.2} mm2"));
        let base = (significant(trace.base.fps()), significant(trace.base.energy_mj()));
        let name = shortened(&trace.name, 30);
        let frames = match trace.frames {
            1 => "1 frame".to_owned(),
            n => format!("mean of {n} frames"),
        };
        let _ = writeln!(text, "  {name}: {} FPS, {} mJ{area}, {frames}", base.0, base.1);
    }
    for first in (0..all.traces.len()).step_by(ABREAST) {
        let columns: Vec<usize> = (first..(first + ABREAST).min(all.traces.len())).collect();
        text.push('\n');
        table(&mut text, all, &columns);
    }
    area(&mut text, all);
    let dead: Vec<&str> =
        all.rows.iter().filter(|r| shows(r) == Some(false)).map(|r| r.number.as_str()).collect();
    if !dead.is_empty() {
        let line = format!("below 0.05 % either way: {}", dead.join(" "));
        let _ = writeln!(text, "\n{}", wrapped(&line, WIDTH));
    }
    let fixed: Vec<&str> = all.fixed.iter().map(|f| f.number.as_str()).collect();
    if !fixed.is_empty() {
        let line = format!("no knob on this machine: {}", fixed.join(" "));
        let _ = writeln!(text, "{}", wrapped(&line, WIDTH));
    }
    if let Some(folder) = folder {
        let _ = writeln!(text, "\nreport  {folder}");
    }
    text
}

/// Whether a row has something to show; `None` if neither side is a machine.
fn shows(row: &Row) -> Option<bool> {
    let all = (0..row.base.len()).flat_map(|t| row.changes(t)).flatten();
    all.map(|c| c.largest() >= LEAST).reduce(|a, b| a || b)
}

fn table(text: &mut String, all: &Sensitivity, traces: &[usize]) {
    let one = traces.len() == 1;
    let _ = write!(text, "{:<5}{KNOB_TITLE:<KNOB$}", "");
    for &t in traces {
        let _ = write!(text, "{:>width$}", shortened(&all.traces[t].name, 22), width = 4 * CELL);
    }
    let _ = write!(text, "\n{:<5}{:<KNOB$}", "", "");
    for _ in traces {
        let _ = write!(text, "{:>w$}{:>w$}", "FPS", "energy", w = 2 * CELL);
    }
    let _ = write!(text, "\n{:<5}{:<KNOB$}", "", "");
    for _ in traces {
        let _ = write!(text, "{:>CELL$}{:>CELL$}{:>CELL$}{:>CELL$}", "low", "high", "low", "high");
    }
    let _ = writeln!(text, "{}", if one { "  low .. high" } else { "" });
    let moves = |row: &&Row| {
        let changes = traces.iter().flat_map(|&t| row.changes(t)).flatten();
        changes.map(|c| c.fps.abs().max(c.energy.abs())).any(|change| change >= LEAST)
    };
    for row in all.rows.iter().filter(moves) {
        let knob = shortened(&row.knob(), KNOB - 1);
        let _ = write!(text, "{:<5}{knob:<KNOB$}", row.number);
        for &t in traces {
            let [low, high] = row.changes(t);
            for of in [|c: Change| c.fps, |c: Change| c.energy] {
                let _ = write!(text, "{:>CELL$}{:>CELL$}", percent(low, of), percent(high, of));
            }
        }
        let values = if one { format!("  {}", shortened(&values(row), 22)) } else { String::new() };
        let _ = writeln!(text, "{}", values.trim_end_matches(' '));
    }
}

const KNOB_TITLE: &str = "knob";

/// Rows whose area moves.
fn area(text: &mut String, all: &Sensitivity) {
    let moves = |row: &&Row| row.changes(0).into_iter().flatten().any(|c| c.area.abs() >= LEAST);
    let rows: Vec<&Row> = all.rows.iter().filter(moves).collect();
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(text, "\n{:<5}{:<KNOB$}{:>w$}", "", "knob", "area", w = 2 * CELL);
    for row in rows {
        let [low, high] = row.changes(0).map(|c| percent(c, |c| c.area));
        let knob = shortened(&row.knob(), KNOB - 1);
        let _ = writeln!(text, "{:<5}{knob:<KNOB$}{low:>CELL$}{high:>CELL$}", row.number);
    }
}

/// `+12.3`, `-48.0`, `.` for what is no machine or has no such side.
fn percent(change: Option<Change>, of: impl Fn(Change) -> f64) -> String {
    let Some(change) = change else { return ".".into() };
    let percent = of(change) * 100.0;
    match percent.abs() {
        p if p < 0.05 => "0".into(),
        p if p >= 99.95 => format!("{percent:+.0}"),
        _ => format!("{percent:+.1}"),
    }
}

/// `0.39 .. 1`, or `-> all`.
fn values(row: &Row) -> String {
    match (&row.low, &row.high) {
        (Some(low), Some(high)) => format!("{} .. {}", low.value, high.value),
        (Some(low), None) => format!("{} ..", low.value),
        (None, Some(high)) => format!("{} -> {}", row.value, high.value),
        (None, None) => row.value.clone(),
    }
}

/// The page.
pub fn markdown(all: &Sensitivity, charts: &[Chart]) -> String {
    let mut text = format!("# What assumptions move on {}\n\n", all.machine);
    if let Some(note) = all.incomplete_note() {
        let _ = writeln!(text, "**{note}**\n");
    }
    text.push_str("| trace | frames | FPS | energy per frame, mJ | area, mm² |\n");
    text.push_str("|---|--:|--:|--:|--:|\n");
    for t in &all.traces {
        let area = t.base.area_mm2.map_or("-".into(), |a| format!("{a:.2}"));
        let (fps, energy) = (significant(t.base.fps()), significant(t.base.energy_mj()));
        let _ = writeln!(text, "| {} | {} | {fps} | {energy} | {area} |", t.name, t.frames);
    }
    for chart in charts {
        let _ = write!(text, "\n![{}]({}.png)\n", chart.title, chart.name);
    }
    text.push_str(
        "\nChanges in percent, knob turned down and up; by effect, the largest first.\n\n",
    );
    rows(&mut text, all);
    refused(&mut text, all);
    if !all.fixed.is_empty() {
        text.push_str("\n| no knob | | why |\n|---|---|---|\n");
        for Fixed { number, text: what, why } in &all.fixed {
            let _ = writeln!(text, "| {number} | {what} | {why} |");
        }
    }
    let _ = writeln!(text, "\npowergs-sim {TOOL_VERSION}, model {MODEL_VERSION}.");
    text
}

fn rows(text: &mut String, all: &Sensitivity) {
    text.push_str("| | assumption | knob | base | low, high |");
    for t in &all.traces {
        let _ = write!(text, " {0}: FPS | {0}: energy |", t.name);
    }
    text.push_str(" area |\n|---|---|---|---|---|");
    text.push_str(&"--:|".repeat(2 * all.traces.len() + 1));
    text.push('\n');
    for row in &all.rows {
        let mut with = row.on.as_ref().map_or(String::new(), |on| format!(" on {on}"));
        if !row.with.is_empty() {
            let _ = write!(with, " with `{}`", row.with.join("`, `"));
        }
        let keys = row.keys.join("`, `");
        let turned: Vec<&str> =
            [&row.low, &row.high].into_iter().flatten().map(|s| s.value.as_str()).collect();
        let _ = write!(
            text,
            "| {} | {} | `{keys}`{with} | {} | {} |",
            row.number,
            row.text,
            row.value,
            turned.join(", ")
        );
        let pair =
            |t: usize, of: fn(Change) -> f64| row.changes(t).map(|c| percent(c, of)).join(", ");
        for t in 0..all.traces.len() {
            let _ = write!(text, " {} | {} |", pair(t, |c| c.fps), pair(t, |c| c.energy));
        }
        let _ = writeln!(text, " {} |", pair(0, |c| c.area));
    }
}

/// Why some sides are no machine.
fn refused(text: &mut String, all: &Sensitivity) {
    let mut reasons = Vec::new();
    for row in &all.rows {
        for side in [&row.low, &row.high].into_iter().flatten() {
            if let Side { value, outcomes: Err(reason) } = side {
                let reason = reason.replace('|', "/");
                let keys = row.keys.join("`, `");
                reasons.push(format!("| {} | `{keys}` = {value} | {reason} |\n", row.number));
            }
        }
    }
    if !reasons.is_empty() {
        text.push_str("\n| no machine | | why |\n|---|---|---|\n");
        text.extend(reasons);
    }
}
