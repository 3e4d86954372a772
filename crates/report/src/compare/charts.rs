//! Charts of a comparison: energy side by side, and where the cycles go on each side.

use crate::charts::{
    CYCLES_COLOURS, component_colour, component_entries, cycles_axis, cycles_bar, cycles_entries,
};
use crate::format::significant;
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_energy::Component;
use powergs_energy::action::{Stage, UnitKind};
use powergs_study::findings::compare::{Comparison, Side};

/// Sides in one chart; a slide has no room for more.
const MOST: usize = 8;

/// All charts that the sides have data for.
pub fn charts(comparison: &Comparison) -> Vec<Chart> {
    let sides = &comparison.sides[..comparison.sides.len().min(MOST)];
    let subtitle = subtitle(comparison);
    let mut charts = vec![energy(sides, subtitle.clone())];
    if sides.iter().all(|s| s.summary.cycle.is_some()) {
        charts.push(cycles(sides, subtitle));
    }
    charts
}

fn subtitle(comparison: &Comparison) -> String {
    let shown = comparison.sides.len().min(MOST);
    let of = if shown < comparison.sides.len() {
        format!("the first {shown} of {} sides, ", comparison.sides.len())
    } else {
        String::new()
    };
    let side = &comparison.sides[0];
    let frames =
        if side.frames == 1 { "1 frame".into() } else { format!("mean of {} frames", side.frames) };
    format!("{of}{}, {frames}", side.trace)
}

fn energy(sides: &[Side], subtitle: String) -> Chart {
    let component = |side: &Side| {
        let part =
            |c| Part::new(known(side.summary.energy.component(c)) * 1e-9, component_colour(c));
        Component::ALL.map(part).to_vec()
    };
    let stage = |side: &Side| {
        let mj = |stage: Stage| known(side.summary.energy.stage(stage)) * 1e-9;
        Stage::ALL.map(|s| Part::new(mj(s), stage_colour(s))).to_vec()
    };
    let left = panel(sides, &component, "by component");
    let mut right = panel(sides, &stage, "by stage");
    right.y = right.y.hidden();
    let stages = Stage::ALL.map(|s| Entry::fill(s.name(), stage_colour(s)));
    Chart::new("energy", "Energy per frame", subtitle)
        .legend([Entry::note("by component:")].into_iter().chain(component_entries()))
        .legend([Entry::note("by stage:")].into_iter().chain(stages))
        .columns(2)
        .panel(left)
        .panel(right)
}

/// What an older report does not say is not drawn.
fn known(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}

fn stage_colour(stage: Stage) -> Colour {
    match stage {
        Stage::Preprocessing => Colour::GREEN,
        Stage::Sorting => Colour::INDIGO,
        Stage::Rendering => Colour::VERMILION,
        Stage::Standby => Colour::PALE,
    }
}

/// Stacked bars with their sums.
fn panel(sides: &[Side], parts: &dyn Fn(&Side) -> Vec<Part>, heading: &str) -> Panel {
    let bars: Vec<Bar> = sides
        .iter()
        .enumerate()
        .map(|(i, side)| {
            let parts = parts(side);
            let sum: f64 = parts.iter().map(|p| p.value).sum();
            Bar::new(i, parts).end(significant(sum))
        })
        .collect();
    let sum = |bar: &Bar| bar.parts.iter().map(|p| p.value).sum::<f64>();
    let highest = bars.iter().map(sum).fold(0.0, f64::max);
    let x = Axis::new("mJ per frame", Scale::from_zero(highest)).ticks(5);
    Panel::new(x, Axis::names(sides.iter().map(|s| s.label.as_str())))
        .heading(Words::bold(heading))
        .mark(Mark::Bars(bars))
}

/// A panel for every kind of unit.
fn cycles(sides: &[Side], subtitle: String) -> Chart {
    let chart = Chart::new("cycles", "Where the cycles go", subtitle).legend(cycles_entries());
    UnitKind::ALL.into_iter().enumerate().fold(chart, |chart, (u, unit)| {
        let bar = |(i, side): (usize, &Side)| {
            let row = &side.summary.cycle.as_ref()?.units[unit as usize];
            Some(cycles_bar(i, row.shares().into_iter().zip(CYCLES_COLOURS)))
        };
        let bars: Vec<Bar> = sides.iter().enumerate().filter_map(bar).collect();
        let x = if u + 1 < UnitKind::ALL.len() { cycles_axis().hidden() } else { cycles_axis() };
        let mut y = Axis::names(sides.iter().map(|s| s.label.as_str()));
        y.title = unit.name().into();
        chart.panel(Panel::new(x, y).mark(Mark::Bars(bars)))
    })
}
