//! What the buffers held: mean and peak against capacity, and what left unused.

use super::{Chart, frames, subtitle};
use crate::ReportError;
use crate::format::{engineering, percent};
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, Scale, legend, palette};
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

pub(super) fn chart(run: &Run, summary: &RunSummary) -> Result<Option<Chart>, ReportError> {
    let rows = summary.cycle.as_ref().map(rows).unwrap_or_default();
    if rows.is_empty() {
        return Ok(None);
    }
    let page = Page {
        name: NAME,
        title: TITLE.into(),
        subtitle: subtitle(run, &frames(run)),
        underlay: None,
    };
    let panel = Panel { left: 160.0, top: 160.0, right: 940.0, bottom: 630.0 };
    let drawing = page.draw(|canvas| {
        let names =
            [("mean", palette::BLUE), ("peak", palette::SKY), ("never used", palette::PALE)];
        legend(canvas, 40.0, 112.0, &names)?;
        let scale = Scale::exact(0.0, 100.0, panel.horizontal());
        for tick in scale.ticks(10) {
            canvas.line(&[(scale.at(tick), panel.top), (scale.at(tick), panel.bottom)], GRID, 1)?;
        }
        panel.horizontal_axis(canvas, &scale, &scale.ticks(10), "share of the capacity, %")?;
        let slot = (panel.bottom - panel.top) / rows.len() as f64;
        for (i, row) in rows.iter().enumerate() {
            let middle = panel.top + (i as f64 + 0.5) * slot;
            bar(canvas, panel, &scale, row, (middle, (0.34 * slot).min(40.0)))?;
        }
        Ok(())
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn bar(
    canvas: &Canvas,
    panel: Panel,
    scale: &Scale,
    row: &Row,
    (middle, half): (f64, f64),
) -> Drawn {
    canvas.text(row.name, (panel.left - 14.0, middle), Align::Right, INK)?;
    let parts =
        [(row.capacity, palette::PALE), (row.peak, palette::SKY), (row.mean, palette::BLUE)];
    for (bytes, colour) in parts {
        let end = scale.at(bytes / row.capacity * 100.0);
        if end > panel.left {
            canvas.fill((panel.left, middle - half), (end, middle + half), colour)?;
        }
    }
    let kib =
        format!("{:.0} KiB, mean {} %", row.capacity / 1024.0, percent(row.mean / row.capacity));
    canvas.text(&kib, (panel.right + 16.0, middle - 12.0), Align::Left, INK)?;
    let unused = if row.filled > 0.0 { row.discarded / row.filled } else { 0.0 };
    let filled = engineering(row.filled, "B");
    let text = format!("{filled} in, {} % of it unused", percent(unused));
    canvas.text(&text, (panel.right + 16.0, middle + 12.0), Align::Left, GREY)
}
