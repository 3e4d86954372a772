//! Parts of a step of training or tracking: what each takes of the time.

use crate::document::{Cell, Column, Kind, Table};
use crate::format::significant;
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale};
use powergs_core::flow::steps::StepPart;
use powergs_study::findings::compare::Side;
use powergs_study::findings::{Key, Record};

/// A part with its milliseconds.
pub type StepTime = (&'static str, f64);

/// The picture of a step, which the other parts follow.
const FORWARD: &str = "forward";

/// All parts, in their order.
fn names() -> impl Iterator<Item = &'static str> {
    [FORWARD].into_iter().chain(StepPart::ALL.map(StepPart::words))
}

/// The picture, and what is made of it.
const COLOURS: [Colour; 1 + StepPart::ALL.len()] =
    [Colour::BLUE, Colour::YELLOW, Colour::VERMILION, Colour::PURPLE, Colour::GREEN];

/// What the parts of a step take, milliseconds in the mean, the picture first; empty where frames
/// are no steps. Together they are the time of a step.
pub fn parts(record: &Record) -> Vec<StepTime> {
    let of = |part: StepPart| Some((part.words(), record.mean(Key::Stat(part.time()))?));
    let behind: Vec<StepTime> = StepPart::ALL.into_iter().filter_map(of).collect();
    if behind.is_empty() {
        return behind;
    }
    let sum: f64 = behind.iter().map(|(_, ms)| ms).sum();
    let picture = record.value(Key::FrameTime) - sum;
    [(FORWARD, picture)].into_iter().chain(behind).collect()
}

/// A row a machine, a column a part, milliseconds.
pub fn table<'a>(machines: &[(&'a str, Vec<StepTime>)]) -> Table {
    let parts = names().chain(["step"]).map(|name| Column::new(name, Kind::Real(significant)));
    let columns = [Column::text("ms").at_most(16)].into_iter().chain(parts);
    let row = |(label, parts): &(&'a str, Vec<StepTime>)| {
        let of = |name| Cell::from(parts.iter().find(|(part, _)| *part == name).map(|(_, ms)| *ms));
        let sum = parts.iter().map(|(_, ms)| ms).sum::<f64>();
        let cells = names().map(of).chain([Cell::from(Some(sum))]);
        [Cell::from(*label)].into_iter().chain(cells).collect::<Vec<_>>()
    };
    Table::new(columns).rows(machines.iter().map(row))
}

/// The sides that make steps.
pub fn of_sides(sides: &[Side]) -> Vec<(&str, Vec<StepTime>)> {
    let trainers = sides.iter().filter(|side| !side.task.is_shown());
    let all = trainers.map(|side| (side.label.as_str(), parts(&side.statistics)));
    all.filter(|(_, parts)| !parts.is_empty()).collect()
}

/// Machines over traces: a bar each, its parts in a row; `None` where nobody makes steps.
pub fn chart(rows: &[(String, Vec<StepTime>)], subtitle: String) -> Option<Chart> {
    let sum = |parts: &[StepTime]| parts.iter().map(|(_, ms)| ms).sum::<f64>();
    let highest = rows.iter().map(|(_, parts)| sum(parts)).fold(0.0, f64::max);
    if rows.is_empty() || highest <= 0.0 {
        return None;
    }
    let colour = |name: &str| COLOURS[names().position(|known| known == name).unwrap_or(0)];
    let bar = |(i, (_, parts)): (usize, &(String, Vec<StepTime>))| {
        let all = parts.iter().map(|(name, ms)| Part::new(*ms, colour(name))).collect();
        Bar::new(i, all).end(significant(sum(parts)))
    };
    let bars = rows.iter().enumerate().map(bar).collect();
    let y = Axis::names(rows.iter().map(|(name, _)| name.as_str()));
    let x = Axis::new("ms of a step", Scale::from_zero(1.08 * highest)).ticks(5);
    let entries = names().map(|name| Entry::fill(name, colour(name)));
    let chart = Chart::new("steps", "Where a step of training goes", subtitle).legend(entries);
    Some(chart.panel(Panel::new(x, y).mark(Mark::Bars(bars))))
}
