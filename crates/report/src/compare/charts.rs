//! Charts of a comparison: energy side by side, and where the cycles go on each side.

use super::{Comparison, Side, component_mj};
use crate::breakdown::CycleRow;
use crate::charts::{
    CYCLES_COLOURS, component_colour, component_entries, cycles_axis, cycles_bar, cycles_entries,
};
use crate::format::significant;
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_core::action::Stage;
use powergs_core::energy::Component;

/// Sides in one chart; a slide has no room for more.
const MOST: usize = 8;
/// Units with a panel each.
const UNITS: [&str; 4] = ["ccu", "qsu", "bsu", "vru"];

/// All charts that the sides have data for.
pub fn charts(comparison: &Comparison) -> Vec<Chart> {
    let sides = &comparison.sides[..comparison.sides.len().min(MOST)];
    let subtitle = subtitle(comparison);
    let mut charts = vec![energy(sides, subtitle.clone())];
    if sides.iter().all(|s| !CycleRow::all(&s.means).is_empty()) {
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
        let part = |c| Part::new(component_mj(side, c).unwrap_or(0.0), component_colour(c));
        Component::ALL.map(part).to_vec()
    };
    let stage = |side: &Side| {
        let mj = |stage: Stage| side.means.get(&format!("energy_pj.{}", stage.name()));
        Stage::ALL.map(|s| Part::new(mj(s).unwrap_or(0.0) * 1e-9, stage_colour(s))).to_vec()
    };
    let left = panel(sides, &component, "by component");
    let mut right = panel(sides, &stage, "by stage");
    right.y = right.y.hidden();
    Chart::new("energy", "Energy per frame", subtitle)
        .legend(component_entries())
        .legend(Stage::ALL.map(|s| Entry::fill(s.name(), stage_colour(s))))
        .columns(2)
        .panel(left)
        .panel(right)
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
    UNITS.into_iter().enumerate().fold(chart, |chart, (u, unit)| {
        let bar = |(i, side): (usize, &Side)| {
            let rows = CycleRow::all(&side.means);
            let row = rows.iter().find(|r| r.unit == unit)?;
            Some(cycles_bar(i, row.shares().into_iter().zip(CYCLES_COLOURS)))
        };
        let bars: Vec<Bar> = sides.iter().enumerate().filter_map(bar).collect();
        let x = if u + 1 < UNITS.len() { cycles_axis().hidden() } else { cycles_axis() };
        let mut y = Axis::names(sides.iter().map(|s| s.label.as_str()));
        y.title = unit.into();
        chart.panel(Panel::new(x, y).mark(Mark::Bars(bars)))
    })
}
