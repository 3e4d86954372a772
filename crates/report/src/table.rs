//! The record of a run: a row of values per frame, an aggregate per statistic, and the few numbers
//! that belong to the run as a whole.

use super::{Means, Run};
use powergs_core::sim::statistics::{Aggregate, Value, catalogue, values};

/// Values of all frames in the order of the catalogue, and their aggregates.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// One row per reported frame.
    pub rows: Vec<Vec<Option<Value>>>,
    /// One per statistic; `None` where a frame has no value.
    pub aggregates: Vec<Option<Aggregate>>,
    /// Frames over the simulated time of all of them, per second: the rate of the run.
    pub throughput_fps: Option<f64>,
    /// Energy of all frames over the simulated time of all of them, watts: power at full rate.
    pub throughput_power_w: Option<f64>,
    /// Frames that took longer than the display period.
    pub deadline_misses: Option<u64>,
}

impl Table {
    /// The table of `run`.
    pub fn of(run: &Run) -> Table {
        let fps = run.facts.display_fps;
        let rows: Vec<_> = run.frames.iter().map(|frame| values(frame, fps)).collect();
        let aggregates = (0..catalogue().len())
            .map(|column| Aggregate::of(rows.iter().map(|row| row[column])))
            .collect();
        let mut table = Table {
            rows,
            aggregates,
            throughput_fps: None,
            throughput_power_w: None,
            deadline_misses: None,
        };
        let mean_s = table.mean("frame_time_ms").map(|ms| ms * 1e-3).filter(|s| *s > 0.0);
        table.throughput_fps = mean_s.map(|s| 1.0 / s);
        table.throughput_power_w =
            mean_s.and_then(|s| Some(table.mean("energy_pj.total")? * 1e-12 / s));
        table.deadline_misses = table.sum("deadline_missed").map(|n| n as u64);
        table
    }

    /// The means of all statistics that every frame has.
    pub fn means(&self) -> Means {
        Means::of(self)
    }

    /// The aggregate of the statistic called `name`, if all frames have it.
    pub fn aggregate(&self, name: &str) -> Option<Aggregate> {
        self.aggregates[column(name)]
    }

    /// The mean of the statistic called `name`, if all frames have it.
    pub fn mean(&self, name: &str) -> Option<f64> {
        Some(self.aggregate(name)?.mean)
    }

    /// The sum of the statistic called `name` over all frames.
    pub fn sum(&self, name: &str) -> Option<f64> {
        self.values(name).map(|values| values.iter().sum())
    }

    /// The values of the statistic called `name`, one per frame, if all frames have it.
    pub fn values(&self, name: &str) -> Option<Vec<f64>> {
        let column = column(name);
        if self.rows.is_empty() {
            return None;
        }
        self.rows.iter().map(|row| row[column].map(Value::as_f64)).collect()
    }
}

/// Position of a statistic in the catalogue. Only names that are written in this program are asked
/// for, so a name that is not there is a mistake of ours.
fn column(name: &str) -> usize {
    let found = catalogue().iter().position(|s| s.name == name);
    found.unwrap_or_else(|| panic!("no statistic is called `{name}`"))
}
