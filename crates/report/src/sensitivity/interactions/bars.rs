//! Sobol indices as bars with their intervals: first order beside total, one panel a measure.

use super::subtitle;
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale};
use powergs_study::analysis::indices::{Index, Indices};
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::interactions::Interactions;

const NAME: &str = "sobol";
const TITLE: &str = "Which keys explain the variance";
/// First order, total.
const COLOURS: [Colour; 2] = [Colour::BLUE, Colour::ORANGE];
/// Keys that a slide has room for.
const MOST: usize = 16;
const PANELS: [Measure; 3] = [Measure::Fps, Measure::Energy, Measure::Area];

/// The chart; `None` if no measure varies.
pub(super) fn chart(all: &Interactions, found: &[(Measure, Indices)]) -> Option<Chart> {
    let varies = |indices: &[Index]| indices.iter().any(|i| i.total.value > 0.0);
    let of = |m: &Measure| found.iter().find(|(other, i)| other == m && varies(&i.each));
    let panels: Vec<&(Measure, Indices)> = PANELS.iter().filter_map(of).collect();
    if panels.is_empty() {
        return None;
    }
    let mut order = all.order();
    order.truncate(MOST);
    let names = Axis::names(order.iter().map(|&i| all.factors[i].key.as_str()));
    let [first, total] = COLOURS;
    let chart = Chart::new(NAME, TITLE, subtitle(all)).columns(panels.len()).legend([
        Entry::fill("first order: alone", first),
        Entry::fill("total: with others", total),
        Entry::note("lines: 95 % intervals"),
    ]);
    Some(panels.iter().enumerate().fold(chart, |chart, (k, (measure, indices))| {
        let y = if k == 0 { names.clone() } else { names.clone().hidden() };
        let title = format!("share, {}", measure.title());
        let x = Axis::new(title, Scale::linear(0.0, 1.0)).ticks(5);
        let pairs = order.iter().enumerate().map(|(n, &i)| (n, &indices.each[i]));
        chart.panel(Panel::new(x, y).mark(Mark::Bars(pairs.flat_map(bars).collect())))
    }))
}

/// The bars of a key.
fn bars((row, index): (usize, &Index)) -> [Bar; 2] {
    let bar = |lane: usize, estimate: powergs_study::analysis::indices::Estimate| {
        let part = Part::new(estimate.value.max(0.0), COLOURS[lane]);
        let interval = Some((estimate.low, estimate.high));
        Bar { lane: (lane, 2), interval, ..Bar::new(row, vec![part]) }
    };
    [bar(0, index.first), bar(1, index.total)]
}
