//! From CSV to columns, a row at a time.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use csv::StringRecord;

use super::words::Builder;
use super::{BASELINE, Column, Counts, Over, Table, TableError, Values};

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
        let mut building = Building::new(&head, wants)?;
        let mut record = StringRecord::new();
        let mut n: u32 = 0;
        while reader.read_record(&mut record)? {
            building.row(&record, n)?;
            n = n.checked_add(1).ok_or(TableError::Rows(u32::MAX))?;
        }
        Ok(building.finish())
    }
}

/// A metric column being read.
#[derive(Debug)]
enum Metric {
    /// Empty cells only so far; how many.
    Empty(usize),
    Numbers(Vec<f64>),
    Words(Builder),
}

/// A table being read.
#[derive(Debug, Default)]
struct Building {
    fixed: [usize; FIXED.len()],
    points: Vec<u64>,
    ids: Vec<u128>,
    energy_tables: Builder,
    over: Vec<Over>,
    traces: Builder,
    records: Vec<u32>,
    axes: Vec<(usize, String, Builder)>,
    metrics: Vec<(usize, String, Metric)>,
    metric_names: Vec<String>,
    ok: BTreeSet<u64>,
    failed: BTreeSet<u64>,
    missing: BTreeSet<u64>,
    reasons: BTreeMap<String, usize>,
}

impl Building {
    fn new(head: &StringRecord, wants: impl Fn(&str) -> bool) -> Result<Building, TableError> {
        let mut seen = BTreeSet::new();
        for name in head {
            if !seen.insert(name) {
                return Err(TableError::Twice(shortened(name)));
            }
        }
        let place = |wanted: &str| {
            let found = head.iter().position(|name| name == wanted);
            found.ok_or_else(|| TableError::Missing(wanted.to_owned()))
        };
        let mut building = Building::default();
        for (place_of, name) in building.fixed.iter_mut().zip(FIXED) {
            *place_of = place(name)?;
        }
        let first_metric = place(FIRST_METRIC)?;
        for (i, name) in head.iter().enumerate() {
            if FIXED.contains(&name) {
                continue;
            }
            if i < first_metric && !building.accompanies(name) {
                building.axes.push((i, name.to_owned(), Builder::default()));
                continue;
            }
            building.metric_names.push(name.to_owned());
            if wants(name) {
                building.metrics.push((i, name.to_owned(), Metric::Empty(0)));
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
            None => return Err(wrong(0, "number of a point")),
        };
        let set = match cell(3) {
            "ok" => &mut self.ok,
            "failed" => &mut self.failed,
            "missing" => &mut self.missing,
            _ => return Err(wrong(3, "status: `ok`, `failed` or `missing`")),
        };
        if !baseline {
            set.insert(point);
        }
        if cell(3) != "ok" {
            if cell(3) != "missing" {
                self.reason(cell(4));
            }
            return Ok(());
        }
        let id = u128::from_str_radix(cell(2), 16).map_err(|_| wrong(2, "hash: 32 hex digits"))?;
        let over = Over::named(cell(7)).ok_or_else(|| wrong(7, "`trace`, `mean` or `worst`"))?;
        self.points.push(point);
        self.ids.push(id);
        self.energy_tables.push(cell(5));
        self.over.push(over);
        self.traces.push(cell(6));
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

    fn reason(&mut self, text: &str) {
        let reason = shortened(text);
        let full = self.reasons.len() >= REASONS_MAX && !self.reasons.contains_key(&reason);
        *self.reasons.entry(if full { "other".into() } else { reason }).or_default() += 1;
    }

    fn finish(self) -> Table {
        let mut reasons: Vec<(String, usize)> = self.reasons.into_iter().collect();
        reasons.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let rows = self.points.len();
        let whole = |p: &&u64| !self.failed.contains(p) && !self.missing.contains(p);
        Table {
            points: self.points,
            ids: self.ids,
            energy_tables: self.energy_tables.finish(),
            over: self.over,
            traces: self.traces.finish(),
            records: self.records,
            axes: self.axes.into_iter().map(|(_, name, words)| (name, words.finish())).collect(),
            followers: Vec::new(),
            metrics: self
                .metrics
                .into_iter()
                .map(|(_, name, metric)| Column { name, values: metric.finish(rows) })
                .collect(),
            metric_names: self.metric_names,
            counts: Counts {
                ok: self.ok.iter().filter(whole).count(),
                failed: self.failed.len(),
                excluded: 0,
                missing: self.missing.len(),
            },
            reasons,
        }
    }
}

impl Metric {
    fn push(&mut self, text: &str) -> Result<(), &'static str> {
        if let (&mut Metric::Empty(n), false) = (&mut *self, text.is_empty()) {
            *self = Metric::begun(text, n);
        }
        match self {
            Metric::Empty(n) => *n += 1,
            Metric::Numbers(numbers) if text.is_empty() => numbers.push(f64::NAN),
            Metric::Numbers(numbers) => {
                let number = text.parse().map_err(|_| "number, and the rows above have numbers")?;
                numbers.push(number);
            }
            Metric::Words(words) => words.push(text),
        }
        Ok(())
    }

    /// A column whose first value is `text`, after `n` empty cells.
    fn begun(text: &str, n: usize) -> Metric {
        if text.parse::<f64>().is_ok() {
            return Metric::Numbers(vec![f64::NAN; n]);
        }
        let mut words = Builder::default();
        for _ in 0..n {
            words.push("");
        }
        Metric::Words(words)
    }

    fn finish(self, rows: usize) -> Values {
        match self {
            Metric::Empty(_) => Values::Numbers(vec![f64::NAN; rows]),
            Metric::Numbers(numbers) => Values::Numbers(numbers),
            Metric::Words(words) => Values::Words(words.finish()),
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
