//! More axes: parallel coordinates, a line per design through its settings to its objectives.

use super::{Lane, chart_of};
use crate::format::rounded;
use crate::sweep::axis::Axis;
use crate::sweep::colour::ColourKey;
use crate::sweep::words::knee_name;
use powergs_chart::{
    Chart, Colour, Entry, Gauge, Line, Mark, Panel, Place, Scale, Symbol, Weight, Words, tick_label,
};
use powergs_study::analysis::Analysis;

const TITLE: &str = "Settings and results of every design";
/// Axes and objectives that a page has room for.
const LANES: usize = 6;
const OBJECTIVES: usize = 4;
/// Lines off the front that are drawn; more are a grey wall.
const LINES: usize = 600;
/// Values of an axis that are named.
const NAMED: usize = 18;

pub(super) fn chart(analysis: &Analysis, lanes: &[Lane]) -> Chart {
    let lanes = &lanes[..lanes.len().min(LANES)];
    let objectives = &analysis.question.objectives;
    let objectives = &objectives[..objectives.len().min(OBJECTIVES)];
    let axes: Vec<Axis> = (0..objectives.len())
        .map(|j| {
            let values = analysis.rows.iter().map(|&row| analysis.value(j, row));
            Axis::of(&objectives[j].name, values)
        })
        .collect();
    let key = ColourKey::named(analysis, &objectives[0].name, &analysis.front);
    let first = axes.first().map_or("", |a| &a.axis.title);
    let knee = format!("{} {}", knee_name(analysis), analysis.table.label(analysis.knee));
    let chart = chart_of(analysis, TITLE)
        .legend([
            Entry::new(knee, Symbol::Line(Colour::VERMILION)),
            Entry::note(format!("coloured: the Pareto front, by {first}")),
            Entry::note("grey: other designs"),
        ])
        .panel(panel(analysis, lanes, &axes, &key));
    match key.beside() {
        Some(beside) => chart.beside(beside),
        None => chart,
    }
}

/// Heights are shares of the panel: every upright axis has its own values.
fn panel(analysis: &Analysis, lanes: &[Lane], axes: &[Axis], key: &ColourKey) -> Panel {
    let height = |lane: &Lane, place: usize| (place as f64 + 0.5) / lane.order.len() as f64;
    let line = |row: u32| -> Vec<Place> {
        let settings = lanes.iter().map(|lane| height(lane, lane.place(row)));
        let results = axes
            .iter()
            .enumerate()
            .map(|(j, a)| a.axis.scale.share(analysis.value(j, row) * a.factor));
        settings.chain(results).enumerate().map(|(i, y)| (i as f64 + 0.5, y)).collect()
    };
    // Names of neighbours take turns above and below.
    let names: Vec<String> = lanes
        .iter()
        .map(|lane| lane.name.to_owned())
        .chain(axes.iter().map(|axis| axis.axis.words()))
        .collect();
    let below =
        |(i, name): (usize, &String)| Words::bold(if i % 2 == 1 { name.as_str() } else { "" });
    let mut panel = Panel::new(
        powergs_chart::Axis::names(names.iter().enumerate().map(below)),
        powergs_chart::Axis::new("", Scale::linear(-0.03, 1.05)).hidden(),
    );
    let step = analysis.rows.len().div_ceil(LINES).max(1);
    for &row in analysis.rows.iter().step_by(step) {
        let line = Line::curve(line(row), Colour::PALE);
        panel = panel.line(Line { weight: Weight::Hair, ..line });
    }
    for &row in &analysis.front {
        panel = panel.line(Line::thin(line(row), key.colour(row)));
    }
    let knee = Line::curve(line(analysis.knee), Colour::VERMILION);
    panel = panel.line(Line { weight: Weight::Bold, ..knee });
    for (i, name) in names.iter().enumerate() {
        if i % 2 == 0 {
            panel.over.push((i as f64 + 0.5, 1.9, Words::bold(name.as_str())));
        }
    }
    for (i, lane) in lanes.iter().enumerate() {
        let every = lane.order.len().div_ceil(NAMED).max(1);
        let places = (0..lane.order.len()).step_by(every);
        let label = |place| (height(lane, place), rounded(lane.word(place)));
        let labels = places.map(label).collect();
        panel = panel.mark(Mark::Gauge(Gauge { at: i as f64 + 0.5, labels }));
    }
    for (j, axis) in axes.iter().enumerate() {
        let scale = &axis.axis.scale;
        let ticks = scale.ticks(6);
        let label = |value: &f64| (scale.share(*value), tick_label(*value, &ticks));
        let labels = ticks.iter().map(label).collect();
        panel = panel.mark(Mark::Gauge(Gauge { at: (lanes.len() + j) as f64 + 0.5, labels }));
    }
    panel
}
