//! The table of results: which columns it has, and its rows.
//!
//! One row per design, energy table and trace, and two aggregates over the traces of each design
//! and energy table: their weighted mean, and the worst of each column.

use super::metric::{Metric, Weighted, metrics, values};
use super::outcome::{Outcome, place};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Text; never absent.
    Text,
    /// Whole numbers.
    Integer,
    /// Numbers.
    Real,
    /// Yes or no.
    Truth,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name in the header.
    pub name: String,
    /// What it holds.
    pub kind: ColumnKind,
}

/// One cell. `Empty` is an empty text in text columns and null in others.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Nothing was measured, or it does not apply.
    Empty,
    /// Of a text column.
    Text(String),
    /// Of a column of whole numbers.
    Integer(i64),
    /// Of a column of numbers.
    Real(f64),
    /// Of a column of yes and no.
    Truth(bool),
}

impl Cell {
    /// As in a CSV file: exact, never rounded.
    pub fn text(&self) -> String {
        match self {
            Cell::Empty => String::new(),
            Cell::Text(text) => text.clone(),
            Cell::Integer(n) => n.to_string(),
            Cell::Real(x) => x.to_string(),
            Cell::Truth(yes) => yes.to_string(),
        }
    }
}

/// The columns before those of the axes: name, kind, definition.
pub const FIRST: [(&str, ColumnKind, &str); 9] = [
    (
        "point",
        ColumnKind::Integer,
        "Number of the design in the space, from 0; empty for the baseline.",
    ),
    (
        "is_baseline",
        ColumnKind::Truth,
        "Whether this is the base machine itself, without any axis.",
    ),
    (
        "id",
        ColumnKind::Text,
        "Hash of everything that makes the design: 32 hex digits. `sweep show ID --toml` writes \
         its machine file.",
    ),
    (
        "status",
        ColumnKind::Text,
        "`ok`, `invalid` (the configuration cannot exist), `failed` (its simulation went wrong) or \
         `missing` (the sweep was interrupted); only `ok` is part of an aggregate.",
    ),
    ("reason", ColumnKind::Text, "Why a design is invalid or failed."),
    ("energy_table", ColumnKind::Text, "Label of the energy table that priced the row."),
    (
        "trace",
        ColumnKind::Text,
        "Label of the trace; empty in `mean` rows, the slowest trace in `worst` rows.",
    ),
    (
        MODEL,
        ColumnKind::Text,
        "Model of the DRAM that made the row: `banked` for what was confirmed, `calibrated` for \
         the rest of a large sweep.",
    ),
    (
        "scope",
        ColumnKind::Text,
        "`trace` (one trace), `mean` (all traces by weight) or `worst` (of each column the largest \
         over the traces, of frame rates the smallest).",
    ),
];

/// The column of the model of the DRAM.
pub const MODEL: &str = "dram_model";

/// The columns behind the metrics: what is known of a design before it is simulated. Name, unit,
/// definition.
pub const LAST: [(&str, &str, &str); 3] = [
    ("leakage_w", "W", "Leakage of the chip when nothing is gated."),
    (
        "peak_w",
        "W",
        "Power of all blocks of the chip when each does all that it can in every cycle: a bound.",
    ),
    ("sram_capacity_bytes", "B", "Bytes of all buffers and the cache."),
];

/// All columns of a sweep with these axes over machines of a dataflow.
pub fn columns(axes: &[Column], flow: &str) -> Vec<Column> {
    let first = FIRST.iter().map(|&(name, kind, _)| Column { name: name.into(), kind });
    let last = metrics().iter().filter(|m| m.is_of(flow)).map(|m| Column {
        name: m.name.clone(),
        kind: if m.name == "frames" { ColumnKind::Integer } else { ColumnKind::Real },
    });
    let facts = LAST.iter().map(|f| Column { name: f.0.into(), kind: ColumnKind::Real });
    first.chain(axes.iter().cloned()).chain(last).chain(facts).collect()
}

/// A design in the table.
#[derive(Debug, Clone)]
pub struct TableEntry {
    /// Number in the space; `None` for the baseline.
    pub point: Option<u64>,
    /// Its hash; `None` if it is no machine.
    pub id: Option<u128>,
    /// The model of the DRAM that its results are of; empty if it is no machine.
    pub model: &'static str,
    /// The dataflow of the machines.
    pub flow: &'static str,
    /// Its cells in the columns of the axes.
    pub axes: Vec<Cell>,
    /// What is known of it before it is simulated under each energy table; none if it is no
    /// machine.
    pub facts: Vec<Facts>,
}

/// What is known of a design under an energy table before it is simulated, in the order of
/// [`LAST`].
pub type Facts = [Option<f64>; LAST.len()];

/// What became of a design on one trace.
#[derive(Debug, Clone, PartialEq)]
pub enum PointFate {
    /// It was simulated.
    Ok(Outcome),
    /// The configuration cannot exist, for this reason.
    Invalid(String),
    /// Its simulation went wrong, for this reason.
    Failed(String),
    /// Not yet.
    Missing,
}

impl PointFate {
    fn status(&self) -> TableStatus<'_> {
        match self {
            PointFate::Ok(_) => TableStatus::OK,
            PointFate::Invalid(reason) => TableStatus { word: "invalid", reason },
            PointFate::Failed(reason) => TableStatus { word: "failed", reason },
            PointFate::Missing => TableStatus::MISSING,
        }
    }

    fn outcome(&self) -> Option<&Outcome> {
        match self {
            PointFate::Ok(outcome) => Some(outcome),
            PointFate::Invalid(_) | PointFate::Failed(_) | PointFate::Missing => None,
        }
    }
}

/// The status of a row, and the reason where it failed.
#[derive(Clone, Copy)]
struct TableStatus<'a> {
    word: &'static str,
    reason: &'a str,
}

impl TableStatus<'_> {
    const OK: TableStatus<'static> = TableStatus { word: "ok", reason: "" };
    const MISSING: TableStatus<'static> = TableStatus { word: "missing", reason: "" };
}

/// A trace in the table.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceLabel {
    /// What the rows call it.
    pub label: String,
    /// Its weight in the mean; positive.
    pub weight: f64,
}

/// The rows of one design under one energy table: one per trace, then the aggregates. An aggregate
/// over traces of which one failed is failed; it has no numbers.
/// `table` is the place of the energy table among those of the sweep, with its label.
pub fn rows(
    entry: &TableEntry,
    table: (usize, &str),
    traces: &[TraceLabel],
    fates: &[PointFate],
) -> Vec<Vec<Cell>> {
    let mut rows = Vec::with_capacity(traces.len() + 2);
    for (trace, fate) in traces.iter().zip(fates) {
        let values = fate.outcome().map(|o| values(&[(trace.weight, o)]));
        rows.push(row(entry, fate.status(), table, &trace.label, "trace", values));
    }
    let outcomes: Option<Vec<Weighted>> =
        traces.iter().zip(fates).map(|(t, f)| Some((t.weight, f.outcome()?))).collect();
    match outcomes {
        Some(outcomes) if !outcomes.is_empty() => {
            let mean = values(&outcomes);
            rows.push(row(entry, TableStatus::OK, table, "", "mean", Some(mean)));
            let slowest = slowest(&outcomes);
            let worst = worst(&outcomes);
            let label = &traces[slowest].label;
            rows.push(row(entry, TableStatus::OK, table, label, "worst", Some(worst)));
        }
        _ => {
            let failed =
                fates.iter().find(|f| matches!(f, PointFate::Invalid(_) | PointFate::Failed(_)));
            let status = failed.map_or(TableStatus::MISSING, PointFate::status);
            rows.push(row(entry, status, table, "", "mean", None));
            rows.push(row(entry, status, table, "", "worst", None));
        }
    }
    rows
}

/// Of each column the largest over the traces, of frame rates the smallest.
fn worst(outcomes: &[Weighted]) -> Vec<Option<f64>> {
    let each = outcomes.iter().map(|outcome| values(std::slice::from_ref(outcome)));
    let worse = |metric: &Metric, a: f64, b: f64| match metric.is_rate() {
        true => a.min(b),
        false => a.max(b),
    };
    let all = each.reduce(|all, next| {
        let both = metrics().iter().zip(all.into_iter().zip(next));
        both.map(|(metric, (a, b))| a.zip(b).map(|(a, b)| worse(metric, a, b))).collect()
    });
    all.unwrap_or_default()
}

/// The trace with the largest mean frame time; the first of equals.
fn slowest(outcomes: &[Weighted]) -> usize {
    let time = place("frame_time_ms").expect("a mean");
    let ms = |i: usize| outcomes[i].1.means[time].unwrap_or(0.0);
    (0..outcomes.len()).fold(0, |best, i| if ms(i) > ms(best) { i } else { best })
}

fn row(
    entry: &TableEntry,
    status: TableStatus<'_>,
    (place, table): (usize, &str),
    trace: &str,
    scope: &str,
    values: Option<Vec<Option<f64>>>,
) -> Vec<Cell> {
    let text = |text: &str| Cell::Text(text.to_owned());
    let mut row = vec![
        entry.point.map_or(Cell::Empty, |p| Cell::Integer(p as i64)),
        Cell::Truth(entry.point.is_none()),
        entry.id.map_or(Cell::Empty, |id| Cell::Text(format!("{id:032x}"))),
        text(status.word),
        text(status.reason),
        text(table),
        text(trace),
        text(entry.model),
        text(scope),
    ];
    row.extend(entry.axes.iter().cloned());
    let values = values.unwrap_or_else(|| vec![None; metrics().len()]);
    let own = metrics().iter().zip(values).filter(|(metric, _)| metric.is_of(entry.flow));
    row.extend(own.map(|(metric, value)| match value {
        None => Cell::Empty,
        Some(frames) if metric.name == "frames" => Cell::Integer(frames as i64),
        Some(x) => Cell::Real(x),
    }));
    let facts = entry.facts.get(place).copied().unwrap_or_default();
    row.extend(facts.map(|fact| fact.map_or(Cell::Empty, Cell::Real)));
    row
}
