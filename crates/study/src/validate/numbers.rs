//! The three tables: published numbers, workloads, and what came out the last time.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use super::row::{MachineName, Row, Status, Tolerance};
use super::{Metric, RowLedger, Workload};
use powergs_scene::synth::Preset;

const SIDE_MAX: u32 = 16_384;
/// The largest distance of eyes, thousandths of a world unit.
const EYES_MAX: usize = 1_000_000;
/// Most views of a workload, and frames of its path.
const VIEWS_MAX: usize = 1_000;
const PATH_MAX: usize = 100_000;

/// What is wrong with a table.
#[derive(Debug, Error)]
pub enum TablesError {
    /// Not CSV with these columns.
    #[error("{table}: {error}")]
    Csv {
        /// Which table.
        table: &'static str,
        /// What the CSV reader says, with the line.
        error: csv::Error,
    },
    /// No published number.
    #[error("published.csv: no rows; a header line and one row at least")]
    Empty,
    /// A cell that cannot be understood.
    #[error("{table}: `{id}`: {column} = `{value}`: {what}")]
    Cell {
        /// Which table.
        table: &'static str,
        /// Name of the row.
        id: String,
        /// Name of the column.
        column: &'static str,
        /// What is there.
        value: String,
        /// What should be there.
        what: String,
    },
}

/// What came out for a row on each of its workloads; under the empty name where it needs none.
pub type Parts = BTreeMap<String, f64>;

/// What came out the last time, by row.
pub type Baseline = BTreeMap<String, Parts>;

/// The value of a row: the mean over its workloads.
pub fn mean(parts: &Parts) -> Option<f64> {
    (!parts.is_empty()).then(|| parts.values().sum::<f64>() / parts.len() as f64)
}

/// What the first line of a baseline says before the version of the models that it was made with.
const MODEL: &str = "# model version ";

/// All three tables, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Tables {
    /// Published numbers, in the order of the file.
    pub rows: Vec<Row>,
    /// Their workloads, in the order of the file.
    pub workloads: Vec<Workload>,
    /// What came out the last time.
    pub baseline: Baseline,
    /// Version of the models that all of it came out of, where the file says so.
    pub model: Option<u32>,
    /// What each row is worth as evidence; empty where nothing says so.
    pub ledger: RowLedger,
}

impl Tables {
    /// Reads the three texts (CSV with a header line).
    ///
    /// # Errors
    /// The first cell that cannot be understood, with its table, row and column.
    pub fn parse(published: &str, workloads: &str, baseline: &str) -> Result<Tables, TablesError> {
        let workloads = parse_workloads(workloads)?;
        let rows = parse_rows(published, &workloads)?;
        let model = parse_model(baseline)?;
        let baseline = parse_baseline(baseline)?;
        Ok(Tables { rows, workloads, baseline, model, ledger: RowLedger::default() })
    }

    /// The same with the ledger of its rows.
    ///
    /// # Errors
    /// As [`RowLedger::parse`].
    pub fn with_ledger(self, text: &str) -> Result<Tables, TablesError> {
        Ok(Tables { ledger: RowLedger::parse(text, &self.rows)?, ..self })
    }

    /// The tables with a new baseline: values that were measured with `model`, on top of those of
    /// before.
    ///
    /// # Errors
    /// None that a baseline which [`baseline_csv`] writes can have.
    pub fn blessed(&self, measured: &Baseline, model: u32) -> Result<Tables, TablesError> {
        let text = baseline_csv(self, measured, model);
        let (baseline, model) = (parse_baseline(&text)?, parse_model(&text)?);
        Ok(Tables { baseline, model, ..self.clone() })
    }

    /// The tables that come with the program.
    ///
    /// # Panics
    /// Never: tests read them.
    pub fn embedded() -> Tables {
        let tables = Tables::parse(super::PUBLISHED, super::WORKLOADS, super::BASELINE);
        let tables = tables.and_then(|tables| tables.with_ledger(super::LEDGER));
        tables.expect("embedded tables are checked by tests")
    }

    /// Whether a row belongs to a quick run: it needs no frame, or only those of quick workloads.
    pub fn is_quick(&self, row: &Row) -> bool {
        let is_quick = |w: &Workload| w.quick || !row.workloads.contains(&w.name);
        self.workloads.iter().all(is_quick)
    }

    /// What came out for a row the last time, if it was measured on the same workloads.
    pub fn before(&self, row: &Row) -> Option<&Parts> {
        let is_same = |parts: &&Parts| row.part_names().all(|name| parts.contains_key(name));
        self.baseline.get(&row.id).filter(is_same)
    }
}

/// The text of a baseline: that of `tables` with the values of `measured` on top, for rows that
/// exist. It is of `model` if all of its values are: what is kept from before has to be, too.
pub fn baseline_csv(tables: &Tables, measured: &Baseline, model: u32) -> String {
    let is_kept = |row: &Row| !measured.contains_key(&row.id);
    let missing = Parts::new();
    let is_of_model = tables.model == Some(model) || !tables.rows.iter().any(is_kept);
    let mut text = match (is_of_model, tables.model) {
        (true, _) => format!("{MODEL}{model}\n"),
        (false, Some(old)) => format!("{MODEL}{old}\n"),
        (false, None) => String::new(),
    };
    text.push_str("id,workload,ours\n");
    for row in &tables.rows {
        let parts = measured.get(&row.id).or(tables.before(row)).unwrap_or(&missing);
        for name in row.part_names() {
            if let Some(value) = parts.get(name) {
                text.push_str(&format!("{},{name},{value:.6}\n", row.id));
            }
        }
    }
    text
}

pub(super) fn records<T: DeserializeOwned>(
    table: &'static str,
    text: &str,
) -> Result<Vec<T>, TablesError> {
    let mut reader = csv::ReaderBuilder::new();
    let mut reader = reader.trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let records = reader.deserialize().collect::<Result<_, _>>();
    records.map_err(|error| TablesError::Csv { table, error })
}

/// A row that is being read: makes errors.
pub(super) struct NumberPlace<'a> {
    pub(super) table: &'static str,
    pub(super) id: &'a str,
}

impl NumberPlace<'_> {
    pub(super) fn fault(
        &self,
        column: &'static str,
        value: &str,
        what: impl Into<String>,
    ) -> TablesError {
        let (table, id) = (self.table, self.id.to_owned());
        TablesError::Cell { table, id, column, value: value.to_owned(), what: what.into() }
    }

    /// The value, unless it is `None`.
    pub(super) fn need<T>(
        &self,
        column: &'static str,
        text: &str,
        value: Option<T>,
        what: &str,
    ) -> Result<T, TablesError> {
        value.ok_or_else(|| self.fault(column, text, what))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WorkloadRecord {
    name: String,
    preset: String,
    seed: u64,
    width: u32,
    height: u32,
    views: usize,
    path: usize,
    eyes: u32,
    quick: bool,
    why: String,
}

fn parse_workloads(text: &str) -> Result<Vec<Workload>, TablesError> {
    let mut names = BTreeSet::new();
    let mut workloads = Vec::new();
    for record in records::<WorkloadRecord>("workloads.csv", text)? {
        let place = NumberPlace { table: "workloads.csv", id: &record.name };
        if record.name.is_empty() || !names.insert(record.name.clone()) {
            return Err(place.fault("name", &record.name, "must be there, and only once"));
        }
        if Preset::named(&record.preset).is_none() {
            return Err(place.fault("preset", &record.preset, "no preset of `synth --list`"));
        }
        let between = |column, value: usize, least: usize, most: usize| {
            let what = format!("must be {least} to {most}");
            let fault = || place.fault(column, &value.to_string(), what);
            (least..=most).contains(&value).then_some(()).ok_or_else(fault)
        };
        between("width", record.width as usize, 1, SIDE_MAX as usize)?;
        between("height", record.height as usize, 1, SIDE_MAX as usize)?;
        between("views", record.views, 1, VIEWS_MAX)?;
        let least = if record.path == 0 { 0 } else { record.views + 1 };
        between("path", record.path, least, PATH_MAX)?;
        between("eyes", record.eyes as usize, 0, EYES_MAX)?;
        if record.eyes > 0 && record.path > 0 {
            return Err(place.fault("eyes", &record.eyes.to_string(), "must be 0 on a path"));
        }
        workloads.push(Workload {
            name: record.name,
            preset: record.preset,
            seed: record.seed,
            size: (record.width, record.height),
            views: record.views,
            path: record.path,
            eyes: record.eyes,
            quick: record.quick,
            why: record.why,
        });
    }
    Ok(workloads)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RowRecord {
    id: String,
    section: String,
    what: String,
    workload: String,
    machine: String,
    against: String,
    metric: String,
    published: f64,
    tolerance: String,
    status: String,
    class: String,
    missing: String,
    source: String,
    note: String,
}

fn parse_rows(text: &str, workloads: &[Workload]) -> Result<Vec<Row>, TablesError> {
    let mut ids = BTreeSet::new();
    let mut rows = Vec::new();
    for record in records::<RowRecord>("published.csv", text)? {
        let place = NumberPlace { table: "published.csv", id: &record.id };
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
        let is_name = !record.id.is_empty() && record.id.chars().all(plain);
        if !is_name || !ids.insert(record.id.clone()) {
            let what = "must be letters, digits and `-`, and there only once";
            return Err(place.fault("id", &record.id, what));
        }
        rows.push(row(&place, &record, workloads)?);
    }
    if rows.is_empty() { Err(TablesError::Empty) } else { Ok(rows) }
}

fn row(place: &NumberPlace, r: &RowRecord, workloads: &[Workload]) -> Result<Row, TablesError> {
    let metric = Metric::named(&r.metric);
    let metric = place.need("metric", &r.metric, metric, "not a metric")?;
    let names: Vec<String> = r.workload.split_whitespace().map(str::to_owned).collect();
    if names.is_empty() == metric.needs_frames() {
        let what = if metric.needs_frames() { "the metric needs one" } else { "must be empty" };
        return Err(place.fault("workload", &r.workload, what));
    }
    for (i, name) in names.iter().enumerate() {
        if !workloads.iter().any(|w| w.name == *name) {
            return Err(place.fault("workload", name, "not in workloads.csv"));
        }
        if names[..i].contains(name) {
            return Err(place.fault("workload", name, "appears twice"));
        }
    }
    if r.against.is_empty() == metric.compares() {
        let what = if metric.compares() { "the metric compares" } else { "must be empty" };
        return Err(place.fault("against", &r.against, what));
    }
    let published = Some(r.published).filter(|x| x.is_finite());
    let machine = MachineName::parse(&r.machine);
    let (status, tolerance) = expected(place, r)?;
    let gain = Some(r.missing.trim_matches('-').to_owned()).filter(|_| !r.missing.is_empty());
    if gain.is_some() && !(metric.compares() && r.published > 1.0) {
        return Err(place.fault("missing", &r.missing, "must be empty: the row is not a gain"));
    }
    Ok(Row {
        id: r.id.clone(),
        section: r.section.clone(),
        what: r.what.clone(),
        workloads: names,
        machine: place.need("machine", &r.machine, machine, "must name a machine")?,
        against: MachineName::parse(&r.against),
        metric,
        published: place.need(
            "published",
            &r.published.to_string(),
            published,
            "must be finite",
        )?,
        tolerance,
        status,
        gain,
        source: r.source.clone(),
        note: r.note.clone(),
    })
}

/// Status and tolerance, which depend on each other.
fn expected(
    place: &NumberPlace,
    r: &RowRecord,
) -> Result<(Status, Option<Tolerance>), TablesError> {
    let names = "must be enforced, calibrated, plausibility, dropped, or known_gap with a class: \
                 contradiction, mechanism, workload, preset";
    let cell = [r.status.as_str(), &r.class].join(" ");
    let status = Status::named(&r.status, &r.class);
    let status = place.need("status", cell.trim(), status, names)?;
    let tolerance = Tolerance::parse(&r.tolerance);
    let fault = |what: &str| Err(place.fault("tolerance", &r.tolerance, what));
    match (status, tolerance) {
        (Status::Dropped, _) if !r.tolerance.is_empty() => {
            fault("must be empty: nothing is decided")
        }
        (Status::Dropped, _) => Ok((status, None)),
        (_, None) => fault("must be 10% or 0.4..0.7"),
        (Status::Enforced, Some(t)) if t.width(r.published) > Status::NEAR + 1e-9 => {
            fault("an enforced row is within 25 %; what is wider is plausibility")
        }
        _ => Ok((status, tolerance)),
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BaselineRecord {
    id: String,
    workload: String,
    ours: f64,
}

fn parse_model(text: &str) -> Result<Option<u32>, TablesError> {
    let Some(version) = text.lines().next().and_then(|line| line.strip_prefix(MODEL)) else {
        return Ok(None);
    };
    let place = NumberPlace { table: "baseline.csv", id: MODEL.trim() };
    let number = version.trim().parse().ok();
    place.need("version", version, number, "must be a whole number").map(Some)
}

fn parse_baseline(text: &str) -> Result<Baseline, TablesError> {
    let mut baseline = Baseline::new();
    for record in records::<BaselineRecord>("baseline.csv", text)? {
        let place = NumberPlace { table: "baseline.csv", id: &record.id };
        if !record.ours.is_finite() {
            return Err(place.fault("ours", &record.ours.to_string(), "must be finite"));
        }
        let parts = baseline.entry(record.id.clone()).or_default();
        if parts.insert(record.workload.clone(), record.ours).is_some() {
            return Err(place.fault("workload", &record.workload, "appears twice"));
        }
    }
    Ok(baseline)
}
