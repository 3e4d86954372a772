//! Histograms over tiles: list lengths of one frame, times of all frames.

use super::subtitle;
use crate::format::{counted, engineering};
use powergs_chart::{Axis, Bin, Chart, Colour, Entry, Mark, Panel, Rule, Scale, Symbol, Words};
use powergs_core::kernel::Histogram;
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
    let mut sorted = tiles.entries.clone();
    sorted.sort_unstable();
    let exact = |share: f64| {
        let place = (sorted.len() as f64 * share).ceil().max(1.0) as usize - 1;
        Quantile::Is(f64::from(sorted[place.min(sorted.len() - 1)]))
    };
    let frames = counted(run.frames.len(), "frame");
    let what = format!("lists of frame {}, times of {frames}", tiles.frame);
    let chart = Chart::new(NAME, TITLE, subtitle(run, &what)).columns(2).legend([
        Entry::new("median", Symbol::Line(MARK)),
        Entry::new("99th percentile", Symbol::Dashed(LAST)),
    ]);
    let title = "list length of a tile, Gaussians";
    let chart = chart.panel(panel(&lengths, title, SHARES.map(exact)));
    let timed = times.iter().any(|&n| n > 0);
    let title = "time of a tile in its renderer, cycles";
    let bins = SHARES.map(|share| Quantile::In(quantile(&times, share)));
    Some(if timed { chart.panel(panel(&times, title, bins)) } else { chart })
}

/// Shares of the tiles that have a line.
const SHARES: [f64; 2] = [0.5, 0.99];
const MARK: Colour = Colour::VERMILION;
const LAST: Colour = Colour::INK;

/// What a share of the tiles is at or below.
#[derive(Debug, Clone, Copy)]
enum Quantile {
    /// This value.
    Is(f64),
    /// A value in this bin.
    In(usize),
}

impl Quantile {
    fn words(self) -> String {
        match self {
            Quantile::Is(value) => short(value),
            Quantile::In(0) => "0".into(),
            Quantile::In(bin) => {
                let (from, to) = (Histogram::least(bin).ceil(), Histogram::least(bin + 1).ceil());
                format!("{} to {}", short(from), short((to - 1.0).max(from)))
            }
        }
    }

    /// Its place in bins: 2.5 is the middle of bin 2.
    fn place(self) -> f64 {
        match self {
            Quantile::Is(value) if value < 1.0 => 0.5,
            Quantile::Is(value) => 1.0 + 2.0 * value.log2(),
            Quantile::In(bin) => bin as f64 + 0.5,
        }
    }
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

/// Whether any whole number falls into a bin; some of the first have none.
fn holds_a_number(bin: usize) -> bool {
    Histogram::least(bin).ceil() < Histogram::least(bin + 1)
}

fn panel(bins: &Bins, name: &str, quantiles: [Quantile; 2]) -> Panel {
    let total = bins.iter().sum::<u64>().max(1) as f64;
    let used = |b: &usize| bins[*b] > 0;
    let low = (1..Histogram::BINS).find(used).unwrap_or(1);
    let high = (1..Histogram::BINS).rev().find(used).unwrap_or(1).max(low + 3);
    // Bins are equally wide: their edges are powers of the square root of two. Zeros have a bar of
    // their own, left of the scale.
    let edge = |bin: f64| bin - low as f64 + 2.0;
    let percent = |bin: usize| bins[bin] as f64 / total * 100.0;
    let bin = |from: f64, to: f64, bin: usize, colour| Bin {
        from,
        to,
        height: percent(bin),
        colour,
        label: String::new(),
    };
    let mut bars = vec![bin(0.0, 1.0, 0, Colour::GREY)];
    bars.extend((low..=high).filter(|b| holds_a_number(*b)).map(|b| {
        let empty = (b + 1..=high).take_while(|next| !holds_a_number(*next)).count();
        bin(edge(b as f64), edge((b + 1 + empty) as f64), b, Colour::BLUE)
    }));
    let every = ((high - low) / 12 + 1) * 2;
    // Even bins begin at half powers of two, odd ones at powers of two.
    let ticks = (low | 1..=high + 1).step_by(every);
    let mut labels = vec![(0.5, "0".to_owned())];
    labels.extend(ticks.map(|b| (edge(b as f64), short(Histogram::least(b)))));
    let highest = (0..Histogram::BINS).map(percent).fold(0.0, f64::max);
    let end = edge((high + 1) as f64);
    let x = Axis::new(format!("{name} (log)"), Scale::linear(0.0, end)).labelled(labels).plain();
    let y = Axis::new("share of the tiles, %", Scale::from_zero(highest));
    let mut panel = Panel::new(x, y).mark(Mark::Histogram { bins: bars, outlined: false });
    for (i, quantile) in quantiles.into_iter().enumerate() {
        let place = quantile.place();
        let x = if place < 1.0 { 0.5 } else { edge(place) };
        let colour = if i == 0 { MARK } else { LAST };
        panel = panel.mark(Mark::Rule { at: Rule::X(x.clamp(0.0, end)), colour, dashed: i > 0 });
    }
    let tiles = short(bins.iter().sum::<u64>() as f64);
    let [median, last] = quantiles.map(Quantile::words);
    panel.heading(Words::bold(format!("{tiles} tiles: median {median}, p99 {last}")))
}

/// A count of at most five characters.
fn short(value: f64) -> String {
    let text = if value < 1e4 { format!("{value:.0}") } else { engineering(value, "") };
    text.trim().to_owned()
}
