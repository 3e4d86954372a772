//! The experiment for people: on the terminal (80 columns) and as a page.

use std::fmt::Write;

use crate::format::{rate, shortened, significant, wrapped};
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_study::findings::sensitivity::keys::{KeyRow, Keys, Reach, Status};
use powergs_study::findings::sensitivity::{Measure, Outcome};

/// Widest line.
const WIDTH: usize = 80;
/// Rows of a table on the terminal; all are in `summary.md`.
const MOST: usize = 30;
/// Columns of a number.
const CELL: usize = 7;

/// The tables on the terminal: numbers by elasticity, names, what moves nothing.
pub fn terminal(all: &Keys, folder: Option<&str>) -> String {
    let mut text = format!("what the keys of {} move, one at a time\n", all.machine);
    if let Some(note) = all.incomplete_note() {
        let _ = writeln!(text, "{note}");
    }
    for t in &all.traces {
        let frames = match t.frames {
            1 => "1 frame".to_owned(),
            n => format!("mean of {n} frames"),
        };
        let name = shortened(&t.name, 16);
        let _ = writeln!(text, "  {name}: {}, {frames}", costs(&t.base, all.display_fps));
    }
    numbers(&mut text, all);
    names(&mut text, all);
    let weak = list(all.of(Status::Weak));
    if !weak.is_empty() {
        let line = format!("below 0.05 %: {}", weak.join(", "));
        let _ = writeln!(text, "\n{}", wrapped(&line, WIDTH));
    }
    let dead = all.dead_by_reason();
    if !dead.is_empty() || !all.not_tried.is_empty() {
        text.push_str("\ndead on these frames\n");
    }
    for (why, rows) in dead {
        let line = format!("{}: {}", list(rows).join(", "), why.replace('`', ""));
        let _ = writeln!(text, "{}", indented(&line));
    }
    for n in &all.not_tried {
        let _ = writeln!(text, "{}", indented(&format!("{}: {}", n.keys, n.why.replace('`', ""))));
    }
    let fixed = list(all.of(Status::Fixed));
    if !fixed.is_empty() {
        let line = format!("no other value is a machine: {}", fixed.join(", "));
        let _ = writeln!(text, "\n{}", wrapped(&line, WIDTH));
    }
    if let Some(folder) = folder {
        let _ = writeln!(text, "\nreport  {folder}");
    }
    text
}

fn list<'a>(rows: impl IntoIterator<Item = &'a KeyRow>) -> Vec<&'a str> {
    rows.into_iter().map(|r| r.key.as_str()).collect()
}

/// `162 FPS, 3.86 mJ, 231 mW at 60 FPS, 4.03 mm2`.
fn costs(base: &Outcome, display_fps: f64) -> String {
    let area = base.area_mm2.map_or(String::new(), |a| format!(", {a:.2} mm2"));
    let (fps, mj) = (significant(base.fps()), significant(base.energy_mj()));
    let mw = significant(base.power_w * 1e3);
    format!("{fps} FPS, {mj} mJ, {mw} mW at {} FPS{area}", rate(display_fps))
}

fn indented(line: &str) -> String {
    let lines = wrapped(line, WIDTH - 4);
    let mut lines = lines.lines();
    let first = format!("  {}", lines.next().unwrap_or(""));
    lines.fold(first, |text, line| format!("{text}\n    {line}"))
}

fn numbers(text: &mut String, all: &Keys) {
    let mut rows: Vec<&KeyRow> = all.of(Status::Alive).filter(|r| r.is_number()).collect();
    rows.sort_by(|a, b| steepest(b).total_cmp(&steepest(a)));
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(text, "\nelasticity: d ln y / d ln x by differences of the step");
    let _ = write!(text, "{:<30}{:<12}{:<10}", "key", "value", "step, %");
    for m in Measure::ALL {
        let _ = write!(text, "{:>CELL$}", m.name());
    }
    text.push('\n');
    for row in rows.iter().take(MOST) {
        let (key, value) = (shortened(&row.key, 29), shortened(&row.value, 11));
        let line = format!("{key:<30}{value:<12}{:<10}", steps(row));
        let cells = Measure::ALL.map(|m| format!("{:>CELL$}", elasticity(row, m)));
        let _ = writeln!(text, "{line}{}", cells.concat());
    }
    more(text, rows.len());
}

fn more(text: &mut String, rows: usize) {
    if rows > MOST {
        let _ = writeln!(text, "and {} more in the report", rows - MOST);
    }
}

/// The largest elasticity of a key, without sign.
fn steepest(row: &KeyRow) -> f64 {
    let all = Measure::ALL.into_iter().filter_map(|m| row.elasticity(m));
    all.map(|e| e.value.abs()).fold(0.0, f64::max)
}

/// `+0.62`; `.` where there is none.
fn elasticity(row: &KeyRow, measure: Measure) -> String {
    match row.elasticity(measure).map(|e| e.value) {
        None => ".".into(),
        Some(e) if e.abs() < 0.0005 => "0".into(),
        Some(e) if e.abs() < 0.01 => format!("{e:+.3}"),
        Some(e) => format!("{e:+.2}"),
    }
}

/// `-10 +10`: the near steps in percent.
fn steps(row: &KeyRow) -> String {
    let percent = |ratio: f64| format!("{:+.0}", (ratio - 1.0) * 100.0);
    let all = row.reached(Reach::Near).filter_map(|(t, _)| t.ratio);
    all.map(percent).collect::<Vec<_>>().join(" ")
}

/// One line for each other name, with its changes.
fn names(text: &mut String, all: &Keys) {
    let mut lines = Vec::new();
    for row in all.of(Status::Alive).filter(|r| !r.is_number()) {
        let base = Outcome::mean(&row.base);
        for (turned, outcome) in row.reached(Reach::Name) {
            let changes = Measure::ALL.map(|m| m.change(&outcome, &base));
            let effect = changes.into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
            let label = format!("{}={}", row.key, turned.value);
            lines.push((effect, label, changes));
        }
    }
    if lines.is_empty() {
        return;
    }
    lines.sort_by(|a, b| b.0.total_cmp(&a.0));
    let _ = writeln!(text, "\nchange with another name, %");
    let _ = write!(text, "{:<52}", "key=name");
    for m in Measure::ALL {
        let _ = write!(text, "{:>CELL$}", m.name());
    }
    text.push('\n');
    for (_, label, changes) in lines.iter().take(MOST) {
        let cells = changes.map(|c| format!("{:>CELL$}", percent(c)));
        let _ = writeln!(text, "{:<52}{}", shortened(label, 51), cells.concat());
    }
    more(text, lines.len());
}

/// `+12.3`, `0`, `.` for what is no machine.
fn percent(change: Option<f64>) -> String {
    let Some(change) = change else { return ".".into() };
    match change.abs() * 100.0 {
        p if p < 0.05 => "0".into(),
        p if p >= 99.95 => format!("{:+.0}", change * 100.0),
        _ => format!("{:+.1}", change * 100.0),
    }
}

/// The page.
pub fn markdown(all: &Keys, charts: &[Chart]) -> String {
    let mut text = format!("# What the keys of {} move, one at a time\n\n", all.machine);
    if let Some(note) = all.incomplete_note() {
        let _ = writeln!(text, "**{note}**\n");
    }
    let _ = writeln!(
        text,
        "| trace | frames | FPS | energy per frame, mJ | power at {} FPS, mW | area, mm² |",
        rate(all.display_fps)
    );
    text.push_str("|---|--:|--:|--:|--:|--:|\n");
    for t in &all.traces {
        let area = t.base.area_mm2.map_or("-".into(), |a| format!("{a:.2}"));
        let (fps, energy) = (significant(t.base.fps()), significant(t.base.energy_mj()));
        let power = significant(t.base.power_w * 1e3);
        let _ =
            writeln!(text, "| {} | {} | {fps} | {energy} | {power} | {area} |", t.name, t.frames);
    }
    for chart in charts {
        let _ = write!(text, "\n![{}]({}.png)\n", chart.title, chart.name);
    }
    let _ = write!(text, "{ELASTICITIES}");
    for row in all.of(Status::Alive).filter(|r| r.is_number()) {
        number_row(&mut text, row);
    }
    name_rows(&mut text, all);
    nothing(&mut text, all);
    let _ = writeln!(text, "\npowergs-sim {TOOL_VERSION}, model {MODEL_VERSION}.");
    text
}

const ELASTICITIES: &str = "
Elasticity is `d ln y / d ln x` over the near values, changes are those at the far values, in
percent; of means over the traces.

| file | key | value | near | FPS | energy | power | area | far | FPS, % | energy, % | area, % |
|---|---|---|---|--:|--:|--:|--:|---|--:|--:|--:|
";

fn values(row: &KeyRow, reach: Reach) -> String {
    row.reached(reach).map(|(t, _)| t.value.as_str()).collect::<Vec<_>>().join(", ")
}

fn number_row(text: &mut String, row: &KeyRow) {
    let near = values(row, Reach::Near);
    let _ = write!(text, "| {} | `{}` | {} | {near} |", row.file, row.key, row.value);
    for m in Measure::ALL {
        let _ = write!(text, " {} |", elasticity(row, m));
    }
    let _ = write!(text, " {} |", values(row, Reach::Far));
    for m in [Measure::Fps, Measure::Energy, Measure::Area] {
        let _ = write!(text, " {} |", row.far(m).map(percent).join(", "));
    }
    text.push('\n');
}

fn name_rows(text: &mut String, all: &Keys) {
    let rows: Vec<&KeyRow> = all.of(Status::Alive).filter(|r| !r.is_number()).collect();
    if rows.is_empty() {
        return;
    }
    text.push_str("\n| file | key | value | other | FPS, % | energy, % | power, % | area, % |\n");
    text.push_str("|---|---|---|---|--:|--:|--:|--:|\n");
    for row in rows {
        let base = Outcome::mean(&row.base);
        for (turned, outcome) in row.reached(Reach::Name) {
            let _ =
                write!(text, "| {} | `{}` | {} | {} |", row.file, row.key, row.value, turned.value);
            for m in Measure::ALL {
                let _ = write!(text, " {} |", percent(m.change(&outcome, &base)));
            }
            text.push('\n');
        }
    }
}

/// What moves nothing, and what could not be turned.
fn nothing(text: &mut String, all: &Keys) {
    let keys = |rows: &[&KeyRow]| {
        rows.iter().map(|r| format!("`{}`", r.key)).collect::<Vec<_>>().join(", ")
    };
    let weak: Vec<&KeyRow> = all.of(Status::Weak).collect();
    if !weak.is_empty() {
        let _ = writeln!(text, "\nBelow 0.05 % on everything: {}.", keys(&weak));
    }
    let dead = all.dead_by_reason();
    if !dead.is_empty() || !all.not_tried.is_empty() {
        text.push_str("\n| dead on these frames | why |\n|---|---|\n");
    }
    for (why, rows) in dead {
        let _ = writeln!(text, "| {} | {why} |", keys(&rows));
    }
    for n in &all.not_tried {
        let _ = writeln!(text, "| {} | {} |", n.keys, n.why);
    }
    let fixed: Vec<&KeyRow> = all.of(Status::Fixed).collect();
    if !fixed.is_empty() {
        text.push_str("\n| no other value is a machine | tried | why |\n|---|---|---|\n");
    }
    for row in fixed {
        let turned = row.turns.last().map(|t| (t.value.as_str(), t.outcomes.as_ref().err()));
        let (value, why) = turned.unwrap_or(("", None));
        let why = why.map_or(String::new(), |why| why.replace('|', "/"));
        let _ = writeln!(text, "| `{}` | {value} | {why} |", row.key);
    }
}
