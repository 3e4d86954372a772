//! A finished report folder as a side of a comparison: its `run.toml` and `results.csv`.

use powergs_core::sim::statistics::{Aggregate, Key, Kind, Record, Statistic, Value, catalogue};

use super::Side;

/// Columns of `results.csv` before the statistics.
pub const RESULTS_FIRST: [&str; 4] = ["row", "frame", "name", "incomplete"];

/// A report folder that cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum SideError {
    /// `run.toml` is no TOML.
    #[error("run.toml: {0}; is this a finished report?")]
    Toml(#[from] toml::de::Error),
    /// A key is missing or of another type.
    #[error("run.toml: no {kind} `{key}`; is this a report of `replay`?")]
    Key {
        /// The key.
        key: &'static str,
        /// What it should be.
        kind: &'static str,
    },
    /// `results.csv` is no CSV.
    #[error("results.csv: {0}; run the replay again")]
    Csv(#[from] ::csv::Error),
    /// There is no row of means.
    #[error("results.csv: no row `{0}`; run the replay again")]
    Row(&'static str),
    /// A cell is no number.
    #[error("results.csv: row `{row}`, column `{column}`: `{cell}` is not a number")]
    Cell {
        /// Kind of row.
        row: &'static str,
        /// Name of the statistic.
        column: String,
        /// What is there.
        cell: String,
    },
}

impl Side {
    /// A finished report folder called `label`.
    ///
    /// # Errors
    /// Which of the two files is broken, and where.
    pub fn of_folder(label: &str, run_toml: &str, results_csv: &[u8]) -> Result<Side, SideError> {
        let statistics = |frames, display_fps| statistics(results_csv, frames, display_fps);
        Side::of_record(label, run_toml.parse()?, statistics)
    }
}

/// What `results.csv` says of every statistic of the catalogue. An older report without a column
/// leaves a gap.
fn statistics(results_csv: &[u8], frames: u64, display_fps: f64) -> Result<Record, SideError> {
    let mut reader = ::csv::Reader::from_reader(results_csv);
    let names = reader.headers()?.clone();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let is_part = record.get(0).is_some_and(|kind| Aggregate::PARTS.contains(&kind));
        rows.extend(is_part.then_some(record));
    }
    let row = |kind: &'static str| {
        rows.iter().find(|row| row.get(0) == Some(kind)).ok_or(SideError::Row(kind))
    };
    let means = row(Aggregate::PARTS[0])?;
    let aggregate = |statistic: &Statistic| {
        let column = |name: &str| names.iter().position(|column| column == name);
        let column = column(&statistic.name).or_else(|| column(first_name(&statistic.name)?));
        let is_filled = |at: &usize| means.get(*at).is_some_and(|cell| !cell.is_empty());
        let Some(at) = column.filter(is_filled) else { return Ok(None) };
        let part = |kind: &'static str| {
            let cell = row(kind)?.get(at).unwrap_or_default();
            value(cell, statistic.kind).ok_or_else(|| SideError::Cell {
                row: kind,
                column: statistic.name.clone(),
                cell: cell.chars().take(40).collect(),
            })
        };
        let [mean, p50, p95, p99, max] = Aggregate::PARTS.map(part);
        let mean = mean?.as_f64();
        Ok(Some(Aggregate { mean, p50: p50?, p95: p95?, p99: p99?, max: max? }))
    };
    let aggregates = catalogue().iter().map(aggregate).collect::<Result<_, SideError>>()?;
    Ok(Record { display_fps, frames, aggregates })
}

/// What older reports call a statistic.
fn first_name(name: &str) -> Option<&'static str> {
    (name == Key::Area.name()).then_some("area_mm2")
}

/// What a cell holds; `None` for what is no finite number. The mean of a count is a measure.
fn value(cell: &str, kind: Kind) -> Option<Value> {
    let count = cell.parse().ok().filter(|_| kind == Kind::Count).map(Value::Count);
    count.or_else(|| cell.parse().ok().filter(|x: &f64| x.is_finite()).map(Value::Real))
}
