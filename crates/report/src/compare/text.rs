//! The comparison for people: on the terminal (80 columns) and as a page.

use std::fmt::Write;

use crate::format::{percent, rate, shortened, significant, wrapped};
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::action::{Stage, UnitKind};
use powergs_core::sim::MODEL_VERSION;
use powergs_study::findings::bottleneck;
use powergs_study::findings::compare::{Comparison, Measure, Note, Row, Side};
use powergs_study::findings::summary::{CycleSummary, UnitSummary};

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
        if let Some(found) = bottleneck::of(&side.summary) {
            let sentence = crate::bottleneck::sentence(&found);
            let sentence = format!("{}: {sentence}", shortened(&side.label, 40));
            let _ = writeln!(text, "{}", wrapped(&sentence, WIDTH));
        }
    }
    for note in &comparison.notes {
        let _ = writeln!(text, "{}", wrapped(&format!("note: {}", self::note(note)), WIDTH));
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
    let known = |m: &&Row| columns.iter().any(|&i| m.values[i].is_some());
    let rate = comparison.sides[0].display_fps;
    for row in comparison.rows.iter().filter(known) {
        line(text, rate, row, columns);
    }
    if !two {
        text.push_str("as multiples of the first\n");
        for row in comparison.rows.iter().filter(known) {
            let ratios: Vec<Option<f64>> = columns.iter().map(|&i| row.ratio(i)).collect();
            numbers(text, &words(row.measure, rate), &ratios);
            text.push('\n');
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

/// What a measure is called, with its unit; `rate` is the display rate of the first side.
fn words(measure: Measure, rate: f64) -> String {
    let words = match measure {
        Measure::FrameTime => "frame time, ms",
        Measure::FrameTimeP99 => "frame time, p99, ms",
        Measure::Throughput => "frames per second",
        Measure::Energy => "energy per frame, mJ",
        Measure::Power => return format!("power at {} FPS, W", crate::format::rate(rate)),
        Measure::PowerFullRate => "power at full rate, W",
        Measure::DramBytes => "DRAM, MB per frame",
        Measure::DramPeak => "DRAM peak, GB/s",
        Measure::Area => "area, mm2",
        Measure::FpsPerWatt => "FPS per W (frames per J)",
        Measure::FpsPerArea => "FPS per mm2",
        Measure::FpsPerBandwidth => "FPS per GB/s of peak",
        Measure::FpsAtArea => "FPS at the area of the first",
        Measure::FpsAtBandwidth => "FPS at the GB/s of the first",
    };
    words.to_owned()
}

/// What else differs, as a sentence without its full stop.
pub fn note(note: &Note) -> String {
    fn differ<T>(what: &str, values: &[T], of: impl Fn(&T) -> String, so: &str) -> String {
        let mut shown: Vec<String> = values.iter().map(of).collect();
        shown.dedup();
        format!("{what} differ ({}): {so}", shown.join(", "))
    }
    let file = |(name, hash): &(String, String)| format!("{name} {hash:.8}");
    match note {
        Note::Traces(v) => differ("traces", v, file, "the frames are not the same"),
        Note::FrameCounts(v) => {
            differ("frame counts", v, i64::to_string, "means are over other frames")
        }
        Note::Models(v) => differ("models", v, String::clone, "one of them has no time of its own"),
        Note::EnergyTables(v) => {
            differ("energy tables", v, String::clone, "joules have other prices")
        }
        Note::EnergyFiles(v) => {
            differ("files of the energy table", v, file, "joules have other prices")
        }
        Note::DisplayRates(v) => {
            differ("display rates", v, |fps| rate(*fps), "powers are for other rates")
        }
        Note::Versions(v) => differ(
            "versions",
            v,
            |(tool, model)| format!("{tool} model {model}"),
            "the same inputs may give other numbers",
        ),
        Note::SchemaVersions(v) => {
            differ("schema versions", v, i64::to_string, "some names have changed their meaning")
        }
        Note::DramModels(v) => {
            differ("DRAM models", v, String::clone, "times of DRAM are counted differently")
        }
        Note::Incomplete { label, frames } => {
            format!("{label} is INCOMPLETE: {frames} frames only")
        }
    }
}

/// The first column and a number per side.
fn numbers(text: &mut String, words: &str, values: &[Option<f64>]) {
    let _ = write!(text, "{words:<FIRST$}");
    for value in values {
        let _ = write!(text, "{:>COLUMN$}", value.map_or("-".to_owned(), significant));
    }
}

/// A measure of some of the sides; of two sides also their difference and ratio.
fn line(text: &mut String, rate: f64, measure: &Row, columns: &[usize]) {
    let values: Vec<Option<f64>> = columns.iter().map(|&i| measure.values[i]).collect();
    numbers(text, &words(measure.measure, rate), &values);
    if let [Some(a), Some(b)] = values.as_slice() {
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
        let values: Vec<Option<f64>> =
            columns.iter().map(|&i| of(&sides[i]).filter(|x| !x.is_nan())).collect();
        if values.iter().any(Option::is_some) {
            let cell = |v: Option<f64>| v.map_or("-".to_owned(), significant);
            rows.push((words, values.into_iter().map(cell).collect()));
        }
    };
    add("preprocessing, ms".into(), &|s| {
        let cycle = s.summary.cycle.as_ref()?;
        Some(cycle.preprocessing_cycles / cycle.frame_cycles * cycle.frame_time_ms)
    });
    for stage in Stage::ALL {
        let mj = |s: &Side| Some(s.summary.energy.stage(stage) * 1e-9);
        add(format!("{}, mJ", stage.name()), &mj);
    }
    for stage in Stage::WORK {
        let mb = |s: &Side| Some(s.summary.dram_bytes[stage as usize].sum() * 1e-6);
        add(format!("{}, DRAM MB", stage.name()), &mb);
    }
    rows
}

/// Shares of the cycles of each unit that are at least `least` for one of the sides.
fn stalls(sides: &[Side], columns: &[usize], least: f64) -> Vec<(String, Vec<String>)> {
    let mut lines = Vec::new();
    for unit in UnitKind::ALL {
        let of_unit = |cycle: &CycleSummary| cycle.units[unit as usize].shares();
        let shares: Vec<_> =
            columns.iter().map(|&i| sides[i].summary.cycle.as_ref().map(of_unit)).collect();
        for (part, name) in UnitSummary::PARTS.into_iter().enumerate() {
            let values: Vec<Option<f64>> = shares.iter().map(|s| s.map(|s| s[part])).collect();
            let shown = values.iter().flatten().any(|v| *v >= least && *v > 0.0);
            if shown && name != "idle" {
                let what = if part == 0 { "busy, %".into() } else { format!("waits: {name}, %") };
                let cell = |v: &Option<f64>| v.map_or("-".to_owned(), percent);
                lines.push((format!("{} {what}", unit.name()), values.iter().map(cell).collect()));
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
        let _ = writeln!(text, "**Note:** {}.\n", clean(&self::note(note)));
    }
    for side in &comparison.sides {
        if let Some(found) = bottleneck::of(&side.summary) {
            let sentence = crate::bottleneck::sentence(&found);
            let _ = writeln!(text, "- **{}**: {sentence}", clean(&side.label));
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
    for m in &comparison.rows {
        let cell = |v: &Option<f64>| v.map_or("-".to_owned(), significant);
        let ratio = |i| m.ratio(i).map_or(" - |".to_owned(), |r| format!(" {r:.3} |"));
        let ratios: String = (1..names.len()).map(ratio).collect();
        let values = m.values.iter().map(cell).collect::<Vec<_>>().join(" | ");
        let _ = writeln!(text, "| {} | {values} |{ratios}", words(m.measure, side.display_fps));
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
