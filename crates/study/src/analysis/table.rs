//! The results of a sweep as columns: what `results.csv` says, the needed columns only.
//!
//! A row is one (point, energy table, trace) or an aggregate over the traces. The fixed columns
//! come first, then one column per axis, then `frames` and the metrics. Axis columns hold values as
//! they were written; behind a column `KEY` of measures stands `KEY.si` with the same as a number,
//! which counts as a metric. A metric column holds numbers if its first value is one, words
//! otherwise.
//! Only rows with the status `ok` are kept; the others are counted.

mod read;
mod words;

pub use read::Collector;
pub use words::Words;

use std::collections::{BTreeMap, BTreeSet};

use super::question::{AnalysisError, Objective};
use crate::sweep::expr::{Expr, Value};

/// The `point` of the base machine, which is no point of the space.
pub const BASELINE: u64 = u64::MAX;

/// Why a text is no table of results.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// It is no CSV, or reading failed.
    #[error("{0}")]
    Csv(#[from] csv::Error),
    /// A column that every table of results has is not there.
    #[error("no column `{0}`: is this the results.csv of a sweep?")]
    Missing(String),
    /// Two columns have one name.
    #[error("column `{0}` appears twice")]
    Twice(String),
    /// A cell that cannot be read.
    #[error("line {line}, column `{column}`: `{text}` is not {wanted}")]
    Cell {
        /// Line of the file, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// What stands there, shortened.
        text: String,
        /// What should.
        wanted: &'static str,
    },
    /// More rows than can be numbered.
    #[error("more than {0} rows: split the sweep")]
    Rows(u32),
}

/// The values of one column, a value per row.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers; NaN where nothing was measured.
    Numbers(Vec<f64>),
    /// Words.
    Words(Words),
}

/// A column besides the fixed ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name: a key of a file for an axis, a statistic for a metric.
    pub name: String,
    /// Its values.
    pub values: Values,
}

/// What a row is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Over {
    /// One trace.
    Trace,
    /// The weighted mean over the traces.
    Mean,
    /// Of each column the worst trace.
    Worst,
}

impl Over {
    /// As in the column `scope`.
    pub fn named(name: &str) -> Option<Over> {
        match name {
            "trace" => Some(Over::Trace),
            "mean" => Some(Over::Mean),
            "worst" => Some(Over::Worst),
            _ => None,
        }
    }
}

/// Points by what became of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TableCounts {
    /// Points that were simulated on every trace.
    pub ok: usize,
    /// Points that are configurations which cannot exist.
    pub invalid: usize,
    /// Points whose simulation went wrong on at least one trace.
    pub failed: usize,
    /// Points that a constraint of the sweep left out, where that is known.
    pub excluded: usize,
    /// Points that are not finished: the sweep was interrupted.
    pub missing: usize,
}

/// The results of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Number of the point of each row; [`BASELINE`] for the base machine.
    pub points: Vec<u64>,
    /// Hash of the design of each row.
    pub ids: Vec<u128>,
    /// Label of the energy table of each row.
    pub energy_tables: Words,
    /// What each row is over: one trace, the mean or the slowest of them.
    pub over: Vec<Over>,
    /// Label of the trace of each row; empty for aggregates.
    pub traces: Words,
    /// The model of the DRAM that each row is of; empty where that is not known.
    pub models: Words,
    /// Place of each row in the file, the first after the header being 0.
    pub records: Vec<u32>,
    /// One column per axis.
    pub axes: Vec<(String, Words)>,
    /// Columns that stand among the axes and follow from them: see [`Table::follow`].
    pub followers: Vec<(String, Words)>,
    /// Axes with a condition, and whether they count in each row: see [`Table::restrict`].
    pub counting: Vec<(String, Vec<bool>)>,
    /// The metrics that were wanted.
    pub metrics: Vec<Column>,
    /// Names of all metrics in the file, for suggestions.
    pub metric_names: Vec<String>,
    /// What became of the points.
    pub counts: TableCounts,
    /// Why points are invalid or failed: an example of each reason, with the number of points, the
    /// most frequent first.
    pub reasons: Vec<(String, usize)>,
}

impl Table {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether no row was simulated.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The numbers of the metric `name`, one per row; `None` if there is no such column of numbers.
    pub fn numbers(&self, name: &str) -> Option<&[f64]> {
        match &self.metrics.iter().find(|c| c.name == name)?.values {
            Values::Numbers(numbers) => Some(numbers),
            Values::Words(_) => None,
        }
    }

    /// Adds a column for every objective that is not one: an axis of numbers, or an expression.
    ///
    /// # Errors
    /// [`AnalysisError::Column`], [`AnalysisError::Objectives`]: names that are no columns, texts
    /// that are no expressions.
    pub fn compute(&mut self, objectives: &[Objective]) -> Result<(), AnalysisError> {
        for objective in objectives {
            let name = &objective.name;
            if self.metrics.iter().all(|c| c.name != *name) {
                let numbers = super::designs::computed(self, objective)?;
                let values = Values::Numbers(numbers);
                self.metrics.push(Column { name: name.clone(), values });
            }
        }
        Ok(())
    }

    /// The values of the axis or follower `name`.
    pub fn axis(&self, name: &str) -> Option<&Words> {
        let mut all = self.axes.iter().chain(&self.followers);
        all.find(|(axis, _)| axis == name).map(|(_, words)| words)
    }

    /// The row of each design, table and trace of `other` takes the place of that here: the metrics
    /// that both have, and the model.
    pub fn replace(&mut self, other: &Table) {
        let key = |table: &Table, row: usize| {
            let at = row as u32;
            let labels = [table.energy_tables.word(at), table.traces.word(at)];
            let over = table.over[row];
            // The slowest trace may be another one.
            let trace = if over == Over::Trace { labels[1] } else { "" };
            (table.points[row], over, labels[0].to_owned(), trace.to_owned())
        };
        let new: BTreeMap<_, usize> = (0..other.len()).map(|row| (key(other, row), row)).collect();
        let places: Vec<(usize, usize)> =
            (0..self.len()).filter_map(|row| Some((row, *new.get(&key(self, row))?))).collect();
        for column in &mut self.metrics {
            let Values::Numbers(numbers) = &mut column.values else { continue };
            let Some(others) = other.numbers(&column.name) else { continue };
            places.iter().for_each(|&(row, from)| numbers[row] = others[from]);
        }
        for &(row, from) in &places {
            self.models.set(row as u32, other.models.word(from as u32));
        }
    }

    /// Counts designs that the sweep left out by its constraints: they have no rows.
    pub fn leave_out(&mut self, designs: usize) {
        self.counts.excluded += designs;
    }

    /// Takes the columns of these names from the axes: derived keys, and all keys but one of those
    /// that are varied together. They can be asked for, but they are nothing that one would choose.
    pub fn follow(&mut self, names: &BTreeSet<String>) {
        let axes = std::mem::take(&mut self.axes);
        for column in axes {
            let list = match names.contains(&column.0) {
                true => &mut self.followers,
                false => &mut self.axes,
            };
            list.push(column);
        }
    }

    /// Notes in which rows axes count that have a condition: elsewhere their keys have some value,
    /// which nobody chose. A condition that the columns do not decide holds.
    pub fn restrict(&mut self, conditions: &[(String, Expr)]) {
        let counts = |expr: &Expr, row: u32| {
            let value = |name: &str| {
                let words = self.axis(name)?;
                let number = words.number(row).map(Value::Number);
                number.or_else(|| Some(Value::Text(words.word(row).to_owned())))
            };
            expr.holds(&value).unwrap_or(true)
        };
        let rows = 0..self.len() as u32;
        let counting = conditions.iter().filter(|(axis, _)| self.axis(axis).is_some());
        self.counting = counting
            .map(|(axis, expr)| (axis.clone(), rows.clone().map(|row| counts(expr, row)).collect()))
            .collect();
    }

    /// Whether an axis counts in a row: `cache.ways` does not without a cache.
    pub fn counts(&self, axis: &str, row: u32) -> bool {
        let found = self.counting.iter().find(|(name, _)| name == axis);
        found.is_none_or(|(_, counts)| counts[row as usize])
    }

    /// The number in a row, if it is there and finite.
    pub fn number(&self, name: &str, row: u32) -> Option<f64> {
        Some(self.numbers(name)?[row as usize]).filter(|x| x.is_finite())
    }

    /// Whether a row is the base machine.
    pub fn is_baseline(&self, row: u32) -> bool {
        self.points[row as usize] == BASELINE
    }

    /// `#12`, or `baseline`.
    pub fn label(&self, row: u32) -> String {
        match self.points[row as usize] {
            BASELINE => "baseline".into(),
            point => format!("#{point}"),
        }
    }

    /// The values of the axes that count in a row, as they were written.
    pub fn settings(&self, row: u32) -> Vec<(&str, &str)> {
        let counting = self.axes.iter().filter(|(name, _)| self.counts(name, row));
        counting.map(|(name, words)| (name.as_str(), words.word(row))).collect()
    }
}
