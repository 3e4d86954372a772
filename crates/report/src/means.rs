//! The mean of every statistic over the frames of a run: what one run is, to another one.

use std::collections::BTreeMap;

use super::Table;
use powergs_core::sim::statistics::catalogue;

/// Means by the name of the statistic; a statistic that some frame does not have is absent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Means(pub BTreeMap<String, f64>);

impl Means {
    /// The means of a table.
    pub fn of(table: &Table) -> Means {
        let pairs = catalogue().iter().zip(&table.aggregates);
        Means(pairs.filter_map(|(s, a)| Some((s.name.clone(), a.as_ref()?.mean))).collect())
    }

    /// The mean of the statistic called `name`.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }
}
