//! `summary.md`: the answer as a page.

use std::fmt::Write;

use super::html::Provenance;
use super::measure::Measure;
use super::words;
use crate::format::significant;
use crate::summary::escaped;
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_study::analysis::Analysis;
use powergs_study::analysis::marginal::Neighbour;

/// The page, with links to `charts` in the same folder.
pub fn markdown(analysis: &Analysis, charts: &[Chart], provenance: &Provenance) -> String {
    let mut text = format!("# {}\n\n", escaped(&provenance.title));
    if !analysis.question.text.is_empty() {
        let _ = writeln!(text, "> {}\n", escaped(&analysis.question.text));
    }
    let scope = escaped(&analysis.question.scope.to_string());
    let table = escaped(&analysis.energy_table);
    let goals = escaped(&words::objectives(&analysis.question.objectives));
    let _ = writeln!(text, "{goals}; {scope}, energy table {table}.\n");
    for paragraph in answer(analysis) {
        let _ = writeln!(text, "{}\n", escaped(&paragraph));
    }
    for chart in charts {
        let _ = writeln!(text, "![{}]({}.png)\n", chart.title, chart.name);
    }
    front(&mut text, analysis);
    steps(&mut text, analysis, analysis.knee, &analysis.around_knee);
    if let Some(row) = analysis.baseline {
        steps(&mut text, analysis, row, &analysis.around_baseline);
    }
    stability(&mut text, analysis);
    axes(&mut text, analysis);
    let _ = writeln!(
        text,
        "## Limits\n\n{LIMITS}\n\nModel version {MODEL_VERSION}; powergs-sim {TOOL_VERSION}."
    );
    text
}

/// What every number here leaves out.
pub(super) const LIMITS: &str = "The front is that of the designs that were simulated, not of all \
that could be. Ranges scale by the front, so another condition can move the knee. Effects that \
the model leaves out are listed in docs/limits.md; every number is defined in docs/analysis.md.";

/// The answer, a paragraph each.
pub(super) fn answer(analysis: &Analysis) -> Vec<String> {
    let mut all = vec![words::funnel(analysis), words::knee(analysis).join(" ")];
    all.extend(words::named(analysis).map(|n| n.join(" ")));
    let marginals: Vec<String> =
        analysis.marginals.iter().map(|m| words::marginal(analysis, m)).collect();
    all.push(marginals.join(" "));
    all.push(words::stability(analysis));
    let flips = analysis.stability.alternatives.iter().filter_map(|a| words::flip(analysis, a));
    all.push(flips.collect::<Vec<_>>().join(" "));
    all.push(words::axes(analysis).join(" "));
    all.retain(|p| !p.is_empty());
    all
}

fn head(text: &mut String, title: &str, columns: &[String]) {
    let rules = "--:|".repeat(columns.len() - 1);
    let _ = writeln!(text, "## {title}\n\n| {} |\n|---|{rules}", columns.join(" | "));
}

/// Tables of the page: name, head, rows. The HTML page has the same.
pub(super) type Grid = (String, Vec<String>, Vec<Vec<String>>);

/// The designs of the front.
pub(super) fn front_grid(analysis: &Analysis) -> Grid {
    let objectives = &analysis.question.objectives;
    let mut head = vec!["design".to_owned()];
    head.extend(objectives.iter().map(|o| Measure::of(&o.name).words));
    head.extend(analysis.table.axes.iter().map(|(name, _)| name.clone()));
    let named = analysis.named.as_ref().map(|n| n.row).filter(|r| !analysis.front.contains(r));
    let row = |&row: &u32| {
        let knee = if row == analysis.knee { " (knee)" } else { "" };
        let mut cells = vec![format!("{}{knee}", analysis.table.label(row))];
        cells.extend(
            objectives
                .iter()
                .enumerate()
                .map(|(j, o)| Measure::of(&o.name).text(analysis.value(j, row))),
        );
        cells.extend(analysis.table.settings(row).iter().map(|(_, v)| (*v).to_owned()));
        cells
    };
    let rows = analysis.front.iter().take(FRONT_MAX).chain(&named).map(row).collect();
    let title = if analysis.front.len() > FRONT_MAX {
        format!("Front: the first {FRONT_MAX} of {}", analysis.front.len())
    } else {
        "Front".to_owned()
    };
    (title, head, rows)
}

/// Designs of the front that a page lists; `pareto.csv` has all.
const FRONT_MAX: usize = 200;

/// The top designs under every ranking.
pub(super) fn ranks_grid(analysis: &Analysis) -> Grid {
    let stability = &analysis.stability;
    let mut head = vec!["design".to_owned(), analysis.energy_table.clone()];
    head.extend(stability.alternatives.iter().map(|a| a.label.clone()));
    head.push("fronts".into());
    let row = |(i, &row): (usize, &u32)| {
        let point = analysis.table.points[row as usize];
        let on = stability.membership.iter().find(|(p, _)| *p == point).map_or(0, |(_, n)| *n);
        let mut cells = vec![analysis.table.label(row), (i + 1).to_string()];
        let rank = |r: Option<usize>| r.map_or("-".into(), |r| r.to_string());
        cells.extend(stability.alternatives.iter().map(|a| rank(a.ranks[i])));
        cells.push(format!("{on} of {}", stability.rankings()));
        cells
    };
    let rows = stability.top.iter().enumerate().map(row).collect();
    ("Ranks of the top designs".to_owned(), head, rows)
}

/// How alike the rankings are.
pub(super) fn stability_grid(analysis: &Analysis) -> Grid {
    let stability = &analysis.stability;
    let mut head: Vec<String> = ["ranked under", "Kendall τ", "Spearman ρ"].map(Into::into).into();
    let objectives = &analysis.question.objectives;
    head.extend(objectives.iter().map(|o| format!("τ of {}", Measure::of(&o.name).words)));
    head.push(format!("top {} kept", stability.top.len()));
    head.push(format!("front of {} kept", analysis.front.len()));
    head.extend(["break the condition".into(), "first".into()]);
    let number = |x: Option<f64>| x.map_or("-".into(), significant);
    let row = |a: &powergs_study::analysis::stability::Alternative| {
        let mut cells = vec![a.label.clone(), number(a.kendall), number(a.spearman)];
        cells.extend(a.objectives.iter().copied().map(number));
        cells.extend([a.top_kept, a.front_kept, a.broken].map(|n| n.to_string()));
        cells.push(a.winner.map_or("-".into(), |row| analysis.table.label(row)));
        cells
    };
    let rows = stability.alternatives.iter().map(row).collect();
    ("Rankings under other tables and traces".to_owned(), head, rows)
}

/// What the axes move.
pub(super) fn axes_grid(analysis: &Analysis) -> Grid {
    let objectives = &analysis.question.objectives;
    let mut head = vec!["axis".to_owned(), "values".to_owned()];
    for objective in objectives {
        let words = Measure::of(&objective.name).words;
        head.extend([format!("{words}: main effect, %"), format!("{words}: alone at most, %")]);
    }
    head.push("dead".into());
    let percent = |x: f64| significant(x * 100.0);
    let row = |axis: &powergs_study::analysis::axes::Axis| {
        let mut cells = vec![axis.name.clone(), axis.values.to_string()];
        for effect in &axis.effects {
            cells.extend([percent(effect.main), effect.alone.map_or("-".into(), percent)]);
        }
        cells.push(if axis.is_dead() { "yes" } else { "no" }.into());
        cells
    };
    ("Axes".to_owned(), head, analysis.axes.iter().map(row).collect())
}

fn grid(text: &mut String, (title, columns, rows): Grid) {
    if rows.is_empty() {
        return;
    }
    let columns: Vec<String> = columns.iter().map(|c| escaped(c)).collect();
    head(text, &title, &columns);
    for row in rows {
        let cells: Vec<String> = row.iter().map(|c| escaped(c)).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text.push('\n');
}

fn front(text: &mut String, analysis: &Analysis) {
    grid(text, front_grid(analysis));
    text.push_str("All columns of these designs: `pareto.csv`.\n\n");
}

fn steps(text: &mut String, analysis: &Analysis, row: u32, steps: &[Neighbour]) {
    if steps.is_empty() {
        return;
    }
    let _ = writeln!(text, "## One step from {}\n", escaped(&analysis.table.label(row)));
    for step in steps {
        let _ = writeln!(text, "- {}", escaped(&words::neighbour(analysis, row, step)));
    }
    text.push('\n');
}

fn stability(text: &mut String, analysis: &Analysis) {
    if !analysis.stability.alternatives.is_empty() {
        grid(text, stability_grid(analysis));
        grid(text, ranks_grid(analysis));
    }
}

fn axes(text: &mut String, analysis: &Analysis) {
    grid(text, axes_grid(analysis));
}
