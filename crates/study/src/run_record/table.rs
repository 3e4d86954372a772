//! Every statistic of every frame of a run, and its aggregate over the frames: what `results.csv`
//! and `--json` write under the names of the catalogue.

use super::Run;
use powergs_core::sim::statistics::{Aggregate, Statistic, Value, catalogue, values};

/// Values of all frames in the order of the catalogue, and their aggregates.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// One row per reported frame.
    pub rows: Vec<Vec<Option<Value>>>,
    /// One per statistic; `None` where a frame has no value.
    pub aggregates: Vec<Option<Aggregate>>,
}

impl Table {
    /// The table of `run`.
    pub fn of(run: &Run) -> Table {
        let fps = run.facts.display_fps;
        let rows: Vec<_> = run.frames.iter().map(|frame| values(frame, fps)).collect();
        let aggregate = |(column, statistic): (usize, &Statistic)| {
            let weight = |frame| statistic.weight.of(frame, fps);
            Aggregate::weighted(
                rows.iter().zip(&run.frames).map(|(row, frame)| (row[column], weight(frame))),
            )
        };
        let aggregates = catalogue().iter().enumerate().map(aggregate).collect();
        Table { rows, aggregates }
    }

    /// The aggregate of the statistic that users know as `name`; `None` where no statistic has this
    /// name, or a frame has no value of it.
    pub fn aggregate(&self, name: &str) -> Option<Aggregate> {
        self.aggregates[catalogue().iter().position(|s| s.name == name)?]
    }

    /// The means in the order of the catalogue; `None` where a frame has no value.
    pub fn means(&self) -> Vec<Option<f64>> {
        self.aggregates.iter().map(|a| a.map(|a| a.mean)).collect()
    }
}
