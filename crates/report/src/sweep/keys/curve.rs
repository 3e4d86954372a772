//! One axis: a curve for every objective.

use super::{Lane, chart_of};
use crate::format::{rate, shortened};
use crate::sweep::axis::Axis;
use crate::sweep::deadline;
use crate::sweep::words::knee_name;
use powergs_chart::{Chart, Colour, Entry, Line, Panel, Place, Points, Rule, Size, Symbol, Words};
use powergs_study::analysis::Analysis;

const TITLE: &str = "What the axis does";
/// Objectives that a page has room for.
const MOST: usize = 3;

pub(super) fn chart(analysis: &Analysis, lane: &Lane) -> Chart {
    let n = analysis.question.objectives.len().min(MOST);
    let mut entries = vec![Entry::new(knee_name(analysis), Symbol::Dot(Colour::VERMILION))];
    entries.extend(analysis.question.display_fps.map(|fps| {
        let name = format!("display rate, {} FPS", rate(fps));
        Entry::new(name, Symbol::Dashed(deadline::COLOUR))
    }));
    (0..n).fold(chart_of(analysis, TITLE).legend(entries), |chart, j| {
        let mut panel = panel(analysis, lane, j);
        panel.x.shown = j + 1 == n;
        chart.panel(panel)
    })
}

fn panel(analysis: &Analysis, lane: &Lane, j: usize) -> Panel {
    let values = analysis.rows.iter().map(|&row| analysis.value(j, row)).collect();
    let values = deadline::with(analysis, j, values).into_iter();
    let axis = Axis::of(&analysis.question.objectives[j].name, values);
    let line = deadline::line(analysis, j, &axis);
    let Axis { axis: mut y, factor } = axis;
    // A name may be longer than the panel is high.
    let heading = std::mem::take(&mut y.title);
    let mut x = powergs_chart::Axis::names(
        (0..lane.order.len()).map(|p| Words::note(shortened(lane.word(p), 16))),
    );
    x.title = lane.name.into();
    let place = |row: u32| (lane.place(row) as f64 + 0.5, analysis.value(j, row) * factor);
    let mut points: Vec<Place> = analysis.rows.iter().map(|&row| place(row)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let panel = Panel::new(x, y)
        .heading(Words::bold(heading))
        .line(Line::thin(points.clone(), Colour::BLUE))
        .points(Points::dots(points, Colour::BLUE, Size::Medium))
        .points(Points::dots([place(analysis.knee)], Colour::VERMILION, Size::Huge));
    match line {
        Some(at) => panel.dashed(Rule::Y(at), deadline::COLOUR),
        None => panel,
    }
}
