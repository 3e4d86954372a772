//! `results.csv`: the record. One row per frame, then one per aggregate.

use super::document::{Cell, Column, Table};
use super::record_of;
use powergs_core::sim::statistics::{Aggregate, Value, catalogue, values};
use powergs_study::findings::compare::RESULTS_FIRST;
use powergs_study::run_record::Run;

/// The header: what kind of row it is (`frame`, `mean`, `p50`, …), frame number and name of the
/// view (empty in aggregates), whether the run is incomplete, then every statistic.
pub fn header() -> Vec<String> {
    let statistics = catalogue().iter().map(|s| s.name.clone());
    RESULTS_FIRST.iter().map(|s| (*s).to_owned()).chain(statistics).collect()
}

/// The file. What was not measured is an empty cell; numbers are exact and never rounded.
///
/// # Panics
/// Without frames.
pub fn results(run: &Run) -> Vec<u8> {
    let aggregates = record_of(run).aggregates;
    let incomplete = Cell::from(run.incomplete());
    let mut table = Table::new(header().into_iter().map(Column::text));
    for frame in &run.frames {
        let (number, name) = (frame.frame.into(), frame.name.as_str().into());
        let first = [Cell::from("frame"), number, name, incomplete.clone()];
        let row = values(frame, run.facts.display_fps);
        table.row(first.into_iter().chain(row.iter().map(|value| value.map(cell).into())));
    }
    for (i, part) in Aggregate::PARTS.into_iter().enumerate() {
        let first = [part.into(), Cell::Empty, Cell::Empty, incomplete.clone()];
        let parts = aggregates.iter().map(|a| a.map(|a| cell(a.parts()[i])).into());
        table.row(first.into_iter().chain(parts));
    }
    table.csv()
}

fn cell(value: Value) -> Cell {
    match value {
        Value::Count(n) => n.into(),
        Value::Real(x) => x.into(),
    }
}
