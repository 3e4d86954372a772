//! Units by time: what each did in every column of the picture.

use super::cycles::{self, waits};
use crate::timeline::{COLUMNS, IDLE, MOST_INSTANCES, Picture, Row, STATES};
use powergs_chart::{Axis, Chart, Colour, Entry, Mark, Panel, Scale, Span};
use powergs_core::sim::statistics::UnitPart;
use powergs_core::stage::Stall;

const NAME: &str = "timeline";
const TITLE: &str = "What every unit does when";

/// Busy with one item, with the next one (another green: neighbours can be told apart), waiting,
/// idle.
fn colours(crowded: bool) -> [Colour; STATES] {
    let mut colours = [Colour::PALE; STATES];
    for (part, colour) in UnitPart::all().zip(cycles::colours()) {
        match part {
            UnitPart::Busy => {
                (colours[0], colours[1]) = (colour, if crowded { colour } else { Colour::PINE });
            }
            UnitPart::Stalled(cause) => colours[2 + cause.index()] = colour,
            UnitPart::Idle => colours[IDLE] = colour,
        }
    }
    colours
}

/// Whether so many items are on the picture that two shades would be noise.
fn is_crowded(picture: &Picture) -> bool {
    let changes = |row: &Row| (1..COLUMNS).filter(|c| row.state(*c) != row.state(c - 1)).count();
    picture.rows().any(|row| changes(row) > COLUMNS / 20)
}

/// The chart of a finished picture; `what` names the frame and the tiles.
pub fn chart(picture: &Picture, clock_hz: f64, what: &str) -> Chart {
    let cut = if picture.cut {
        format!("; the first {MOST_INSTANCES} of each kind of unit")
    } else {
        String::new()
    };
    let colours = colours(is_crowded(picture));
    let is_drawn = |s: &&Stall| picture.has(**s);
    let causes = Stall::all().iter().filter(is_drawn);
    let causes = causes.map(|s| Entry::fill(waits(*s), colours[2 + s.index()]));
    let mut entries = vec![
        Entry::fill("busy with a tile", colours[0]),
        Entry::fill("busy with the next tile", colours[1]),
    ];
    entries.extend(causes);
    entries.push(Entry::fill("no work", colours[IDLE]));
    if is_crowded(picture) {
        entries[0].name = "busy".into();
        entries.remove(1);
    }
    let chart = Chart::new(NAME, TITLE, format!("{what}{cut}")).legend(entries);
    let numbered = picture.rows().any(|row| !row.items.is_empty());
    let chart = chart.panel(panel(picture, clock_hz));
    if numbered {
        chart.note("Numbers, where they fit: tiles (of CCUs: batches of Gaussians).")
    } else {
        chart
    }
}

fn panel(picture: &Picture, clock_hz: f64) -> Panel {
    let colours = colours(is_crowded(picture));
    let us = |cycle: u64| cycle as f64 / clock_hz * 1e6;
    let (start, end) = (us(picture.cycles.start), us(picture.cycles.end));
    let edge = |column: usize| start + (end - start) * column as f64 / COLUMNS as f64;
    let (mut spans, mut labels) = (Vec::new(), Vec::new());
    let rows: Vec<&Row> = picture.rows().collect();
    for (track, row) in rows.iter().enumerate() {
        let mut from = 0;
        for column in 1..=COLUMNS {
            if column == COLUMNS || row.state(column) != row.state(from) {
                let colour = colours[row.state(from)];
                spans.push(Span { track, from: edge(from), to: edge(column), colour });
                from = column;
            }
        }
        labels.extend(row.items.iter().map(|item| {
            let (from, to) = (us(item.cycles.start), us(item.cycles.end));
            (Span { track, from, to, colour: Colour::PINE }, item.number.to_string())
        }));
    }
    let title = "time since the frame began, µs";
    let x = Axis::new(title, Scale::linear(start, end)).ticks(10).plain().positions();
    let names = Axis::names(rows.iter().map(|r| r.name.as_str()));
    Panel::new(x, names).mark(Mark::Spans { spans, labels })
}
