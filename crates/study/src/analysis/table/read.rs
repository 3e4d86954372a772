//! From rows to columns, a row at a time: rows of a CSV file, or cells that were just made.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use csv::StringRecord;

use super::words::WordBuilder;
use super::{BASELINE, Column, Over, Table, TableCounts, TableError, Values};
use crate::analysis::question::Question;
use crate::sweep::run::results::Results;
use crate::sweep::table::{Cell, Column as ResultColumn, MODEL};

/// The columns that come before the axes.
const FIXED: [&str; 8] =
    ["point", "is_baseline", "id", "status", "reason", "energy_table", "trace", "scope"];
/// The first column after the axes.
const FIRST_METRIC: &str = "frames";
/// Different reasons that are kept; the rest is counted under one name.
const REASONS_MAX: usize = 256;
/// Characters of a cell that an error shows, and of a reason that is kept.
const SHOWN: usize = 160;

impl Table {
    /// Reads the `results.csv` of a sweep. Of the metrics only those that `wants` says are kept, so
    /// that a million rows need no more memory than their needed columns.
    ///
    /// # Errors
    /// What is wrong with the text, with its line and column.
    pub fn read(input: impl Read, wants: impl Fn(&str) -> bool) -> Result<Table, TableError> {
        let mut reader = csv::Reader::from_reader(input);
        let head = reader.headers()?.clone();
        let names: Vec<&str> = head.iter().collect();
        let mut building = Building::new(&names, wants)?;
        let mut record = StringRecord::new();
        let mut n: u32 = 0;
        while reader.read_record(&mut record)? {
            building.row(&record, n)?;
            n = n.checked_add(1).ok_or(TableError::Rows(u32::MAX))?;
        }
        Ok(building.finish())
    }
}

impl Table {
    /// The results of a sweep as columns, those that a question needs. Objectives that are no
    /// columns are added by [`Table::compute`].
    ///
    /// # Errors
    /// As [`Collector`].
    pub fn of(results: &Results, question: &Question) -> Result<Table, TableError> {
        let mut table = Collector::new(&results.columns, |column| question.needs(column))?;
        results.rows.iter().try_for_each(|row| table.row(row))?;
        Ok(table.finish())
    }
}

/// A table that is made of rows as they come.
#[derive(Debug)]
pub struct Collector {
    building: Building,
    next: u32,
}

impl Collector {
    /// A table with these columns; of the metrics only those that `wants` says are kept.
    ///
    /// # Errors
    /// [`TableError::Twice`], [`TableError::Missing`]: these are no columns of a table of results.
    pub fn new(
        columns: &[ResultColumn],
        wants: impl Fn(&str) -> bool,
    ) -> Result<Collector, TableError> {
        let names: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
        Ok(Collector { building: Building::new(&names, wants)?, next: 0 })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// [`TableError::Rows`]: more rows than can be numbered.
    pub fn row(&mut self, row: &[Cell]) -> Result<(), TableError> {
        self.building.cells(row, self.next);
        self.next = self.next.checked_add(1).ok_or(TableError::Rows(u32::MAX))?;
        Ok(())
    }

    /// The table.
    pub fn finish(self) -> Table {
        self.building.finish()
    }
}

/// A metric column being read.
#[derive(Debug)]
enum ReadMetric {
    /// Empty cells only so far; how many.
    Empty(usize),
    Numbers(Vec<f64>),
    Words(WordBuilder),
}

/// A table being read.
#[derive(Debug, Default)]
struct Building {
    fixed: [usize; FIXED.len()],
    points: Vec<u64>,
    ids: Vec<u128>,
    energy_tables: WordBuilder,
    over: Vec<Over>,
    traces: WordBuilder,
    /// The column of the model of the DRAM; results of before have none.
    model: Option<usize>,
    models: WordBuilder,
    records: Vec<u32>,
    axes: Vec<(usize, String, WordBuilder)>,
    metrics: Vec<(usize, String, ReadMetric)>,
    metric_names: Vec<String>,
    ok: BTreeSet<u64>,
    invalid: BTreeSet<u64>,
    failed: BTreeSet<u64>,
    missing: BTreeSet<u64>,
    reasons: BTreeMap<String, Reason>,
}

/// Why points are invalid or failed.
#[derive(Debug)]
struct Reason {
    /// That of the first of them.
    example: String,
    points: usize,
    /// The last of them: its rows follow each other.
    last: u64,
}

impl Building {
    fn new(head: &[&str], wants: impl Fn(&str) -> bool) -> Result<Building, TableError> {
        let mut seen = BTreeSet::new();
        for &name in head {
            if !seen.insert(name) {
                return Err(TableError::Twice(shortened(name)));
            }
        }
        let place = |wanted: &str| {
            let found = head.iter().position(|&name| name == wanted);
            found.ok_or_else(|| TableError::Missing(wanted.to_owned()))
        };
        let mut building = Building::default();
        for (place_of, name) in building.fixed.iter_mut().zip(FIXED) {
            *place_of = place(name)?;
        }
        let first_metric = place(FIRST_METRIC)?;
        for (i, &name) in head.iter().enumerate() {
            if name == MODEL {
                building.model = Some(i);
                continue;
            }
            if FIXED.contains(&name) {
                continue;
            }
            if i < first_metric && !building.accompanies(name) {
                building.axes.push((i, name.to_owned(), WordBuilder::default()));
                continue;
            }
            building.metric_names.push(name.to_owned());
            if wants(name) {
                building.metrics.push((i, name.to_owned(), ReadMetric::Empty(0)));
            }
        }
        Ok(building)
    }

    /// Whether a column is the last axis once more, in SI units.
    fn accompanies(&self, name: &str) -> bool {
        let key = name.strip_suffix(".si");
        key.is_some_and(|key| self.axes.last().is_some_and(|(_, axis, _)| axis == key))
    }

    fn row(&mut self, record: &StringRecord, n: u32) -> Result<(), TableError> {
        let places = self.fixed;
        let cell = |i: usize| record.get(places[i]).unwrap_or("");
        let wrong = |i: usize, wanted| unreadable(record, FIXED[i], cell(i), wanted);
        let baseline = match cell(1) {
            "true" => true,
            "false" => false,
            _ => return Err(wrong(1, "`true` or `false`")),
        };
        let point = match cell(0).parse().ok().filter(|p| *p != BASELINE) {
            _ if baseline => BASELINE,
            Some(point) => point,
            None => return Err(wrong(0, "the number of a point")),
        };
        match self.count(point, cell(3), cell(4)) {
            Some(true) => {}
            Some(false) => return Ok(()),
            None => return Err(wrong(3, "a status: `ok`, `invalid`, `failed` or `missing`")),
        }
        let id =
            u128::from_str_radix(cell(2), 16).map_err(|_| wrong(2, "a hash: 32 hex digits"))?;
        let over = Over::named(cell(7)).ok_or_else(|| wrong(7, "`trace`, `mean` or `worst`"))?;
        self.points.push(point);
        self.ids.push(id);
        self.energy_tables.push(cell(5));
        self.over.push(over);
        self.traces.push(cell(6));
        self.models.push(self.model.and_then(|i| record.get(i)).unwrap_or(""));
        self.records.push(n);
        for (i, _, words) in &mut self.axes {
            words.push(record.get(*i).unwrap_or(""));
        }
        for (i, name, metric) in &mut self.metrics {
            let text = record.get(*i).unwrap_or("").trim();
            metric.push(text).map_err(|wanted| unreadable(record, name, text, wanted))?;
        }
        Ok(())
    }

    /// A row of cells that were made by [`crate::sweep::table::rows`].
    fn cells(&mut self, row: &[Cell], n: u32) {
        let places = self.fixed;
        let text = |i: usize| match &row[places[i]] {
            Cell::Text(text) => text.as_str(),
            _ => "",
        };
        let point = match row[places[0]] {
            Cell::Integer(point) => point as u64,
            _ => BASELINE,
        };
        let (Some(true), Ok(id), Some(over)) = (
            self.count(point, text(3), text(4)),
            u128::from_str_radix(text(2), 16),
            Over::named(text(7)),
        ) else {
            return;
        };
        self.points.push(point);
        self.ids.push(id);
        self.energy_tables.push(text(5));
        self.over.push(over);
        self.traces.push(text(6));
        self.models.push(&self.model.map_or(String::new(), |i| row[i].text()));
        self.records.push(n);
        for (i, _, words) in &mut self.axes {
            words.push(&row[*i].text());
        }
        for (i, _, metric) in &mut self.metrics {
            metric.push_cell(&row[*i]);
        }
    }

    /// Counts a row; whether it has results. `None` for a status that there is not.
    fn count(&mut self, point: u64, status: &str, reason: &str) -> Option<bool> {
        let set = match status {
            "ok" => &mut self.ok,
            "invalid" => &mut self.invalid,
            "failed" => &mut self.failed,
            "missing" => &mut self.missing,
            _ => return None,
        };
        if point != BASELINE {
            set.insert(point);
        }
        if !matches!(status, "ok" | "missing") {
            self.reason(point, status, reason);
        }
        Some(status == "ok")
    }

    /// Reasons about the same key are one, whatever their numbers are.
    fn reason(&mut self, point: u64, status: &str, text: &str) {
        let key = text.split('`').nth(1).unwrap_or(text);
        let cause = format!("{status} {}", shortened(key));
        let full = self.reasons.len() >= REASONS_MAX && !self.reasons.contains_key(&cause);
        let (cause, text) = if full { ("other".into(), "other") } else { (cause, text) };
        let example = format!("{status}: {}", shortened(text));
        let new = || Reason { example, points: 0, last: u64::MAX - 1 };
        let reason = self.reasons.entry(cause).or_insert_with(new);
        if reason.last != point {
            (reason.last, reason.points) = (point, reason.points + 1);
        }
    }

    fn finish(self) -> Table {
        let reasons = self.reasons.into_values().map(|r| (r.example, r.points));
        let mut reasons: Vec<(String, usize)> = reasons.collect();
        reasons.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let rows = self.points.len();
        let whole = |p: &&u64| {
            ![&self.invalid, &self.failed, &self.missing].iter().any(|set| set.contains(p))
        };
        Table {
            points: self.points,
            ids: self.ids,
            energy_tables: self.energy_tables.finish(),
            over: self.over,
            traces: self.traces.finish(),
            models: self.models.finish(),
            records: self.records,
            axes: self.axes.into_iter().map(|(_, name, words)| (name, words.finish())).collect(),
            followers: Vec::new(),
            counting: Vec::new(),
            metrics: self
                .metrics
                .into_iter()
                .map(|(_, name, metric)| Column { name, values: metric.finish(rows) })
                .collect(),
            metric_names: self.metric_names,
            counts: TableCounts {
                ok: self.ok.iter().filter(whole).count(),
                invalid: self.invalid.len(),
                failed: self.failed.len(),
                excluded: 0,
                missing: self.missing.len(),
            },
            reasons,
        }
    }
}

impl ReadMetric {
    fn push(&mut self, text: &str) -> Result<(), &'static str> {
        if let (&mut ReadMetric::Empty(n), false) = (&mut *self, text.is_empty()) {
            *self = ReadMetric::begun(text, n);
        }
        match self {
            ReadMetric::Empty(n) => *n += 1,
            ReadMetric::Numbers(numbers) if text.is_empty() => numbers.push(f64::NAN),
            ReadMetric::Numbers(numbers) => {
                let number = text.parse().map_err(|_| "a number, as the rows above have")?;
                numbers.push(number);
            }
            ReadMetric::Words(words) => words.push(text),
        }
        Ok(())
    }

    fn push_cell(&mut self, cell: &Cell) {
        let number = match cell {
            Cell::Real(x) => *x,
            Cell::Integer(n) => *n as f64,
            Cell::Empty | Cell::Text(_) | Cell::Truth(_) => f64::NAN,
        };
        if let (&mut ReadMetric::Empty(n), false) = (&mut *self, *cell == Cell::Empty) {
            *self = match cell {
                Cell::Text(text) => ReadMetric::begun(text, n),
                _ => ReadMetric::Numbers(vec![f64::NAN; n]),
            };
        }
        match self {
            ReadMetric::Empty(n) => *n += 1,
            ReadMetric::Numbers(numbers) => numbers.push(number),
            ReadMetric::Words(words) => words.push(&cell.text()),
        }
    }

    /// A column whose first value is `text`, after `n` empty cells.
    fn begun(text: &str, n: usize) -> ReadMetric {
        if text.parse::<f64>().is_ok() {
            return ReadMetric::Numbers(vec![f64::NAN; n]);
        }
        let mut words = WordBuilder::default();
        for _ in 0..n {
            words.push("");
        }
        ReadMetric::Words(words)
    }

    fn finish(self, rows: usize) -> Values {
        match self {
            ReadMetric::Empty(_) => Values::Numbers(vec![f64::NAN; rows]),
            ReadMetric::Numbers(numbers) => Values::Numbers(numbers),
            ReadMetric::Words(words) => Values::Words(words.finish()),
        }
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(SHOWN).collect()
}

fn unreadable(record: &StringRecord, column: &str, text: &str, wanted: &'static str) -> TableError {
    let line = record.position().map_or(0, csv::Position::line);
    TableError::Cell { line, column: shortened(column), text: shortened(text), wanted }
}
