//! What the next square millimetre and the next milliwatt buy, step by step along the front.

use super::measure::Measure;
use powergs_chart::{Bin, Chart, Colour, Entry, Mark, Panel, Rule, Scale, Symbol, Words};
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
    let subtitle = "along the Pareto front; width: what a step costs, height: what a unit of it \
                    buys, area: the gain";
    let chart = Chart::new(NAME, TITLE, subtitle)
        .columns(2)
        .legend([Entry::new("knee", Symbol::Dashed(Colour::VERMILION))]);
    let low = shown.len() > 2;
    Some(shown.iter().fold(chart, |chart, marginal| chart.panel(panel(analysis, marginal, low))))
}

fn panel(analysis: &Analysis, marginal: &Marginal, low_panel: bool) -> Panel {
    let table = analysis.table;
    let price = |row: u32| marginal.price.of(table, row).unwrap_or(f64::NAN);
    let (first, last) = (&marginal.steps[0], &marginal.steps[marginal.steps.len() - 1]);
    // Both axes begin at zero: the area of a bar is what its step gains.
    let (low, high) = (price(first.from), price(last.to));
    let above = |row: u32| price(row) - low;
    let unit = marginal.price.unit();
    let words = Measure::of(marginal.price.column()).words;
    let cheapest = table.label(first.from);
    let title = format!("{words} above that of {cheapest}, {unit}");
    let x = powergs_chart::Axis::new(title, Scale::linear(0.0, 1.03 * (high - low))).plain();
    let measure = Measure::of(&marginal.objective.name);
    let highest = marginal.steps.iter().map(Step::value).fold(0.0, f64::max);
    let (factor, name) = measure.axis(highest);
    let (_, name) = name.rsplit_once(", ").unwrap_or(("", "gain"));
    let name = format!("{name} per {unit}");
    let y = powergs_chart::Axis::new(name, Scale::from_zero(1.02 * highest * factor));
    let verb = match marginal.objective.goal {
        Goal::Maximize => "gained",
        Goal::Minimize => "saved",
    };
    let bin = |step: &Step| Bin {
        from: above(step.from),
        to: above(step.to),
        height: step.value() * factor,
        colour: Colour::SKY,
        label: format!("{} → {}", table.label(step.from), table.label(step.to)),
    };
    let bins = marginal.steps.iter().map(bin).collect();
    Panel::new(x, y.ticks(if low_panel { 3 } else { 6 }))
        .heading(Words::bold(format!("{} {verb} per {unit}", measure.words)))
        .mark(Mark::Histogram { bins, outlined: true })
        .dashed(Rule::X(above(analysis.knee)), Colour::VERMILION)
}
