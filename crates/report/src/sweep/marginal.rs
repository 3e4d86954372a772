//! What the next square millimetre and the next milliwatt buy, step by step along the front.

use super::axis::Axis;
use super::measure::Measure;
use powergs_chart::{Bin, Chart, Colour, Mark, Panel, Rule, Scale, Words};
use powergs_study::analysis::marginal::{Marginal, Step};
use powergs_study::analysis::{Analysis, Goal};

const NAME: &str = "marginal";
const TITLE: &str = "What the next mm² and the next mW buy";
/// Panels on a page.
const MOST: usize = 4;

/// The chart; `None` where the front has no two designs to step between.
pub fn chart(analysis: &Analysis) -> Option<Chart> {
    if analysis.marginals.is_empty() {
        return None;
    }
    let shown = &analysis.marginals[..analysis.marginals.len().min(MOST)];
    let subtitle = "each step goes to the design that gains most per unit; dashed: the knee";
    let chart = Chart::new(NAME, TITLE, subtitle).columns(2);
    let low = shown.len() > 2;
    Some(shown.iter().fold(chart, |chart, marginal| chart.panel(panel(analysis, marginal, low))))
}

fn panel(analysis: &Analysis, marginal: &Marginal, low_panel: bool) -> Panel {
    let table = analysis.table;
    let price = |row: u32| marginal.price.of(table, row).unwrap_or(f64::NAN);
    let (first, last) = (&marginal.steps[0], &marginal.steps[marginal.steps.len() - 1]);
    let (low, high) = (price(first.from), price(last.to));
    let pad = 0.04 * (high - low);
    let unit = marginal.price.unit();
    let words = Measure::of(marginal.price.column()).words;
    let x = Scale::linear((low - pad).max(0.0), high + pad);
    let x = powergs_chart::Axis::new(format!("{words}, {unit}"), x).plain();
    let measure = Measure::of(&marginal.objective.name);
    let values = marginal.steps.iter().map(Step::value);
    let Axis { axis: mut y, factor } = Axis::of(&marginal.objective.name, values);
    let (_, name) = y.title.split_once(", ").unwrap_or(("", "per unit"));
    y.title = format!("{} per {unit}", name.replacen(" (log)", "", 1));
    let verb = match marginal.objective.goal {
        Goal::Maximize => "gained",
        Goal::Minimize => "saved",
    };
    let bin = |step: &Step| Bin {
        from: price(step.from),
        to: price(step.to),
        height: step.value() * factor,
        colour: Colour::SKY,
        label: format!("{} → {}", table.label(step.from), table.label(step.to)),
    };
    let bins = marginal.steps.iter().map(bin).collect();
    Panel::new(x, y.ticks(if low_panel { 3 } else { 6 }))
        .heading(Words::bold(format!("{} {verb} per {unit}", measure.words)))
        .mark(Mark::Histogram { bins, outlined: true })
        .dashed(Rule::X(price(analysis.knee)), Colour::VERMILION)
}
