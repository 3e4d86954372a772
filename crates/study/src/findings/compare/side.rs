//! One side of a comparison: a run that was just simulated, or a finished report folder.

use std::collections::BTreeSet;

use powergs_base::TOOL_VERSION;
use powergs_core::accel::machine::DramModel;
use powergs_core::sim::MODEL_VERSION;

use crate::findings::RunSummary;
use crate::run_record::{Run, SCHEMA_VERSION, Shown, Table, hash_text, record};

/// What a comparison needs to know about a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// What the columns are called: the machine or the folder.
    pub label: String,
    /// Name of the machine.
    pub machine: String,
    /// Name of the energy table.
    pub energy_table: String,
    /// Technology node, nanometres, where it is known.
    pub node_nm: Option<f64>,
    /// `cycle` or `paper`.
    pub model: String,
    /// `dram.model` of the machine; empty in the `paper` model.
    pub dram_model: String,
    /// What the DRAM prices rest on, each once: assumptions and references that the device cites,
    /// or that of the price of a byte; empty where the record does not say.
    pub dram_prices: Vec<String>,
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
    pub frames: u64,
    /// What each of them shows.
    pub shown: Shown,
    /// Whether frames are missing.
    pub incomplete: bool,
    /// Peak DRAM rate, 10⁹ bytes per second.
    pub dram_peak_gb_s: Option<f64>,
    /// The summary of the run.
    pub summary: RunSummary,
    /// Means of all statistics, in the order of the catalogue; `None` where a frame has no value.
    pub means: Vec<Option<f64>>,
    /// The record of the run, as in `run.toml`.
    pub record: toml::Table,
}

impl Side {
    /// A run that was just simulated; `None` without frames.
    pub fn of_run(run: &Run) -> Option<Side> {
        let facts = &run.facts;
        let input = |role: &str| facts.inputs.iter().find(|input| input.role == role);
        let hash = |role| input(role).map_or("?".to_owned(), hash_text);
        let record = record(run);
        Some(Side {
            dram_prices: dram_prices(&record),
            label: facts.machine.name.clone(),
            machine: facts.machine.name.clone(),
            energy_table: facts.machine.energy_table.clone(),
            node_nm: facts.machine.node_nm,
            model: facts.model.name().to_owned(),
            dram_model: facts.machine.dram_model.map_or("", DramModel::name).to_owned(),
            trace: facts.trace.name.clone(),
            trace_hash: hash("trace"),
            energy_hash: hash("energy"),
            tool_version: TOOL_VERSION.to_owned(),
            model_version: i64::from(MODEL_VERSION),
            schema_version: i64::from(SCHEMA_VERSION),
            display_fps: facts.display_fps,
            frames: run.frames.len() as u64,
            shown: facts.trace.shown,
            incomplete: run.incomplete(),
            dram_peak_gb_s: facts.machine.dram_peak_gb_s,
            summary: RunSummary::of(run)?,
            means: Table::of(run).means(),
            record,
        })
    }
}

/// What the DRAM prices of a recorded run rest on, sorted: what the prices at work cite.
pub(super) fn dram_prices(record: &toml::Table) -> Vec<String> {
    fn add(value: &toml::Value, found: &mut BTreeSet<String>) {
        let Some(table) = value.as_table() else { return };
        for (key, value) in table {
            match (key.as_str(), value.as_str()) {
                ("source" | "scale-source", Some(source)) => {
                    found.insert(source.to_owned());
                }
                _ => add(value, found),
            }
        }
    }
    let at = |path: &[&str]| {
        let mut value = record.get("configuration")?;
        for key in path {
            value = value.get(key)?;
        }
        Some(value)
    };
    let model = at(&["machine", "dram", "model"]).and_then(toml::Value::as_str);
    let by_device = at(&["energy", "dram", "device"]).and_then(toml::Value::as_bool);
    let counts_commands = model.is_some_and(|model| model != DramModel::Bandwidth.name());
    let prices = match counts_commands && by_device == Some(true) {
        true => at(&["dram", "energy"]),
        false => at(&["energy", "dram", "flat"]),
    };
    let mut found = BTreeSet::new();
    prices.iter().for_each(|prices| add(prices, &mut found));
    found.into_iter().collect()
}
