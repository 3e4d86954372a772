//! Histograms over tiles: list lengths of one frame, times of all frames.

use super::{Chart, subtitle};
use crate::ReportError;
use crate::format::engineering;
use crate::plot::{Align, Canvas, Drawn, GREY, INK, Page, Panel, Scale, palette};
use powergs_core::accel::Histogram;
use powergs_study::run_record::Run;

const NAME: &str = "tiles";
const TITLE: &str = "How uneven the tiles are";

/// Counts by bin, as in [`Histogram`].
type Bins = [u64; Histogram::BINS];

pub(super) fn chart(run: &Run) -> Result<Option<Chart>, ReportError> {
    let Some(tiles) = run.tiles.as_ref().filter(|t| !t.entries.is_empty()) else {
        return Ok(None);
    };
    let mut lengths: Bins = [0; Histogram::BINS];
    tiles.entries.iter().for_each(|&n| lengths[Histogram::bin(u64::from(n))] += 1);
    let mut times: Bins = [0; Histogram::BINS];
    for timing in run.frames.iter().filter_map(|f| f.timing()) {
        for (sum, n) in times.iter_mut().zip(timing.tile_cycles.bins) {
            *sum += u64::from(n);
        }
    }
    let timed = times.iter().any(|&n| n > 0);
    let what = format!("lists of frame {}, times of {} frames", tiles.frame, run.frames.len());
    let page =
        Page { name: NAME, title: TITLE.into(), subtitle: subtitle(run, &what), underlay: None };
    let whole = Panel { left: 130.0, top: 160.0, right: 1240.0, bottom: 620.0 };
    let drawing = page.draw(|canvas| {
        if !timed {
            return panel(canvas, whole, &lengths, "list length of a tile, Gaussians");
        }
        let left = Panel { right: 640.0, ..whole };
        let right = Panel { left: 770.0, ..whole };
        panel(canvas, left, &lengths, "list length of a tile, Gaussians")?;
        panel(canvas, right, &times, "time of a tile in its renderer, cycles")
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// The bin that at least `share` of the counts are at or below.
fn quantile(bins: &Bins, share: f64) -> usize {
    let total: u64 = bins.iter().sum();
    let wanted = (total as f64 * share).ceil().max(1.0) as u64;
    let mut seen = 0;
    bins.iter()
        .position(|&n| {
            seen += n;
            seen >= wanted
        })
        .unwrap_or(0)
}

fn panel(canvas: &Canvas, panel: Panel, bins: &Bins, name: &str) -> Drawn {
    let total = bins.iter().sum::<u64>().max(1) as f64;
    let used = |b: &usize| bins[*b] > 0;
    let low = (1..Histogram::BINS).find(used).unwrap_or(1);
    let high = (1..Histogram::BINS).rev().find(used).unwrap_or(1).max(low + 3);
    // Zeros have a bar of their own, left of the scale.
    let slot = (panel.right - panel.left) / (high - low + 3) as f64;
    let left = panel.left + 2.0 * slot;
    let highest = bins.iter().copied().max().unwrap_or(0) as f64 / total * 100.0;
    let y = Scale::from_zero(highest, panel.vertical());
    panel.vertical_axis(canvas, &y, "share of the tiles, %")?;
    let bar = |x: f64, count: u64, colour| {
        let top = y.at(count as f64 / total * 100.0);
        canvas.fill((x + 1.0, top), (x + slot - 1.0, panel.bottom), colour)
    };
    if bins[0] > 0 {
        bar(panel.left, bins[0], palette::GREY)?;
    }
    canvas.text("0", (panel.left + slot / 2.0, panel.bottom + 22.0), Align::Centre, GREY)?;
    for (i, &count) in bins[low..=high].iter().enumerate() {
        if count > 0 {
            bar(left + i as f64 * slot, count, palette::BLUE)?;
        }
    }
    let edge = |bin: usize| left + (bin - low) as f64 * slot;
    let every = ((high - low) / 12 + 1) * 2;
    // Even bins begin at half powers of two, odd ones at powers of two.
    for bin in (low | 1..=high + 1).step_by(every) {
        let x = edge(bin);
        canvas.line(&[(x, panel.bottom), (x, panel.bottom + 6.0)], GREY, 1)?;
        let value = Histogram::least(bin);
        canvas.text(&short(value), (x, panel.bottom + 22.0), Align::Centre, GREY)?;
    }
    let middle = (panel.left + panel.right) / 2.0;
    canvas.text(name, (middle, panel.bottom + 50.0), Align::Centre, INK)?;
    marks(canvas, panel, bins, low, &edge)
}

/// A count of at most five characters.
fn short(value: f64) -> String {
    let text = if value < 1e4 { format!("{value:.0}") } else { engineering(value, "") };
    text.trim().to_owned()
}

/// Lines at the median and the 99th percentile, with their values over the panel.
fn marks(
    canvas: &Canvas,
    panel: Panel,
    bins: &Bins,
    low: usize,
    edge: &dyn Fn(usize) -> f64,
) -> Drawn {
    let mut said = Vec::new();
    for (words, share) in [("median", 0.5), ("p99", 0.99)] {
        let bin = quantile(bins, share);
        said.push(if bin == 0 {
            format!("{words} 0")
        } else {
            format!("{words} under {}", short(Histogram::least(bin + 1)))
        });
        if bin >= low {
            let x = edge(bin + 1);
            canvas.line(&[(x, panel.top), (x, panel.bottom)], palette::VERMILION, 2)?;
        }
    }
    let tiles = short(bins.iter().sum::<u64>() as f64);
    let text = format!("{tiles} tiles: {}", said.join(", "));
    canvas.bold(&text, (panel.left, panel.top - 26.0), Align::Left, INK)
}
