//! The experiment for people: on the terminal (80 columns) and as a page.

use std::fmt::Write;

use super::sample;
use crate::format::{shortened, significant, wrapped};
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_study::analysis::indices::{Estimate, Index};
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::interactions::{Interactions, Results};

/// Measures on the terminal; the page has all.
const SHOWN: [Measure; 3] = [Measure::Fps, Measure::Energy, Measure::Area];
const CELL: usize = 6;
const WIDTH: usize = 80;

/// The table on the terminal.
pub fn terminal(all: &Interactions, folder: Option<&str>) -> String {
    let method = match all.results {
        Results::Morris(_) => "Morris",
        Results::Sobol(_) => "Sobol",
    };
    let mut text = format!("how keys of {} act together, {method}\n", all.machine);
    if let Some(note) = all.incomplete_note() {
        let _ = writeln!(text, "{note}");
    }
    let _ = writeln!(text, "{}\n", wrapped(&format!("  {}", sample(all)), WIDTH));
    let head = match all.results {
        Results::Morris(_) => ["mu*", "sigma"],
        Results::Sobol(_) => ["first", "total"],
    };
    let _ = write!(text, "{:<28}{:<16}", "", "");
    for m in SHOWN {
        let _ = write!(text, "{:>w$}", m.name(), w = 2 * CELL);
    }
    let _ = write!(text, "\n{:<28}{:<16}", "key", "levels");
    for name in SHOWN.iter().flat_map(|_| head) {
        let _ = write!(text, "{name:>CELL$}");
    }
    text.push('\n');
    for i in all.order() {
        let factor = &all.factors[i];
        let (key, range) = (shortened(&factor.key, 27), shortened(&factor.range(), 15));
        let _ = write!(text, "{key:<28}{range:<16}");
        for m in SHOWN {
            for cell in cells(all, m, i) {
                let _ = write!(text, "{cell:>CELL$}");
            }
        }
        text.push('\n');
    }
    let _ = writeln!(text, "\n{}", wrapped(&reading(all), WIDTH));
    if let Some(folder) = folder {
        let _ = writeln!(text, "\nreport  {folder}");
    }
    text
}

/// Two numbers of a key; `.` for a measure that is not known.
fn cells(all: &Interactions, measure: Measure, i: usize) -> [String; 2] {
    let none = || [".".to_owned(), ".".to_owned()];
    match &all.results {
        Results::Morris(found) => found
            .iter()
            .find(|(m, _)| *m == measure)
            .map_or_else(none, |(_, e)| [e[i].mu_star, e[i].sigma].map(percent)),
        Results::Sobol(found) => found
            .iter()
            .find(|(m, _)| *m == measure)
            .map_or_else(none, |(_, e)| [share(&e.each[i].first), share(&e.each[i].total)]),
    }
}

fn percent(x: f64) -> String {
    if x.abs() < 0.05 { "0".into() } else { format!("{x:.1}") }
}

fn share(e: &Estimate) -> String {
    // What is 0 up to its sampling error may be below it.
    let value = if e.value.abs() < 0.005 { 0.0 } else { e.value };
    format!("{value:.2}")
}

/// What the numbers say as a whole.
fn reading(all: &Interactions) -> String {
    match &all.results {
        Results::Morris(_) => "mu* is the size of a key's effect over its levels, sigma how much \
            it depends on the others (or bends), in % of the machine as it is"
            .into(),
        Results::Sobol(found) => {
            let share = |m: Measure| {
                let (_, indices) = found.iter().find(|(other, _)| *other == m)?;
                let varies = indices.each.iter().any(|i| i.total.value > 0.0);
                varies.then(|| format!("{} {}", m.name(), interval(&indices.alone)))
            };
            let shares: Vec<String> = SHOWN.into_iter().filter_map(share).collect();
            let shares = shares.join(", ");
            format!("share of the variance that keys explain alone (95 % interval): {shares}")
        }
    }
}

/// The page, to be put below that of single keys.
pub fn markdown(all: &Interactions, charts: &[Chart]) -> String {
    let mut text = format!("# How keys of {} act together\n\n", all.machine);
    if let Some(note) = all.incomplete_note() {
        let _ = writeln!(text, "**{note}**\n");
    }
    let method = match all.results {
        Results::Morris(_) => "Elementary effects after Morris",
        Results::Sobol(_) => "Sobol indices",
    };
    let names: Vec<&str> = all.traces.iter().map(|t| t.name.as_str()).collect();
    let _ = writeln!(text, "{method} on {}: {}.", names.join(", "), sample(all));
    if all.redrawn > 0 {
        text.push_str(DRAWN_AGAIN);
    }
    let _ = writeln!(text, "{}.", reading(all).trim_end_matches('.').replace("mu*", "μ*"));
    for chart in charts {
        let _ = write!(text, "\n![{}]({}.png)\n", chart.title, chart.name);
    }
    text.push('\n');
    match &all.results {
        Results::Morris(found) => {
            table(&mut text, found.iter().map(|(m, _)| (*m, ["μ", "μ*", "σ"])));
            for i in all.order() {
                let cells = found.iter().flat_map(|(_, e)| [e[i].mu, e[i].mu_star, e[i].sigma]);
                row(&mut text, all, i, cells.map(significant));
            }
        }
        Results::Sobol(found) => {
            table(&mut text, found.iter().map(|(m, _)| (*m, ["first", "total"])));
            for i in all.order() {
                let cells = found.iter().flat_map(|(_, e)| {
                    let Index { first, total } = &e.each[i];
                    [interval(first), interval(total)]
                });
                row(&mut text, all, i, cells);
            }
        }
    }
    let _ = writeln!(text, "\npowergs-sim {TOOL_VERSION}, model {MODEL_VERSION}.");
    text
}

const DRAWN_AGAIN: &str = "\
Keys are independent only as far as machines exist: samples with a point that is none were
drawn again.
";

fn table<const N: usize>(
    text: &mut String,
    columns: impl Iterator<Item = (Measure, [&'static str; N])>,
) {
    let mut rule = String::from("|---|---|---|---|");
    text.push_str("| file | key | value | levels |");
    for (m, names) in columns {
        for name in names {
            let _ = write!(text, " {}: {name} |", m.name());
            rule.push_str("--:|");
        }
    }
    let _ = writeln!(text, "\n{rule}");
}

fn row(text: &mut String, all: &Interactions, i: usize, cells: impl Iterator<Item = String>) {
    let f = &all.factors[i];
    let levels = f.levels.join(", ");
    let _ = write!(text, "| {} | `{}` | {} | {levels} |", f.file, f.key, f.value);
    for cell in cells {
        let _ = write!(text, " {cell} |");
    }
    text.push('\n');
}

/// `0.62 (0.55 to 0.70)`.
fn interval(e: &Estimate) -> String {
    format!("{} ({:.2} to {:.2})", share(e), e.low, e.high)
}
