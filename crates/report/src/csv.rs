//! `results.csv`: the record. One row per frame, then one per aggregate.

use super::ReportError;
use powergs_core::sim::statistics::{Aggregate, Value, catalogue};
use powergs_study::findings::compare::RESULTS_FIRST;
use powergs_study::run_record::{Run, Table};

/// The header: what kind of row it is (`frame`, `mean`, `p50`, …), frame number and name of the
/// view (empty in aggregates), whether the run is incomplete, then every statistic.
pub fn header() -> Vec<String> {
    let statistics = catalogue().iter().map(|s| s.name.clone());
    RESULTS_FIRST.iter().map(|s| (*s).to_owned()).chain(statistics).collect()
}

/// The file. What was not measured is an empty cell; numbers are exact and never rounded.
///
/// # Errors
/// [`ReportError::Csv`], which would be a mistake of ours.
pub fn results(run: &Run) -> Result<Vec<u8>, ReportError> {
    let table = Table::of(run);
    let incomplete = run.incomplete().to_string();
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    writer.write_record(header())?;
    for (frame, row) in run.frames.iter().zip(&table.rows) {
        let first = ["frame".into(), frame.frame.to_string(), frame.name.clone()];
        let cells = row.iter().map(|value| value.map_or(String::new(), cell));
        writer.write_record(first.into_iter().chain([incomplete.clone()]).chain(cells))?;
    }
    for (i, part) in Aggregate::PARTS.into_iter().enumerate() {
        let first = [part.to_owned(), String::new(), String::new(), incomplete.clone()];
        let cells =
            table.aggregates.iter().map(|a| a.map_or(String::new(), |a| cell(a.parts()[i])));
        writer.write_record(first.into_iter().chain(cells))?;
    }
    Ok(writer.into_inner().expect("writing to memory cannot fail"))
}

fn cell(value: Value) -> String {
    match value {
        Value::Count(n) => n.to_string(),
        Value::Real(x) => x.to_string(),
    }
}
