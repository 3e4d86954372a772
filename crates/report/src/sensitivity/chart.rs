//! A tornado for each trace: the knobs that move most, as bars to both sides of the machine as it
//! is.

use crate::format::{shortened, significant};
use powergs_chart::{Axis, Chart, Colour, Entry, Mark, Name, Panel, Scale, Words};
use powergs_study::findings::sensitivity::{Change, KnobEffect, Sensitivity};

/// File names; further traces have no chart.
const NAMES: [&str; 4] = ["tornado", "tornado_2", "tornado_3", "tornado_4"];
const TITLE: &str = "What assumptions move";
/// Bars that a slide has room for.
const MOST: usize = 18;
/// Varied down, varied up.
const COLOURS: [Colour; 2] = [Colour::BLUE, Colour::ORANGE];
/// A scale ends here at the latest, percent.
const WIDEST: f64 = 200.0;

/// A chart for each of the first traces.
pub fn charts(all: &Sensitivity) -> Vec<Chart> {
    (0..all.traces.len().min(NAMES.len())).map(|t| chart(all, t)).collect()
}

fn chart(all: &Sensitivity, t: usize) -> Chart {
    let trace = &all.traces[t];
    // The title names one machine: rows about others stay in the tables.
    let moves = |r: &&KnobEffect| r.on.is_none() && effect(r, t) >= 0.0005;
    let mut rows: Vec<&KnobEffect> = all.rows.iter().filter(moves).collect();
    rows.sort_by(|a, b| effect(b, t).total_cmp(&effect(a, t)));
    rows.truncate(MOST);
    let note = all.incomplete_note().map_or(String::new(), |note| format!("{note}. "));
    let (fps, mj) = (significant(trace.base.fps()), significant(trace.base.energy_mj()));
    let (name, machine) = (shortened(&trace.name, 30), shortened(&all.machine, 20));
    let subtitle = format!("{note}{name} on {machine}: {fps} FPS, {mj} mJ a frame as it is");
    let left = panel(&rows, t, "frames per second, change in %", |c| c.fps);
    let mut right = panel(&rows, t, "energy per frame, change in %", |c| c.energy);
    right.y = right.y.hidden();
    let names = ["lower value", "higher value, or another name"].into_iter().zip(COLOURS);
    Chart::new(NAMES[t], TITLE, subtitle)
        .legend(names.map(|(name, colour)| Entry::fill(name, colour)))
        .columns(2)
        .panel(left)
        .panel(right)
}

fn effect(row: &KnobEffect, t: usize) -> f64 {
    let size = |c: Change| c.fps.abs().max(c.energy.abs());
    row.changes(t).into_iter().flatten().map(size).fold(0.0, f64::max)
}

fn panel(rows: &[&KnobEffect], t: usize, title: &str, of: impl Fn(Change) -> f64) -> Panel {
    let percents = |row: &&KnobEffect| row.changes(t).map(|c| c.map(|c| of(c) * 100.0));
    let values: Vec<[Option<f64>; 2]> = rows.iter().map(percents).collect();
    let name =
        |row: &&KnobEffect| Name { words: Words::from(row.knob()), lead: row.number.clone() };
    let y = Axis::names(rows.iter().map(name));
    Panel::new(both_ways(title, &values, 1.0, WIDEST), y)
        .mark(Mark::Tornado { rows: values, colours: COLOURS })
}

/// An axis to both sides of zero; it reaches at least to `least` and at most to `most`.
pub(super) fn both_ways(title: &str, values: &[[Option<f64>; 2]], least: f64, most: f64) -> Axis {
    let sizes = values.iter().flatten().flatten().map(|v| v.abs()).filter(|v| v.is_finite());
    let half = Scale::from_zero(sizes.fold(least, f64::max).min(most)).high();
    Axis::new(title, Scale::linear(-half, half))
}
