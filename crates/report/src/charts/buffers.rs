//! What the buffers held: mean and peak against capacity, and what was discarded unread.

use super::{frames, subtitle};
use crate::format::{engineering, percent};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_study::findings::RunSummary;
use powergs_study::findings::summary::{BufferSummary, CycleSummary};
use powergs_study::run_record::Run;

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

fn rows(cycle: &CycleSummary) -> Vec<Row> {
    let row = |buffer: &BufferSummary| {
        Some(Row {
            name: buffer.buffer.name(),
            capacity: buffer.capacity as f64,
            peak: buffer.peak,
            mean: buffer.mean?,
            filled: buffer.filled,
            discarded: buffer.discarded,
        })
    };
    cycle.buffers.iter().filter(|b| b.capacity > 0).filter_map(row).collect()
}

pub(super) fn chart(run: &Run, summary: &RunSummary) -> Option<Chart> {
    let rows = summary.cycle.as_ref().map(rows).unwrap_or_default();
    if rows.is_empty() {
        return None;
    }
    let x = Axis::new("share of the capacity, %", Scale::linear(0.0, 100.0)).ticks(10);
    let mut panel = Panel::new(x, Axis::names(rows.iter().map(|r| r.name)));
    panel.marks = vec![Mark::Bars(rows.iter().enumerate().map(|(i, r)| bar(i, r)).collect())];
    panel.right = rows.iter().enumerate().map(|(i, r)| (i as f64 + 0.5, facts(r))).collect();
    let entries = [("mean", Colour::BLUE), ("peak", Colour::SKY), ("never filled", Colour::PALE)];
    let chart = Chart::new(NAME, TITLE, subtitle(run, &frames(run)));
    Some(chart.legend(entries.map(|(name, colour)| Entry::fill(name, colour))).panel(panel))
}

/// The mean, what the peak adds to it, and what was never filled.
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
        Words::note(format!("{filled} in, {} % discarded unread", percent(unused))),
    ]
}
