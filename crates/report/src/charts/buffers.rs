//! What the buffers held: mean and peak against capacity, and what was discarded unread. A
//! batch that is larger than its buffer enters alone: a peak may lie beyond the capacity.

use super::{frames, subtitle};
use crate::format::{engineering, percent};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Scale, Words};
use powergs_core::stage::hardware;
use powergs_energy::action::BufferId;
use powergs_energy::hardware::BufferFacts;
use powergs_study::findings::{Key, Record};
use powergs_study::run_record::Run;

const NAME: &str = "buffers";
const TITLE: &str = "What the buffers hold";

/// One buffer, means over the frames, bytes.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) capacity: f64,
    pub(crate) peak: f64,
    pub(crate) mean: f64,
    pub(crate) filled: f64,
    pub(crate) consumed: f64,
    pub(crate) discarded: f64,
}

/// The buffers that the machine has, where it was measured what they held.
pub(crate) fn rows(record: &Record) -> Vec<Row> {
    let row = |(buffer, facts): (BufferId, &BufferFacts)| {
        Some(Row {
            name: facts.name,
            capacity: record.mean(Key::Capacity(buffer)).filter(|bytes| *bytes > 0.0)?,
            peak: record.mean(Key::Peak(buffer))?,
            mean: record.mean(Key::Held(buffer))?,
            filled: record.mean(Key::Filled(buffer))?,
            consumed: record.mean(Key::Consumed(buffer))?,
            discarded: record.mean(Key::Discarded(buffer))?,
        })
    };
    let all = hardware().buffers().filter(|(_, facts)| facts.fills);
    all.filter_map(row).collect()
}

pub(super) fn chart(run: &Run, record: &Record) -> Option<Chart> {
    let rows = rows(record);
    if rows.is_empty() {
        return None;
    }
    let most = rows.iter().map(|r| share(r.peak.max(r.mean), r)).fold(FULL, f64::max);
    let end = if most > FULL { (most / FULL).ceil() * FULL } else { FULL };
    let x = Axis::new("share of the capacity, %", Scale::linear(0.0, end)).ticks(10);
    let mut panel = Panel::new(x, Axis::names(rows.iter().map(|r| r.name)));
    panel.marks = vec![Mark::Bars(rows.iter().enumerate().map(|(i, r)| bar(i, r)).collect())];
    panel.right = rows.iter().enumerate().map(|(i, r)| (i as f64 + 0.5, facts(r))).collect();
    let mut entries =
        vec![("mean", Colour::BLUE), ("peak", Colour::SKY), ("never filled", Colour::PALE)];
    if most > FULL {
        entries.push(("peak beyond the capacity", Colour::VERMILION));
    }
    let chart = Chart::new(NAME, TITLE, subtitle(run, &frames(run)));
    Some(
        chart
            .legend(entries.into_iter().map(|(name, colour)| Entry::fill(name, colour)))
            .panel(panel),
    )
}

/// A buffer that is full, percent.
const FULL: f64 = 100.0;

/// Bytes as a share of the capacity of a buffer, percent.
fn share(bytes: f64, row: &Row) -> f64 {
    (bytes / row.capacity * FULL).max(0.0)
}

/// The mean, what the peak adds to it within the capacity and beyond, and what was never filled.
fn bar(i: usize, row: &Row) -> Bar {
    let (mean, peak) = (share(row.mean, row), share(row.peak, row));
    let within = peak.min(FULL);
    let parts = [
        Part::new(mean, Colour::BLUE),
        Part::new((within - mean).max(0.0), Colour::SKY),
        Part::new((peak - within.max(mean)).max(0.0), Colour::VERMILION),
        Part::new((FULL - peak.max(mean)).max(0.0), Colour::PALE),
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
