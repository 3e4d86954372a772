//! One side of a comparison: a run that was just simulated, or a finished report folder.

use std::collections::BTreeMap;

use toml::Value;

use crate::{Means, Run, Table};

/// What a comparison needs to know about a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// What the columns are called: the machine or the folder.
    pub label: String,
    /// Name of the machine.
    pub machine: String,
    /// Name of the energy table.
    pub energy_table: String,
    /// `cycle` or `paper`.
    pub model: String,
    /// `dram.model` of the machine; empty in the `paper` model.
    pub dram_model: String,
    /// Name of the trace.
    pub trace: String,
    /// XXH3 of the trace, hexadecimal.
    pub trace_hash: String,
    /// XXH3 of the energy table, hexadecimal.
    pub energy_hash: String,
    /// Version of the program.
    pub tool_version: String,
    /// Version of the model.
    pub model_version: i64,
    /// Version of the names.
    pub schema_version: i64,
    /// Display rate, frames per second.
    pub display_fps: f64,
    /// Frames that were reported.
    pub frames: i64,
    /// Whether frames are missing.
    pub incomplete: bool,
    /// Peak DRAM rate, 10⁹ bytes per second.
    pub dram_peak_gb_s: Option<f64>,
    /// 99 % of the frames take at most this, milliseconds.
    pub frame_time_p99_ms: Option<f64>,
    /// Means of the statistics.
    pub means: Means,
    /// The record that the above was read from, as in `run.toml`.
    pub record: toml::Table,
}

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
    #[error("results.csv: row `{row}`, column `{column}`: `{cell}` is no number")]
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
    /// A run that was just simulated.
    ///
    /// # Panics
    /// Never: a record that was just written can be read.
    pub fn of_run(run: &Run, table: &Table) -> Side {
        let record = crate::record::table(run);
        let mut side = of_record(record, "").expect("a record of this version");
        side.label = run.facts.machine.name.clone();
        side.means = table.means();
        side.frame_time_p99_ms = table.aggregate("frame_time_ms").map(|a| a.p99.as_f64());
        side
    }

    /// A finished report folder called `label`.
    ///
    /// # Errors
    /// Which of the two files is broken, and where.
    pub fn of_folder(label: &str, run_toml: &str, results_csv: &[u8]) -> Result<Side, SideError> {
        let mut side = of_record(run_toml.parse()?, label)?;
        side.means = Means(row(results_csv, "mean")?);
        side.frame_time_p99_ms = row(results_csv, "p99")?.get("frame_time_ms").copied();
        Ok(side)
    }

    /// Area of the chip, mm², where the energy table knows it.
    pub fn area_mm2(&self) -> Option<f64> {
        self.means.get("area_mm2.total").or_else(|| self.means.get("area_mm2"))
    }
}

fn of_record(record: toml::Table, label: &str) -> Result<Side, SideError> {
    let key = |key, kind| SideError::Key { key, kind };
    let integer = |name| record.get(name).and_then(Value::as_integer).ok_or(key(name, "integer"));
    let string = |name| record.get(name).and_then(Value::as_str).ok_or(key(name, "text"));
    let facts = record.get("facts").and_then(Value::as_table);
    let fact = |name: &str| facts.and_then(|f| f.get(name));
    let text = |name: &str| fact(name).and_then(Value::as_str).unwrap_or("?").to_owned();
    let inputs = record.get("inputs").and_then(Value::as_array).ok_or(key("inputs", "array"))?;
    let input = |role: &str, what: &str| {
        let found = inputs.iter().find(|i| i.get("role").and_then(Value::as_str) == Some(role));
        found.and_then(|i| i.get(what)).and_then(Value::as_str).unwrap_or("?").to_owned()
    };
    let dram =
        record.get("configuration").and_then(|c| c.get("machine")).and_then(|m| m.get("dram"));
    let display_fps = record.get("display-fps").and_then(Value::as_float);
    let incomplete = record.get("incomplete").and_then(Value::as_bool);
    Ok(Side {
        label: label.to_owned(),
        machine: text("machine"),
        energy_table: text("energy-table"),
        model: string("model")?.to_owned(),
        dram_model: dram
            .and_then(|d| d.get("model"))
            .and_then(Value::as_str)
            .unwrap_or_default()
            .to_owned(),
        trace: input("trace", "name"),
        trace_hash: input("trace", "xxh3-128"),
        energy_hash: input("energy", "xxh3-128"),
        tool_version: string("tool-version")?.to_owned(),
        model_version: integer("model-version")?,
        schema_version: integer("schema-version")?,
        display_fps: display_fps.ok_or(key("display-fps", "number"))?,
        frames: integer("frames-reported")?,
        incomplete: incomplete.ok_or(key("incomplete", "true or false"))?,
        dram_peak_gb_s: fact("dram-peak-gb-s").and_then(Value::as_float),
        frame_time_p99_ms: None,
        means: Means::default(),
        record,
    })
}

/// The cells of an aggregate that are not empty, by the name of their statistic.
fn row(results_csv: &[u8], kind: &'static str) -> Result<BTreeMap<String, f64>, SideError> {
    let mut reader = ::csv::Reader::from_reader(results_csv);
    let names = reader.headers()?.clone();
    for record in reader.records() {
        let record = record?;
        if record.get(0) != Some(kind) {
            continue;
        }
        let cells = names.iter().zip(&record).skip(crate::csv::FIRST.len());
        return cells
            .filter(|(_, cell)| !cell.is_empty())
            .map(|(name, cell)| {
                let value = cell.parse::<f64>().ok().filter(|x| x.is_finite());
                let wrong = || SideError::Cell {
                    row: kind,
                    column: name.into(),
                    cell: cell.chars().take(40).collect(),
                };
                Ok((name.to_owned(), value.ok_or_else(wrong)?))
            })
            .collect();
    }
    Err(SideError::Row(kind))
}

/// A number as people write it.
pub(super) fn number(x: f64) -> String {
    crate::format::rate(x)
}
