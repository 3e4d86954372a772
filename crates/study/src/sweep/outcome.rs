//! What is kept of one design on one trace: the means of some statistics, and per frame what
//! quantiles are made of.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use powergs_core::flow;
use powergs_core::sim::statistics::{Statistic, Value, catalogue, find};
use powergs_core::sim::{FrameReport, Periods};

/// Version of what an outcome holds. Raised when a mean is added, moved or taken away: outcomes of
/// another version are simulated again.
pub(crate) const OUTCOME_VERSION: u32 = 7;

/// Statistics of which every frame's value is kept, because results have their quantiles.
pub(crate) const SAMPLED: [&str; 3] = ["frame_time_ms", "energy_pj.total", "power_w.total"];

/// Statistics of which the mean over the frames is kept; dotted names of the catalogue, `*` stands
/// for any last part.
const MEANS: [&str; 29] = [
    "frame_time_ms",
    "frame_latency_ms",
    "display_periods",
    "step.*",
    "displayed_fps",
    "deadline_missed",
    "frame_cycles",
    "preprocessing_cycles",
    "energy_pj.*",
    "power_w.*",
    "display_power_w",
    "rendering_plus_display_w",
    "area_mm2.*",
    "phy_standby_w",
    "dram_read_bytes",
    "dram_write_bytes",
    "sram_bytes",
    "dram.busy_frac",
    "dram.bandwidth_gb_s",
    "units.ccu.*_frac",
    "units.qsu.*_frac",
    "units.bsu.*_frac",
    "units.vru.*_frac",
    "units.vru.lane_utilisation",
    "counters.tile_pairs",
    "regions.r1.*",
    "regions.r2.*",
    "regions.r3.*",
    "regions.r4.*",
];

/// The statistics of which means are kept, in the order of the catalogue.
pub fn means() -> &'static [&'static Statistic] {
    static LIST: LazyLock<Vec<&'static Statistic>> = LazyLock::new(|| {
        // Of the units of other dataflows the shares of their cycles.
        let is_share = |s: &Statistic| {
            let is_default = s.flows.is_empty() || s.flows.contains(&flow::DEFAULT);
            !is_default && s.name.starts_with("units.") && s.name.ends_with("_frac")
        };
        let wanted =
            |s: &&Statistic| MEANS.iter().any(|pattern| fits(&s.name, pattern)) || is_share(s);
        catalogue().iter().filter(wanted).collect()
    });
    &LIST
}

/// Position of a statistic in [`means`].
pub fn place(name: &str) -> Option<usize> {
    means().iter().position(|s| s.name == name)
}

fn fits(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        None => name == pattern,
        Some((head, tail)) => {
            let rest = name.strip_prefix(head).and_then(|rest| rest.strip_suffix(tail));
            rest.is_some_and(|rest| !rest.contains('.'))
        }
    }
}

/// One design, one energy table, one trace.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Per frame, in the order of the trace: the values that percentiles are taken of.
    pub samples: Vec<[f64; SAMPLED.len()]>,
    /// Means over the frames, in the order of [`means`]; `None` where some frame has no value.
    pub means: Vec<Option<f64>>,
}

impl Outcome {
    /// Of the reports of frames in the order of their trace, the eyes of a period as one; `None`
    /// without frames.
    pub fn of(frames: &[FrameReport], display_fps: f64) -> Option<Outcome> {
        let mut sum = Accumulator::default();
        frames.iter().for_each(|frame| sum.add(frame.clone(), 1, display_fps));
        sum.finish()
    }
}

/// Adds up frames; they must come in the order of the trace.
#[derive(Debug, Clone)]
pub(crate) struct Accumulator {
    samples: Vec<[f64; SAMPLED.len()]>,
    /// Weighted sum of each mean.
    sums: Vec<Option<f64>>,
    /// Sum of its weights.
    weights: Vec<f64>,
    periods: Periods,
}

impl Default for Accumulator {
    fn default() -> Self {
        let n = means().len();
        Accumulator {
            samples: Vec::new(),
            sums: vec![Some(0.0); n],
            weights: vec![0.0; n],
            periods: Periods::default(),
        }
    }
}

impl Accumulator {
    /// Adds a view, of which a frame has `eyes`; its power at `display_fps` frames a second.
    pub fn add(&mut self, view: FrameReport, eyes: usize, display_fps: f64) {
        let Some(frame) = self.periods.add(view, eyes) else { return };
        let sample = |name| find(name)?.of(&frame, display_fps).map(Value::as_f64);
        self.samples.push(SAMPLED.map(|name| sample(name).unwrap_or(f64::NAN)));
        for ((sum, weights), statistic) in self.sums.iter_mut().zip(&mut self.weights).zip(means())
        {
            let weight = statistic.weight.of(&frame, display_fps);
            let value = statistic.of(&frame, display_fps);
            *sum = sum.zip(value).map(|(sum, value)| sum + value.as_f64() * weight);
            *weights += weight;
        }
    }

    /// The outcome of all frames; `None` without frames.
    pub fn finish(self) -> Option<Outcome> {
        (!self.samples.is_empty()).then(|| Outcome {
            means: self.sums.iter().zip(&self.weights).map(|(sum, n)| Some((*sum)? / n)).collect(),
            samples: self.samples,
        })
    }
}
