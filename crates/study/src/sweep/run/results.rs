//! The results of a sweep: the rows of its table, in the order of the space, from the journals.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, BufWriter, Read, Write};

use xxhash_rust::xxh3::Xxh3;

use super::finish::write_sources;
use super::folder::SweepFolder;
use super::opened::OpenedSweep;
use super::plan::Plan;
use super::records::Records;
use crate::sweep::metric::metrics;
use crate::sweep::parquet::ParquetWriter;
use crate::sweep::record::Record;
use crate::sweep::table::{
    Cell, Column, ColumnKind, FIRST, LAST, PointFate, TableEntry, columns, rows,
};
use powergs_base::format::spreadsheet_safe;
use powergs_core::run::store::NewFile;
use powergs_core::run::{RunError, Store};

/// The table as CSV.
pub const CSV: &str = "results.csv";
/// The same table as Parquet.
pub const PARQUET: &str = "results.parquet";

/// Why a text is no table of results.
#[derive(Debug, thiserror::Error)]
pub enum SweepTableError {
    /// It is no CSV, or reading failed.
    #[error("{0}")]
    Csv(#[from] csv::Error),
    /// A column that every table of results has is not there.
    #[error("no column `{0}`: is this the results.csv of a sweep?")]
    Missing(&'static str),
}

/// What a table has.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    /// Designs with all results. The baseline is not counted, here and below.
    pub ok: u64,
    /// Configurations that cannot exist.
    pub invalid: u64,
    /// Designs whose simulation went wrong, on some trace at least.
    pub failed: u64,
    /// Designs with a result missing; the baseline is one here.
    pub missing: u64,
    /// Designs on which the simulator contradicted itself; they are among the failed.
    pub defects: u64,
}

/// The columns of the table of a sweep.
pub fn header(sweep: &OpenedSweep<'_>) -> Vec<Column> {
    columns(sweep.designs.columns(), sweep.designs.flow())
}

/// A design of a plan, or a point that is no design, in the order of the space.
enum ResultSlot<'p> {
    /// Place in [`Plan::designs`].
    Design(usize),
    /// The point and the reason.
    Invalid(u64, &'p str),
}

fn slots(plan: &Plan) -> Vec<ResultSlot<'_>> {
    let mut slots = Vec::with_capacity(plan.designs.len() + plan.invalid.len());
    let mut invalid = plan.invalid.iter().peekable();
    for (design, planned) in plan.designs.iter().enumerate() {
        while let Some((point, reason)) = invalid.next_if(|(p, _)| Some(*p) < planned.point) {
            slots.push(ResultSlot::Invalid(*point, reason));
        }
        slots.push(ResultSlot::Design(design));
    }
    slots.extend(invalid.map(|(point, reason)| ResultSlot::Invalid(*point, reason)));
    slots
}

/// A plan, and what takes the place of some of its results.
#[derive(Clone, Copy)]
pub struct Planned<'p> {
    /// The plan of the sweep.
    pub plan: &'p Plan,
    /// Designs of the same space that were simulated with another model of the DRAM.
    pub confirmed: Option<&'p Plan>,
}

impl<'p> Planned<'p> {
    /// A plan as it is.
    pub fn of(plan: &'p Plan) -> Planned<'p> {
        Planned { plan, confirmed: None }
    }

    /// The plan with the results of a design, and its place there.
    fn source(self, design: usize) -> (&'p Plan, usize) {
        let point = self.plan.designs[design].point;
        let confirmed = self.confirmed.and_then(|plan| {
            let place = plan.designs.binary_search_by_key(&point, |d| d.point).ok()?;
            Some((plan, place))
        });
        confirmed.unwrap_or((self.plan, design))
    }
}

/// The rows of a slot, and whether something failed, is missing or is a defect of ours.
fn rows_of(
    sweep: &OpenedSweep<'_>,
    planned: Planned<'_>,
    records: &mut Records,
    slot: &ResultSlot<'_>,
) -> Result<(Vec<Vec<Cell>>, [bool; 3]), RunError> {
    let plan = planned.plan;
    let traces = sweep.labels();
    let (mut all, mut status) = (Vec::new(), [false; 3]);
    let (point, id) = match *slot {
        ResultSlot::Design(design) => (plan.designs[design].point, Some(plan.designs[design].id)),
        ResultSlot::Invalid(point, _) => (Some(point), None),
    };
    let facts = match *slot {
        ResultSlot::Design(design) => plan.facts[design * plan.tables..][..plan.tables].to_vec(),
        ResultSlot::Invalid(..) => Vec::new(),
    };
    let source = match *slot {
        ResultSlot::Design(design) => Some(planned.source(design)),
        ResultSlot::Invalid(..) => None,
    };
    let model = source.map_or("", |(plan, place)| plan.designs[place].model.name());
    let (flow, axes) = (sweep.designs.flow(), sweep.designs.cells(point));
    let entry = TableEntry { point, id, model, flow, axes, facts };
    for (t, label) in sweep.designs.tables().iter().enumerate() {
        let mut fates = Vec::new();
        for trace in &sweep.traces {
            let fate = match (slot, source) {
                (ResultSlot::Invalid(_, reason), _) => PointFate::Invalid((*reason).to_owned()),
                (_, None) => PointFate::Missing,
                (_, Some((plan, place))) if plan.unpriced.contains_key(&(place, t)) => {
                    PointFate::Invalid(plan.unpriced[&(place, t)].clone())
                }
                (_, Some((plan, place))) => match records.get(plan.key(place, t, trace.hash))? {
                    Some(Record::Ok(outcome)) => PointFate::Ok(outcome),
                    Some(Record::Failed(reason)) => PointFate::Failed(reason),
                    Some(Record::Defect(reason)) => {
                        status[2] = true;
                        PointFate::Failed(reason)
                    }
                    None => PointFate::Missing,
                },
            };
            status[0] |= matches!(fate, PointFate::Failed(_));
            status[1] |= matches!(fate, PointFate::Missing);
            fates.push(fate);
        }
        all.extend(rows(&entry, (t, label), &traces, &fates));
    }
    Ok((all, status))
}

/// Hands on every row of the table, in its order.
///
/// # Errors
/// [`RunError::Input`]: a journal that cannot be read; those of `row`.
pub fn each_row(
    sweep: &OpenedSweep<'_>,
    planned: Planned<'_>,
    records: &mut Records,
    mut row: impl FnMut(Vec<Cell>) -> Result<(), RunError>,
) -> Result<Tally, RunError> {
    let mut tally = Tally::default();
    let plan = planned.plan;
    for slot in slots(plan) {
        let (rows, status) = rows_of(sweep, planned, records, &slot)?;
        rows.into_iter().try_for_each(&mut row)?;
        let is_design = match slot {
            ResultSlot::Design(design) => plan.designs[design].point.is_some(),
            ResultSlot::Invalid(..) => {
                tally.invalid += 1;
                continue;
            }
        };
        match status {
            [true, ..] => tally.failed += u64::from(is_design),
            [false, true, _] => tally.missing += 1,
            [false, false, _] => tally.ok += u64::from(is_design),
        }
        tally.defects += u64::from(status[2]);
    }
    Ok(tally)
}

/// Some rows of the table by their place in it, the first after the header being 0.
///
/// # Errors
/// [`RunError::Input`]: a journal that cannot be read.
pub fn some_rows(
    sweep: &OpenedSweep<'_>,
    planned: Planned<'_>,
    records: &mut Records,
    places: &BTreeSet<u32>,
) -> Result<BTreeMap<u32, Vec<Cell>>, RunError> {
    let plan = planned.plan;
    let each = (plan.tables * (sweep.traces.len() + 2)) as u32;
    let mut found = BTreeMap::new();
    for (first, slot) in (0..).step_by(each as usize).zip(slots(plan)) {
        let mut wanted = places.range(first..first + each).peekable();
        if wanted.peek().is_some() {
            let (rows, _) = rows_of(sweep, planned, records, &slot)?;
            found.extend(wanted.map(|&place| (place, rows[(place - first) as usize].clone())));
        }
    }
    Ok(found)
}

/// Writes `results.csv` and `results.parquet`, each whole or not at all, and hands every row on;
/// returns what there is and the hash of the CSV.
///
/// # Errors
/// [`RunError::Output`]: the store cannot be written; [`RunError::Input`]: a journal that cannot be
/// read.
pub fn write(
    folder: &mut SweepFolder<'_>,
    sweep: &OpenedSweep<'_>,
    planned: Planned<'_>,
    also: &mut dyn FnMut(&[Cell]),
) -> Result<(Tally, u128), RunError> {
    let mut files = ResultFiles::create(folder.store, &header(sweep))?;
    let tally = each_row(sweep, planned, &mut folder.records, |row| {
        also(&row);
        files.row(row)
    })?;
    Ok((tally, files.finish()?))
}

/// What a column holds that is no axis.
fn fixed_kind(name: &str) -> Option<ColumnKind> {
    if let Some((_, kind, _)) = FIRST.iter().find(|(first, ..)| *first == name) {
        return Some(*kind);
    }
    if name == "frames" {
        return Some(ColumnKind::Integer);
    }
    let is_number = LAST.iter().any(|(last, ..)| *last == name)
        || metrics().iter().any(|metric| metric.name == name);
    is_number.then_some(ColumnKind::Real)
}

fn guessed_kind<'t>(texts: impl Iterator<Item = &'t str> + Clone) -> ColumnKind {
    let filled = texts.filter(|text| !text.is_empty());
    if filled.clone().next().is_none() {
        return ColumnKind::Text;
    }
    let kinds = [ColumnKind::Integer, ColumnKind::Real, ColumnKind::Truth];
    let all = |kind: &ColumnKind| filled.clone().all(|t| read_cell(*kind, t) != Cell::Empty);
    kinds.into_iter().find(all).unwrap_or(ColumnKind::Text)
}

/// A cell as [`Cell::text`] wrote it; empty where it is of another kind.
fn read_cell(kind: ColumnKind, text: &str) -> Cell {
    match kind {
        ColumnKind::Text if text.is_empty() => Cell::Empty,
        ColumnKind::Text => Cell::Text(text.to_owned()),
        ColumnKind::Integer => text.parse().map_or(Cell::Empty, Cell::Integer),
        ColumnKind::Real => text.parse().map_or(Cell::Empty, Cell::Real),
        ColumnKind::Truth => text.parse().map_or(Cell::Empty, Cell::Truth),
    }
}

/// Hashes what is written.
struct Hashed<W> {
    out: W,
    hash: Xxh3,
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.out.write(bytes)?;
        self.hash.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

type New = BufWriter<Box<dyn NewFile>>;

/// The two files on their way.
struct ResultFiles {
    csv: csv::Writer<Hashed<New>>,
    parquet: ParquetWriter<New>,
}

fn wrong(file: &str, error: impl std::error::Error) -> RunError {
    RunError::Output { place: file.to_owned(), message: powergs_core::run::error::causes(&error) }
}

impl ResultFiles {
    fn create(store: &dyn Store, columns: &[Column]) -> Result<ResultFiles, RunError> {
        let csv = Hashed { out: BufWriter::new(store.create(CSV)?), hash: Xxh3::new() };
        let mut csv = csv::Writer::from_writer(csv);
        csv.write_record(columns.iter().map(|c| c.name.as_str())).map_err(|e| wrong(CSV, e))?;
        let parquet = ParquetWriter::new(BufWriter::new(store.create(PARQUET)?), columns);
        let parquet = parquet.map_err(|e| RunError::Internal(format!("{PARQUET}: {e}")))?;
        Ok(ResultFiles { csv, parquet })
    }

    fn row(&mut self, row: Vec<Cell>) -> Result<(), RunError> {
        let cells = row.iter().map(|cell| spreadsheet_safe(cell.text()));
        self.csv.write_record(cells).map_err(|e| wrong(CSV, e))?;
        self.parquet.row(row).map_err(|e| wrong(PARQUET, e))
    }

    fn finish(self) -> Result<u128, RunError> {
        let csv = self.csv.into_inner().map_err(|e| wrong(CSV, e.into_error()))?;
        let Hashed { out, hash } = csv;
        let csv = out.into_inner().map_err(|e| wrong(CSV, e.into_error()))?;
        let parquet = self.parquet.finish().map_err(|e| wrong(PARQUET, e))?;
        let parquet = parquet.into_inner().map_err(|e| wrong(PARQUET, e.into_error()))?;
        csv.commit().map_err(|e| wrong(CSV, e))?;
        parquet.commit().map_err(|e| wrong(PARQUET, e))?;
        Ok(hash.digest128())
    }
}

/// The table of a sweep in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// The columns: what a row is of, the axes, the metrics.
    pub columns: Vec<Column>,
    /// The rows in the order of the space, the base machine first: one per trace, the mean over the
    /// traces and the worst of each column, for every energy table.
    pub rows: Vec<Vec<Cell>>,
    /// What became of the designs.
    pub tally: Tally,
    /// Whether no result is missing; not after a cancellation.
    pub is_complete: bool,
}

impl Results {
    /// The table of a plan, from the journals.
    ///
    /// # Errors
    /// [`RunError::Input`]: a journal that cannot be read.
    pub fn of(
        sweep: &OpenedSweep<'_>,
        plan: &Plan,
        records: &mut Records,
    ) -> Result<Results, RunError> {
        let mut rows = Vec::new();
        let tally = each_row(sweep, Planned::of(plan), records, |row| {
            rows.push(row);
            Ok(())
        })?;
        Ok(Results { columns: header(sweep), rows, tally, is_complete: tally.missing == 0 })
    }

    /// The table that a finished sweep wrote as CSV. What kind of values an axis has is guessed
    /// from all of them.
    ///
    /// # Errors
    /// What is wrong with the text.
    pub fn read(input: impl Read) -> Result<Results, SweepTableError> {
        let mut reader = csv::Reader::from_reader(input);
        let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        if let Some((name, ..)) = FIRST.iter().find(|(name, ..)| !names.iter().any(|n| n == name)) {
            return Err(SweepTableError::Missing(name));
        }
        let records = reader.records().collect::<Result<Vec<_>, _>>()?;
        let texts = |i: usize| records.iter().map(move |record| &record[i]);
        let column = |(i, name): (usize, &String)| {
            let kind = fixed_kind(name).unwrap_or_else(|| guessed_kind(texts(i)));
            Column { name: name.clone(), kind }
        };
        let columns: Vec<Column> = names.iter().enumerate().map(column).collect();
        let row = |record: &csv::StringRecord| {
            let cell = |(column, text): (&Column, &str)| match (text, fixed_kind(&column.name)) {
                // A word of a row is never absent.
                ("", Some(ColumnKind::Text)) => Cell::Text(String::new()),
                _ => read_cell(column.kind, text),
            };
            columns.iter().zip(record).map(cell).collect()
        };
        let rows = records.iter().map(row).collect();
        let mut results = Results { columns, rows, tally: Tally::default(), is_complete: false };
        // A design is as good as the worst of its energy tables.
        let mut fates: BTreeMap<String, u8> = BTreeMap::new();
        for row in results.means() {
            let word = |column| results.cell(row, column).map(Cell::text).unwrap_or_default();
            let fate = ["ok", "missing", "failed", "invalid"];
            let fate = fate.iter().position(|fate| *fate == word("status")).unwrap_or(1) as u8;
            let worst = fates.entry(word("point")).or_default();
            *worst = fate.max(*worst);
        }
        fates.remove("");
        let count = |fate: u8| fates.values().filter(|own| **own == fate).count() as u64;
        let [ok, missing, failed, invalid] = [0, 1, 2, 3].map(count);
        let tally = Tally { ok, missing, failed, invalid, defects: 0 };
        results.is_complete = tally.missing == 0;
        results.tally = tally;
        Ok(results)
    }

    /// Writes the table, as CSV and Parquet, into the store that its sweep was kept in, with what
    /// it was made from: whoever opens that sees a finished sweep.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be written.
    pub fn keep(&self, sweep: &OpenedSweep<'_>, store: &dyn Store) -> Result<(), RunError> {
        let mut files = ResultFiles::create(store, &self.columns)?;
        self.rows.iter().cloned().try_for_each(|row| files.row(row))?;
        write_sources(sweep, store)?;
        files.finish().map(drop)
    }

    /// The cell of a row in the column of this name.
    pub fn cell<'r>(&self, row: &'r [Cell], column: &str) -> Option<&'r Cell> {
        row.get(self.columns.iter().position(|c| c.name == column)?)
    }

    /// The number of a row in the column of this name.
    pub fn number(&self, row: &[Cell], column: &str) -> Option<f64> {
        match self.cell(row, column)? {
            Cell::Real(x) => Some(*x),
            Cell::Integer(n) => Some(*n as f64),
            Cell::Empty | Cell::Text(_) | Cell::Truth(_) => None,
        }
    }

    /// The rows of the means over all traces, one per design and energy table.
    pub fn means(&self) -> impl Iterator<Item = &Vec<Cell>> {
        let mean = Cell::Text("mean".into());
        self.rows.iter().filter(move |row| self.cell(row, "scope") == Some(&mean))
    }
}
