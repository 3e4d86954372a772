//! `results.csv`: the record. One row per frame, then one per aggregate.

use super::document::{Cell, Column, Table};
use super::record_of;
use powergs_core::sim::statistics::{Aggregate, Record, Value, catalogue, shown, values};
use powergs_study::findings::compare::RESULTS_FIRST;
use powergs_study::run_record::Run;

/// The header: what kind of row it is (`frame`, `mean`, `p50`, …), frame number and name of the
/// view (empty in aggregates), whether the run is incomplete, then every statistic that machines of
/// the dataflow may have.
pub fn header(run: &Run) -> Vec<String> {
    names(&shown_of(&record_of(run)))
}

fn names(shown: &[usize]) -> Vec<String> {
    let statistics = shown.iter().map(|&i| catalogue()[i].name.clone());
    RESULTS_FIRST.iter().map(|s| (*s).to_owned()).chain(statistics).collect()
}

/// What machines like the one of a record may have, by places in the catalogue.
pub(crate) fn shown_of(record: &Record) -> Vec<usize> {
    shown(|i| record.aggregates[i].is_some())
}

/// The file. What was not measured is an empty cell; numbers are exact and never rounded.
///
/// # Panics
/// Without frames.
pub fn results(run: &Run) -> Vec<u8> {
    let record = record_of(run);
    let (shown, aggregates) = (shown_of(&record), &record.aggregates);
    let incomplete = Cell::from(run.incomplete());
    let mut table = Table::new(names(&shown).into_iter().map(Column::text));
    for frame in &run.frames {
        let (number, name) = (frame.frame.into(), frame.name.as_str().into());
        let first = [Cell::from("frame"), number, name, incomplete.clone()];
        let row = values(frame, run.facts.display_fps);
        table.row(first.into_iter().chain(shown.iter().map(|&i| row[i].map(cell).into())));
    }
    for (i, part) in Aggregate::PARTS.into_iter().enumerate() {
        let first = [part.into(), Cell::Empty, Cell::Empty, incomplete.clone()];
        let parts = shown.iter().map(|&s| aggregates[s].map(|a| cell(a.parts()[i])).into());
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
