//! Machines that were replayed one by one, in the table of a sweep: what differs between them takes
//! the place of the axes, and values of the caller come behind the metrics.

use std::collections::BTreeMap;

use toml::{Table, Value};

use super::outcome::Outcome;
use super::run::results::{Results, Tally};
use super::run::settings_columns;
use super::space::known;
use super::table::{Cell, Column, ColumnKind, PointFate, TableEntry, TraceLabel, columns, rows};
use powergs_core::run::System;
use powergs_core::run::files::FileKind;

/// A machine that was replayed, or that could not be.
#[derive(Debug)]
pub struct GatheredDesign<'a> {
    /// Its number; `None` for the base.
    pub point: Option<u64>,
    /// Its keys as the caller names them, besides [`differences`].
    pub settings: Vec<(String, Value)>,
    /// The machine, with its results on every trace; or why there is none.
    pub ran: Result<(&'a System, Vec<Outcome>), String>,
    /// Per value of the caller, on every trace.
    pub values: Vec<Vec<Option<f64>>>,
}

/// Keys of which machines have different values, and what each machine has there. Names,
/// descriptions and the display are no settings of a machine.
pub fn differences(systems: &[&System]) -> Vec<Vec<(String, Value)>> {
    let all: Vec<BTreeMap<String, Value>> = systems.iter().map(|system| flat(system)).collect();
    let Some((first, others)) = all.split_first() else { return Vec::new() };
    let differs = |key: &&String| others.iter().any(|other| other.get(*key) != first.get(*key));
    let mut keys: Vec<&String> = all.iter().flat_map(BTreeMap::keys).filter(differs).collect();
    keys.sort();
    keys.dedup();
    let of = |own: &BTreeMap<String, Value>| {
        let value = |key: &&String| Some(((*key).clone(), own.get(*key)?.clone()));
        keys.iter().filter_map(value).collect()
    };
    all.iter().map(of).collect()
}

fn flat(system: &System) -> BTreeMap<String, Value> {
    let mut found = BTreeMap::new();
    for kind in [FileKind::Machine, FileKind::Energy, FileKind::Dram] {
        let Some(table) = system.table(kind) else { continue };
        flatten(kind.prefix(), &table, &mut found);
    }
    for prefix in FileKind::ALL.map(FileKind::prefix) {
        for label in ["name", "description", "sources"] {
            found.remove(&format!("{prefix}{label}"));
        }
    }
    found
}

fn flatten(path: &str, table: &Table, found: &mut BTreeMap<String, Value>) {
    for (key, value) in table {
        match value {
            Value::Table(inner) => flatten(&format!("{path}{key}."), inner, found),
            value => drop(found.insert(format!("{path}{key}"), value.clone())),
        }
    }
}

/// The table of some machines: the first of `designs` is the base that others are compared with.
///
/// `labels` are the names of the traces, which count alike; `names` those of the values of the
/// caller, of which the largest over the traces is the worst.
///
/// # Panics
/// Without designs, or where the base has not run.
pub fn gathered(designs: &[GatheredDesign<'_>], labels: &[String], names: &[String]) -> Results {
    let (base, _) = designs[0].ran.as_ref().expect("the base has run");
    let flow = base.machine().flow().key();
    let settings: Vec<&[(String, Value)]> = designs.iter().map(|d| &*d.settings).collect();
    let (axes, cells) = settings_columns(&settings);
    let label = TraceLabel { label: String::new(), weight: 1.0 };
    let traces: Vec<TraceLabel> =
        labels.iter().map(|name| TraceLabel { label: name.clone(), ..label.clone() }).collect();
    let mut results = Results {
        columns: columns(&axes, flow),
        rows: Vec::new(),
        tally: Tally::default(),
        is_complete: true,
    };
    let own = names.iter().map(|name| Column { name: name.clone(), kind: ColumnKind::Real });
    results.columns.extend(own);
    for (design, axes) in designs.iter().zip(cells) {
        let point = design.point;
        let mut entry = TableEntry { point, id: None, model: "", flow, axes, facts: Vec::new() };
        let mut table = String::new();
        let fates: Vec<PointFate> = match &design.ran {
            Ok((system, outcomes)) => {
                entry.id = Some(system.id());
                entry.model = system.machine().dram.model.name();
                entry.facts = vec![known(system.machine(), Some(system.prices()))];
                table.clone_from(&system.energy_table().name);
                results.tally.ok += u64::from(point.is_some());
                outcomes.iter().cloned().map(PointFate::Ok).collect()
            }
            Err(reason) => {
                results.tally.invalid += 1;
                labels.iter().map(|_| PointFate::Invalid(reason.clone())).collect()
            }
        };
        for (place, mut row) in rows(&entry, (0, &table), &traces, &fates).into_iter().enumerate() {
            let value = |values: &Vec<Option<f64>>| over(values, place, labels.len());
            row.extend(
                design.values.iter().map(|values| value(values).map_or(Cell::Empty, Cell::Real)),
            );
            row.resize(results.columns.len(), Cell::Empty);
            results.rows.push(row);
        }
    }
    results
}

/// A value in the row at `place`: one of each trace, the mean, the worst.
fn over(values: &[Option<f64>], place: usize, traces: usize) -> Option<f64> {
    if place < traces {
        return *values.get(place)?;
    }
    let all: Vec<f64> = values.iter().copied().collect::<Option<_>>()?;
    match place == traces {
        true => Some(all.iter().sum::<f64>() / all.len() as f64),
        false => all.into_iter().reduce(f64::max),
    }
}
