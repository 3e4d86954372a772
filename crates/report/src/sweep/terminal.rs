//! The answer on a terminal of 80 columns.

use std::fmt::Write;

use super::energy::spread;
use super::measure::Measure;
use super::words;
use crate::format::{shortened, significant, wrapped};
use powergs_study::analysis::marginal::Neighbour;
use powergs_study::analysis::{Analysis, Goal};

/// Widest line.
const WIDTH: usize = 80;
/// Width of the names of designs.
const NAME: usize = 14;
/// Width of a column of values.
const VALUE: usize = 12;
/// Objectives that have a column.
const COLUMNS: usize = 3;
/// Steps of single axes that are printed for one design.
const STEPS: usize = 8;

/// What is printed: the front, the knee with its reason, the named design, marginal values, the
/// stability of the ranking.
pub fn terminal(analysis: &Analysis) -> String {
    let mut text = String::new();
    let paragraph = |text: &mut String, words: &str| {
        let _ = writeln!(text, "{}", wrapped(words, WIDTH));
    };
    if !analysis.question.text.is_empty() {
        paragraph(&mut text, &format!("question: {}", analysis.question.text));
    }
    let goals = words::objectives(&analysis.question.objectives);
    let scope = &analysis.question.scope;
    let table = &analysis.energy_table;
    paragraph(&mut text, &format!("{goals}; {scope}, energy table {table}"));
    paragraph(&mut text, &words::funnel(analysis));
    text.push('\n');
    front(&mut text, analysis);
    text.push('\n');
    paragraph(&mut text, &words::knee(analysis).join(" "));
    if let Some(named) = words::named(analysis) {
        paragraph(&mut text, &named.join(" "));
    }
    if !analysis.marginals.is_empty() {
        text.push_str("\nmarginal value along the front\n");
        for marginal in &analysis.marginals {
            paragraph(&mut text, &words::marginal(analysis, marginal));
        }
    }
    let baseline = analysis.baseline.map(|row| (row, &analysis.around_baseline));
    let around = std::iter::once((analysis.knee, &analysis.around_knee)).chain(baseline);
    for (row, steps) in around {
        steps_around(&mut text, analysis, row, steps);
    }
    stability(&mut text, analysis);
    let axes = words::axes(analysis);
    if !axes.is_empty() {
        let _ = writeln!(text, "\n{}", wrapped(&axes.join(" "), WIDTH));
    }
    text
}

fn front(text: &mut String, analysis: &Analysis) {
    let objectives = &analysis.question.objectives;
    let shown = objectives.len().min(COLUMNS);
    let rest = WIDTH - NAME - shown * (VALUE + 1) - 2;
    let _ = write!(text, "{:<NAME$}", "design");
    for objective in &objectives[..shown] {
        let goal = match objective.goal {
            Goal::Minimize => "↓",
            Goal::Maximize => "↑",
        };
        let words = Measure::of(&objective.name).words;
        let words = shortened(words.strip_suffix(" per frame").unwrap_or(&words), VALUE - 2);
        let _ = write!(text, " {:>VALUE$}", format!("{words} {goal}"));
    }
    let _ = writeln!(text, "  settings");
    let rows = spread(&analysis.front, analysis.question.top.max(2), analysis.knee);
    let named = analysis.named.as_ref().map(|n| n.row).filter(|row| !rows.contains(row));
    for &row in rows.iter().chain(&named) {
        let knee = if row == analysis.knee { " knee" } else { "" };
        let label = format!("{}{knee}", analysis.table.label(row));
        let _ = write!(text, "{:<NAME$}", shortened(&label, NAME));
        for (j, objective) in objectives[..shown].iter().enumerate() {
            let value = Measure::of(&objective.name).text(analysis.value(j, row));
            let _ = write!(text, " {value:>VALUE$}");
        }
        let _ = writeln!(text, "  {}", shortened(&short_settings(analysis, row), rest));
    }
    let hidden = analysis.front.len() - rows.len();
    if hidden > 0 {
        let _ = writeln!(text, "... and {hidden} more on the front: pareto.csv");
    }
}

/// Values with the last parts of their keys.
fn short_settings(analysis: &Analysis, row: u32) -> String {
    let one = |(key, value): (&str, &str)| {
        let key = key.rsplit(['.', ':']).next().unwrap_or(key);
        format!("{key}={}", value.replace(' ', ""))
    };
    let all = analysis.table.settings(row).into_iter().filter(|(_, value)| !value.is_empty());
    all.map(one).collect::<Vec<_>>().join(" ")
}

fn steps_around(text: &mut String, analysis: &Analysis, row: u32, steps: &[Neighbour]) {
    if steps.is_empty() {
        return;
    }
    let _ = writeln!(text, "\none step from {}", analysis.table.label(row));
    for step in steps.iter().take(STEPS) {
        let line = wrapped(&words::neighbour(analysis, row, step), WIDTH - 4);
        let _ = writeln!(text, "  {}", line.replace('\n', "\n    "));
    }
    if steps.len() > STEPS {
        let _ = writeln!(text, "  ... and {} more: summary.md", steps.len() - STEPS);
    }
}

fn stability(text: &mut String, analysis: &Analysis) {
    let stability = &analysis.stability;
    text.push_str("\nstability of the ranking\n");
    if !stability.alternatives.is_empty() {
        let top = format!("top {}", stability.top.len());
        let front = format!("front of {}", analysis.front.len());
        let _ = writeln!(
            text,
            "{:<28} {:>10} {:>8} {:>13} {:>12}",
            "ranked under", "Kendall", top, front, "first"
        );
    }
    for a in &stability.alternatives {
        let tau = a.kendall.map_or("-".into(), significant);
        let first = a.winner.map_or("-".into(), |row| analysis.table.label(row));
        let _ = writeln!(
            text,
            "{:<28} {tau:>10} {:>8} {:>13} {first:>12}",
            shortened(&a.label, 28),
            a.top_kept,
            a.front_kept
        );
    }
    let _ = writeln!(text, "{}", wrapped(&words::stability(analysis), WIDTH));
    for alternative in &stability.alternatives {
        if let Some(why) = words::flip(analysis, alternative) {
            let _ = writeln!(text, "{}", wrapped(&why, WIDTH));
        }
        if alternative.broken > 0 {
            let (n, label) = (alternative.broken, &alternative.label);
            let line = format!("With {label}, {n} of the front break the condition.");
            let _ = writeln!(text, "{}", wrapped(&line, WIDTH));
        }
    }
}
