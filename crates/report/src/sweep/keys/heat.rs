//! Two axes: a heat map for every objective.

use super::{Lane, chart_of};
use crate::format::shortened;
use crate::sweep::measure::Measure;
use crate::sweep::words::knee_name;
use powergs_chart::{Axis, Cell, Chart, Colour, Entry, Mark, Panel, Symbol, Words, ends};
use powergs_study::analysis::Analysis;

const TITLE: &str = "What the two axes do";
/// Objectives that a page has room for.
const MOST: usize = 3;
/// The front and the knee.
const FRONT: Colour = Colour::ORANGE;
const KNEE: Colour = Colour::VERMILION;

pub(super) fn chart(analysis: &Analysis, x: &Lane, y: &Lane) -> Chart {
    let n = analysis.question.objectives.len().min(MOST);
    let chart = chart_of(analysis, TITLE).columns(n).legend([
        Entry::new("on the Pareto front", Symbol::Dot(FRONT)),
        Entry::new(knee_name(analysis), Symbol::Dot(KNEE)),
    ]);
    (0..n).fold(chart, |chart, j| {
        let mut panel = panel(analysis, x, y, j);
        panel.y.shown = j == 0;
        chart.panel(panel)
    })
}

fn panel(analysis: &Analysis, x: &Lane, y: &Lane, j: usize) -> Panel {
    let measure = Measure::of(&analysis.question.objectives[j].name);
    let value = |row: u32| analysis.value(j, row);
    let (low, high) = ends(analysis.rows.iter().map(|&row| value(row)));
    let cell = |&row: &u32| {
        let share = if high > low { (value(row) - low) / (high - low) } else { 0.5 };
        let dot = analysis.front.contains(&row).then_some((FRONT, false));
        Cell {
            column: x.place(row),
            // The smallest value lies at the bottom.
            row: y.order.len() - 1 - y.place(row),
            colour: Colour::at(share),
            label: measure.text(value(row)),
            dot: if row == analysis.knee { Some((KNEE, true)) } else { dot },
        }
    };
    let names = |lane: &Lane| -> Vec<Words> {
        (0..lane.order.len()).map(|p| Words::note(shortened(lane.word(p), 14))).collect()
    };
    let mut across = Axis::names(names(x));
    across.title = x.name.into();
    let mut up = Axis::names(names(y).into_iter().rev());
    up.title = y.name.into();
    let cells = analysis.rows.iter().map(cell).collect();
    let mut panel =
        Panel::new(across, up).heading(Words::bold(measure.words.as_str())).mark(Mark::Heat(cells));
    panel.colours = Some((measure.text(low), measure.text(high)));
    panel
}
