//! What the buffers held: mean and peak against capacity, and what left unused.

use super::{frames, subtitle};
use crate::format::{engineering, percent};
use crate::{Means, Run, Table};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_core::action::Buffer;

const NAME: &str = "buffers";
const TITLE: &str = "What the buffers hold";

/// One buffer, means over the frames.
struct Row {
    name: &'static str,
    capacity: f64,
    peak: f64,
    mean: f64,
    filled: f64,
    discarded: f64,
}

fn rows(means: &Means) -> Vec<Row> {
    let row = |buffer: Buffer| {
        let name = buffer.name();
        let get = |end: &str| means.get(&format!("buffers.{name}.{end}"));
        Some(Row {
            name,
            capacity: get("capacity_bytes").filter(|c| *c > 0.0)?,
            peak: get("peak_bytes")?,
            mean: get("mean_bytes")?,
            filled: get("filled_bytes")?,
            discarded: get("discarded_bytes")?,
        })
    };
    Buffer::ALL.into_iter().filter_map(row).collect()
}

pub(super) fn chart(run: &Run, table: &Table) -> Option<Chart> {
    let rows = rows(&table.means());
    if rows.is_empty() {
        return None;
    }
    let x = Axis::new("share of the capacity, %", Scale::linear(0.0, 100.0)).ticks(10);
    let mut panel = Panel::new(x, Axis::names(rows.iter().map(|r| r.name)));
    panel.marks = vec![Mark::Bars(rows.iter().enumerate().map(|(i, r)| bar(i, r)).collect())];
    panel.right = rows.iter().enumerate().map(|(i, r)| (i as f64 + 0.5, facts(r))).collect();
    let entries = [("mean", Colour::BLUE), ("peak", Colour::SKY), ("never used", Colour::PALE)];
    let chart = Chart::new(NAME, TITLE, subtitle(run, &frames(run)));
    Some(chart.legend(entries.map(|(name, colour)| Entry::fill(name, colour))).panel(panel))
}

/// The mean, what the peak adds to it, and what was never used.
fn bar(i: usize, row: &Row) -> Bar {
    let share = |bytes: f64| (bytes / row.capacity * 100.0).clamp(0.0, 100.0);
    let (mean, peak) = (share(row.mean), share(row.peak));
    let parts = [
        Part::new(mean, Colour::BLUE),
        Part::new((peak - mean).max(0.0), Colour::SKY),
        Part::new(100.0 - peak.max(mean), Colour::PALE),
    ];
    Bar::new(i, parts.into())
}

fn facts(row: &Row) -> Vec<Words> {
    let mean = percent(row.mean / row.capacity);
    let unused = if row.filled > 0.0 { row.discarded / row.filled } else { 0.0 };
    let filled = engineering(row.filled, "B");
    vec![
        Words::from(format!("{:.0} KiB, mean {mean} %", row.capacity / 1024.0)),
        Words::note(format!("{filled} in, {} % of it unused", percent(unused))),
    ]
}
