//! Histograms over tiles: list lengths of one frame, times of all frames.

use super::subtitle;
use crate::format::engineering;
use powergs_chart::{Axis, Bin, Chart, Colour, Mark, Panel, Rule, Scale, Words};
use powergs_core::accel::Histogram;
use powergs_study::run_record::Run;

const NAME: &str = "tiles";
const TITLE: &str = "How uneven the tiles are";

/// Counts by bin, as in [`Histogram`].
type Bins = [u64; Histogram::BINS];

pub(super) fn chart(run: &Run) -> Option<Chart> {
    let tiles = run.tiles.as_ref().filter(|t| !t.entries.is_empty())?;
    let mut lengths: Bins = [0; Histogram::BINS];
    tiles.entries.iter().for_each(|&n| lengths[Histogram::bin(u64::from(n))] += 1);
    let mut times: Bins = [0; Histogram::BINS];
    for timing in run.frames.iter().filter_map(|f| f.timing()) {
        for (sum, n) in times.iter_mut().zip(timing.tile_cycles.bins) {
            *sum += u64::from(n);
        }
    }
    let what = format!("lists of frame {}, times of {} frames", tiles.frame, run.frames.len());
    let chart = Chart::new(NAME, TITLE, subtitle(run, &what)).columns(2);
    let chart = chart.panel(panel(&lengths, "list length of a tile, Gaussians"));
    let timed = times.iter().any(|&n| n > 0);
    Some(if timed {
        chart.panel(panel(&times, "time of a tile in its renderer, cycles"))
    } else {
        chart
    })
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

fn panel(bins: &Bins, name: &str) -> Panel {
    let total = bins.iter().sum::<u64>().max(1) as f64;
    let used = |b: &usize| bins[*b] > 0;
    let low = (1..Histogram::BINS).find(used).unwrap_or(1);
    let high = (1..Histogram::BINS).rev().find(used).unwrap_or(1).max(low + 3);
    // Bins are equally wide: their edges are powers of the square root of two. Zeros have a bar of
    // their own, left of the scale.
    let edge = |bin: usize| (bin - low) as f64 + 2.0;
    let percent = |bin: usize| bins[bin] as f64 / total * 100.0;
    let bin = |from: f64, bin: usize, colour| {
        let height = percent(bin);
        Bin { from, to: from + 1.0, height, colour, label: String::new() }
    };
    let mut bars = vec![bin(0.0, 0, Colour::GREY)];
    bars.extend((low..=high).map(|b| bin(edge(b), b, Colour::BLUE)));
    let every = ((high - low) / 12 + 1) * 2;
    // Even bins begin at half powers of two, odd ones at powers of two.
    let ticks = (low | 1..=high + 1).step_by(every);
    let mut labels = vec![(0.5, "0".to_owned())];
    labels.extend(ticks.map(|b| (edge(b), short(Histogram::least(b)))));
    let highest = (0..Histogram::BINS).map(percent).fold(0.0, f64::max);
    let x = Axis::new(name, Scale::linear(0.0, edge(high + 1))).labelled(labels).plain();
    let y = Axis::new("share of the tiles, %", Scale::from_zero(highest));
    let mut panel = Panel::new(x, y).mark(Mark::Histogram { bins: bars, outlined: false });
    let mut said = Vec::new();
    for (words, share) in [("median", 0.5), ("p99", 0.99)] {
        let bin = quantile(bins, share);
        said.push(if bin == 0 {
            format!("{words} 0")
        } else {
            format!("{words} under {}", short(Histogram::least(bin + 1)))
        });
        if bin >= low {
            let at = Rule::X(edge(bin + 1));
            panel = panel.mark(Mark::Rule { at, colour: Colour::VERMILION, dashed: false });
        }
    }
    let tiles = short(bins.iter().sum::<u64>() as f64);
    panel.heading(Words::bold(format!("{tiles} tiles: {}", said.join(", "))))
}

/// A count of at most five characters.
fn short(value: f64) -> String {
    let text = if value < 1e4 { format!("{value:.0}") } else { engineering(value, "") };
    text.trim().to_owned()
}
