//! The metric columns of a table of results: name, unit, definition, and how each is made of the
//! outcomes of one trace or of several.

use std::sync::LazyLock;

use super::outcome::{Outcome, SAMPLED, means, place};
use powergs_base::config::suggest::nearest;
use powergs_core::sim::statistics::find;

/// The outcome of a trace and the weight that it has among the traces; positive.
pub type Weighted<'a> = (f64, &'a Outcome);

/// One column.
pub struct Metric {
    /// Dotted name, as in the header.
    pub name: String,
    /// Unit, `1` for counts and ratios.
    pub unit: &'static str,
    /// What it says.
    pub definition: String,
    /// The dataflows whose machines may have it; empty where all may.
    flows: Vec<&'static str>,
    make: Make,
}

impl Metric {
    /// Whether machines of a dataflow may have it.
    pub fn is_of(&self, flow: &str) -> bool {
        self.flows.is_empty() || self.flows.contains(&flow)
    }

    /// Whether it is a frame rate, of which less is worse.
    pub fn is_rate(&self) -> bool {
        self.unit == "1/s"
    }
}

/// A function of the columns before.
type OfOthers = fn(&dyn Fn(&str) -> Option<f64>) -> Option<f64>;

/// How a column is made.
enum Make {
    /// Frames that were simulated.
    Frames,
    /// Weighted mean over the traces of the mean over the frames: place in `outcome::means`.
    Mean(usize),
    /// Quantile over the frames of all traces, percent: place in `SAMPLED`.
    Quantile(usize, f64),
    /// A function of columns before it.
    Of(OfOthers),
}

impl std::fmt::Debug for Metric {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} [{}]", self.name, self.unit)
    }
}

/// All metric columns, in order.
pub fn metrics() -> &'static [Metric] {
    static LIST: LazyLock<Vec<Metric>> = LazyLock::new(all);
    &LIST
}

/// The values of [`metrics`] over some traces; `None` where a trace has no value. The weights are
/// those of the traces among each other, whatever their sum.
pub fn values(outcomes: &[Weighted]) -> Vec<Option<f64>> {
    let mut row: Vec<Option<f64>> = Vec::with_capacity(metrics().len());
    for metric in metrics() {
        let value = match &metric.make {
            Make::Frames => {
                Some(outcomes.iter().map(|(_, o)| o.samples.len()).sum::<usize>() as f64)
            }
            Make::Mean(place) => mean(outcomes, *place),
            Make::Quantile(sample, percent) => quantile(outcomes, *sample, *percent),
            Make::Of(function) => {
                let known = metrics().iter().zip(&row);
                function(&|name| known.clone().find(|(m, _)| m.name == name)?.1.to_owned())
            }
        };
        row.push(value.filter(|x| x.is_finite()));
    }
    row
}

/// The column that a wrong name is most likely meant to be. Where only the beginning was typed, the
/// mean of a statistic comes before its quantiles.
pub fn nearest_column<'a>(
    name: &str,
    columns: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let columns: Vec<&str> = columns.into_iter().collect();
    let near = nearest(name, columns.iter().copied())?;
    let is_quantile = |tail: &str| QUANTILES.iter().any(|(ending, _)| *ending == tail);
    let stem = near.rsplit_once('.').filter(|(_, tail)| is_quantile(tail) && !name.contains('.'));
    let mean = stem.map(|(stem, _)| format!("{stem}.mean"));
    let mean = mean.and_then(|mean| columns.iter().copied().find(|c| *c == mean));
    Some(mean.unwrap_or(near))
}

fn mean(outcomes: &[Weighted], place: usize) -> Option<f64> {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (weight, outcome) in outcomes {
        sum += weight * (*outcome.means.get(place)?)?;
        weights += weight;
    }
    Some(sum / weights)
}

/// The smallest value that at least `percent` of the weight is at or below. Every frame of a trace
/// has the same share of the trace's weight.
fn quantile(outcomes: &[Weighted], sample: usize, percent: f64) -> Option<f64> {
    let mut all = Vec::new();
    for (weight, outcome) in outcomes {
        let share = weight / outcome.samples.len() as f64;
        all.extend(outcome.samples.iter().map(|s| (s[sample], share)));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = all.iter().map(|(_, share)| share).sum();
    // A rounded sum of shares must not skip the value at which the rank is reached exactly.
    let wanted = total * (percent / 100.0) * (1.0 - 1e-12);
    let mut seen = 0.0;
    let reached = all.iter().find(|(_, share)| {
        seen += share;
        seen >= wanted
    });
    reached.or(all.last()).map(|(value, _)| *value)
}

/// Quantiles of a sampled statistic: ending, percent.
const QUANTILES: [(&str, f64); 4] = [("p50", 50.0), ("p95", 95.0), ("p99", 99.0), ("max", 100.0)];

fn all() -> Vec<Metric> {
    let mut list = vec![Metric {
        name: "frames".into(),
        unit: "1",
        definition: "Frames that were simulated.".into(),
        flows: Vec::new(),
        make: Make::Frames,
    }];
    for s in means() {
        let name = match SAMPLED.contains(&s.name.as_str()) {
            true => format!("{}.mean", s.name.trim_end_matches(".total")),
            false if s.name == "deadline_missed" => "deadline_missed_frac".into(),
            false => s.name.trim_end_matches(".total").to_owned(),
        };
        let definition = format!("Mean over the frames: {}", s.definition);
        let make = Make::Mean(place(&s.name).expect("a mean"));
        list.push(Metric { name, unit: s.unit, definition, flows: s.flows.clone(), make });
        if let Some(sample) = SAMPLED.iter().position(|name| *name == s.name) {
            quantiles(&mut list, sample);
        }
        match s.name.as_str() {
            "frame_time_ms" => {
                intervals(&mut list);
                fps(&mut list);
            }
            "dram_write_bytes" => list.push(of("dram_bytes", "B", DRAM_BYTES, dram_bytes)),
            _ => {}
        }
    }
    list.push(of("edp_pj_s", "pJ s", "`energy_pj.mean` x `frame_time_ms.mean`.", edp));
    list.push(of("power_full_rate_w", "W", FULL_RATE, full_rate));
    list
}

const DRAM_BYTES: &str = "`dram_read_bytes` + `dram_write_bytes`.";
const FULL_RATE: &str = "`energy_pj.mean` x `fps.mean`, as if frames ran back to back.";

fn quantiles(list: &mut Vec<Metric>, sample: usize) {
    let s = find(SAMPLED[sample]).expect("in the catalogue");
    for (ending, percent) in QUANTILES {
        let definition = match ending {
            "max" => format!("The largest of all frames of `{}`.", s.name),
            _ => format!(
                "{percent} % of the frames have a `{}` at or below this; with several traces every \
                 frame has its share of the weight of its trace.",
                s.name
            ),
        };
        let name = format!("{}.{ending}", s.name.trim_end_matches(".total"));
        let make = Make::Quantile(sample, percent);
        list.push(Metric { name, unit: s.unit, definition, flows: s.flows.clone(), make });
    }
}

fn of(name: &str, unit: &'static str, definition: &str, function: OfOthers) -> Metric {
    let (name, definition) = (name.into(), definition.into());
    Metric { name, unit, definition, flows: Vec::new(), make: Make::Of(function) }
}

/// The name that frame times have from now on.
fn intervals(list: &mut Vec<Metric>) {
    let mut add = |name: &str, function: OfOthers| {
        let means = format!("`{}`, by its new name.", name.replace("interval", "time"));
        list.push(of(name, "ms", &means, function));
    };
    add("frame_interval_ms.mean", |get| get("frame_time_ms.mean"));
    add("frame_interval_ms.p99", |get| get("frame_time_ms.p99"));
    add("frame_interval_ms.max", |get| get("frame_time_ms.max"));
}

fn fps(list: &mut Vec<Metric>) {
    let mean = "Frames per second back to back: 1000 / `frame_time_ms.mean`.";
    list.push(of("fps.mean", "1/s", mean, |get| Some(1e3 / get("frame_time_ms.mean")?)));
    let min = "Frames per second in the slowest frame: 1000 / `frame_time_ms.max`.";
    list.push(of("fps.min", "1/s", min, |get| Some(1e3 / get("frame_time_ms.max")?)));
}

fn dram_bytes(get: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
    Some(get("dram_read_bytes")? + get("dram_write_bytes")?)
}

fn edp(get: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
    Some(get("energy_pj.mean")? * get("frame_time_ms.mean")? * 1e-3)
}

fn full_rate(get: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
    Some(get("energy_pj.mean")? * 1e-12 * get("fps.mean")?)
}
