//! The comparison for people: on the terminal (80 columns) and as a page.

use std::fmt::Write;

use super::{Comparison, Measure, Side};
use crate::bottleneck;
use crate::breakdown::CycleRow;
use crate::format::{percent, shortened, significant, wrapped};
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::action::Stage;
use powergs_core::sim::MODEL_VERSION;

/// Width of the first column.
const FIRST: usize = 28;
/// Width of a column of a side.
const COLUMN: usize = 13;
/// Sides beside each other; more go below.
const ABREAST: usize = 4;
/// Widest line.
const WIDTH: usize = 80;

/// What is printed: measures, stages, stalls, and a sentence per side.
pub fn terminal(comparison: &Comparison, folder: Option<&str>) -> String {
    let mut text = String::new();
    for first in (1..comparison.sides.len()).step_by(ABREAST - 1) {
        let last = (first + ABREAST - 1).min(comparison.sides.len());
        let columns: Vec<usize> = std::iter::once(0).chain(first..last).collect();
        table(&mut text, comparison, &columns);
        text.push('\n');
    }
    for side in &comparison.sides {
        if let Some(found) = bottleneck::of(&side.means) {
            let sentence = format!("{}: {}", shortened(&side.label, 40), found.sentence);
            let _ = writeln!(text, "{}", wrapped(&sentence, WIDTH));
        }
    }
    for note in &comparison.notes {
        let _ = writeln!(text, "{}", wrapped(&format!("note: {note}"), WIDTH));
    }
    if let Some(folder) = folder {
        let _ = writeln!(text, "\nreport  {folder}");
    }
    text
}

/// Measures, then stages and stalls of some of the sides.
fn table(text: &mut String, comparison: &Comparison, columns: &[usize]) {
    let two = columns.len() == 2;
    let _ = write!(text, "{:<FIRST$}", "");
    for &i in columns {
        let _ = write!(text, "{:>COLUMN$}", shortened(&comparison.sides[i].label, COLUMN - 1));
    }
    let _ = writeln!(
        text,
        "{}",
        if two { format!("{:>COLUMN$}{:>8}", "change", "ratio") } else { String::new() }
    );
    let known = |m: &&Measure| columns.iter().any(|&i| m.values[i].is_some());
    for measure in comparison.measures.iter().filter(known) {
        line(text, measure, columns, two);
    }
    if !two {
        text.push_str("as multiples of the first\n");
        for measure in comparison.measures.iter().filter(known) {
            let ratios = columns.iter().map(|&i| measure.ratio(i)).collect();
            let values = Measure { values: ratios, ..measure.clone() };
            line(text, &values, &(0..columns.len()).collect::<Vec<_>>(), false);
        }
    }
    text.push('\n');
    for (words, values) in stages(&comparison.sides, columns) {
        cells(text, &words, &values);
    }
    text.push('\n');
    // Below a twentieth the terminal says nothing; the page has them all.
    for (words, values) in stalls(&comparison.sides, columns, 0.05) {
        cells(text, &words, &values);
    }
}

fn line(text: &mut String, measure: &Measure, columns: &[usize], two: bool) {
    let values: Vec<Option<f64>> = columns.iter().map(|&i| measure.values[i]).collect();
    let cell = |v: Option<f64>| v.map_or("-".to_owned(), significant);
    let _ = write!(text, "{:<FIRST$}", measure.words);
    for value in &values {
        let _ = write!(text, "{:>COLUMN$}", cell(*value));
    }
    if let (true, [Some(a), Some(b)]) = (two, values.as_slice()) {
        let sign = if b > a { "+" } else { "" };
        let difference = format!("{sign}{}", significant(b - a));
        let ratio = measure.ratio(columns[1]).map_or("-".to_owned(), |r| format!("{r:.2}"));
        let _ = write!(text, "{difference:>COLUMN$}{ratio:>8}");
    }
    text.push('\n');
}

fn cells(text: &mut String, words: &str, values: &[String]) {
    let _ = write!(text, "{words:<FIRST$}");
    for value in values {
        let _ = write!(text, "{value:>COLUMN$}");
    }
    text.push('\n');
}

/// Phases, energy and bytes by stage: what the row is, and a cell per side.
fn stages(sides: &[Side], columns: &[usize]) -> Vec<(String, Vec<String>)> {
    let mut rows = Vec::new();
    let mut add = |words: String, of: &dyn Fn(&Side) -> Option<f64>| {
        let values: Vec<Option<f64>> = columns.iter().map(|&i| of(&sides[i])).collect();
        if values.iter().any(Option::is_some) {
            let cell = |v: Option<f64>| v.map_or("-".to_owned(), significant);
            rows.push((words, values.into_iter().map(cell).collect()));
        }
    };
    add("preprocessing, ms".into(), &|s| {
        let share = s.means.get("preprocessing_cycles")? / s.means.get("frame_cycles")?;
        Some(share * s.means.get("frame_time_ms")?)
    });
    for stage in Stage::ALL {
        let name = format!("energy_pj.{}", stage.name());
        add(format!("{}, mJ", stage.name()), &|s| Some(s.means.get(&name)? * 1e-9));
    }
    for stage in Stage::WORK {
        let path = |end: &str| format!("stages.{}.{end}", stage.name());
        let (read, write) = (path("dram_read_bytes"), path("dram_write_bytes"));
        add(format!("{}, DRAM MB", stage.name()), &|s| {
            Some((s.means.get(&read)? + s.means.get(&write)?) * 1e-6)
        });
    }
    rows
}

/// Shares of the cycles of each unit that are at least `least` for one of the sides.
fn stalls(sides: &[Side], columns: &[usize], least: f64) -> Vec<(String, Vec<String>)> {
    let rows: Vec<Vec<CycleRow>> =
        columns.iter().map(|&i| CycleRow::all(&sides[i].means)).collect();
    let mut lines = Vec::new();
    for unit in ["ccu", "qsu", "bsu", "vru"] {
        let of_unit =
            |rows: &Vec<CycleRow>| rows.iter().find(|r| r.unit == unit).map(|r| r.shares());
        let shares: Vec<_> = rows.iter().map(of_unit).collect();
        for (part, name) in CycleRow::PARTS.into_iter().enumerate() {
            let values: Vec<Option<f64>> = shares.iter().map(|s| s.map(|s| s[part])).collect();
            let shown = values.iter().flatten().any(|v| *v >= least && *v > 0.0);
            if shown && name != "idle" {
                let what = if part == 0 { "busy, %".into() } else { format!("waits: {name}, %") };
                let cell = |v: &Option<f64>| v.map_or("-".to_owned(), percent);
                lines.push((format!("{unit} {what}"), values.iter().map(cell).collect()));
            }
        }
    }
    lines
}

/// The page, with links to `charts` in the same folder.
pub fn markdown(comparison: &Comparison, charts: &[Chart]) -> String {
    let labels = comparison.labels();
    let clean = |text: &str| crate::summary::escaped(text);
    let names: Vec<String> = labels.iter().map(|l| clean(l)).collect();
    let mut text = format!("# {}\n\n", names.join(" against "));
    let side = &comparison.sides[0];
    let _ = writeln!(
        text,
        "{} frames of {}; model {}, version {MODEL_VERSION}; made with powergs-sim \
         {TOOL_VERSION}.\n",
        side.frames,
        clean(&side.trace),
        side.model
    );
    for note in &comparison.notes {
        let _ = writeln!(text, "**Note:** {}.\n", clean(note));
    }
    for side in &comparison.sides {
        if let Some(found) = bottleneck::of(&side.means) {
            let _ = writeln!(text, "- **{}**: {}", clean(&side.label), found.sentence);
        }
    }
    let head = |text: &mut String, title: &str, ratios: bool| {
        let more = if ratios {
            names[1..].iter().map(|n| format!(" {n} / {} |", names[0])).collect()
        } else {
            String::new()
        };
        let rules = "--:|".repeat(names.len() + if ratios { names.len() - 1 } else { 0 });
        let _ = writeln!(text, "\n## {title}\n\n| | {} |{more}\n|---|{rules}", names.join(" | "));
    };
    head(&mut text, "Measures", true);
    for m in &comparison.measures {
        let cell = |v: &Option<f64>| v.map_or("-".to_owned(), significant);
        let ratio = |i| m.ratio(i).map_or(" - |".to_owned(), |r| format!(" {r:.3} |"));
        let ratios: String = (1..names.len()).map(ratio).collect();
        let values = m.values.iter().map(cell).collect::<Vec<_>>().join(" | ");
        let _ = writeln!(text, "| {} | {values} |{ratios}", m.words);
    }
    text.push_str(ISO);
    let all: Vec<usize> = (0..names.len()).collect();
    head(&mut text, "Stages, per frame", false);
    for (words, values) in stages(&comparison.sides, &all) {
        let _ = writeln!(text, "| {words} | {} |", values.join(" | "));
    }
    head(&mut text, "Units, share of their cycles", false);
    for (words, values) in stalls(&comparison.sides, &all, 0.0) {
        let _ = writeln!(text, "| {words} | {} |", values.join(" | "));
    }
    text.push('\n');
    for chart in charts {
        let _ = writeln!(text, "![{}]({}.png)\n", chart.title, chart.name);
    }
    text.push_str(
        "Every statistic of every side: `compare.csv`; what it was made from: `run.toml`.\n",
    );
    text
}

const ISO: &str = "
At the area (the bandwidth) of the first: frames per second times the ratio of areas (peak rates), \
as if performance grew in proportion. It shows what a mm2 or a GB/s buys and is no simulation.
";
