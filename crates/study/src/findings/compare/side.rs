//! One side of a comparison: a run that was just simulated, or a finished report folder.

use crate::findings::masters::MastersAsked;
use powergs_core::machine::MASTERS;
use std::collections::BTreeSet;

use powergs_base::quantity::{BytesPerSecond, Hertz};
use powergs_core::flow::Task;
use powergs_core::machine::DramModel;
use powergs_core::sim::statistics::Record;
use toml::Value;

use powergs_energy::table::{AreaScope, PowerScope};

use super::SideError;
use super::basis;
use crate::run_record::{Run, Shown, record};

/// A machine whose prices are for another clock, and are as given at any.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffClock {
    /// Clock of the machine.
    pub clock: Hertz,
    /// Clock of the prices.
    pub prices: Hertz,
}

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
    /// What a frame of it is.
    pub task: Task,
    /// Whether its area is that of a block that renders, and not of a whole SoC or GPU.
    pub is_block: bool,
    /// What its powers and energies are of: `block and memory`, `module`, `board`.
    pub power_scope: String,
    /// What other masters of its memory ask for.
    pub masters: MastersAsked,
    /// Effects that it leaves out, in words; empty where an older record does not say.
    pub left_out: Vec<String>,
    /// `cycle` or `paper`.
    pub model: String,
    /// `dram.model` of the machine; empty in the `paper` model.
    pub dram_model: String,
    /// What the DRAM prices rest on, each once: assumptions and references that the device cites,
    /// or that of the price of a byte; empty where the record does not say.
    pub dram_prices: Vec<String>,
    /// Its clock and that of its prices, where these differ and the energy table has no curve.
    pub off_clock: Option<OffClock>,
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
    /// Every statistic over the frames.
    pub statistics: Record,
    /// The record of the run, as in `run.toml`.
    pub record: toml::Table,
}

impl Side {
    /// Whether its frames are shown, all of them at the rate of the display.
    pub fn reaches_display(&self) -> bool {
        self.task.is_shown() && self.statistics.deadline_misses().is_none_or(|missed| missed == 0)
    }

    /// A run that was just simulated; `None` without frames.
    pub fn of_run(run: &Run) -> Option<Side> {
        let statistics = run.statistics()?;
        let side = Side::of_record(&run.facts.machine.name, record(run), |_, _| Ok(statistics));
        Some(side.expect("the record of a run has what its reader wants"))
    }

    /// The side called `label` that `record` tells of, with `statistics` of a number of frames on a
    /// display at a number of frames per second.
    pub(super) fn of_record(
        label: &str,
        record: toml::Table,
        statistics: impl FnOnce(u64, f64) -> Result<Record, SideError>,
    ) -> Result<Side, SideError> {
        let key = |key, kind| SideError::Key { key, kind };
        let integer =
            |name| record.get(name).and_then(Value::as_integer).ok_or(key(name, "integer"));
        let string = |name| record.get(name).and_then(Value::as_str).ok_or(key(name, "text"));
        let facts = record.get("facts").and_then(Value::as_table);
        let fact = |name: &str| facts.and_then(|f| f.get(name));
        let text = |name: &str| fact(name).and_then(Value::as_str).unwrap_or("?").to_owned();
        let inputs =
            record.get("inputs").and_then(Value::as_array).ok_or(key("inputs", "array"))?;
        let input = |role: &str, what: &str| {
            let found = inputs.iter().find(|i| i.get("role").and_then(Value::as_str) == Some(role));
            found.and_then(|i| i.get(what)).and_then(Value::as_str).unwrap_or("?").to_owned()
        };
        let dram =
            record.get("configuration").and_then(|c| c.get("machine")).and_then(|m| m.get("dram"));
        let display_fps = record.get("display-fps").and_then(Value::as_float);
        let incomplete = record.get("incomplete").and_then(Value::as_bool);
        let frames = integer("frames-reported")?.unsigned_abs();
        let size = |name: &str| fact(name).and_then(Value::as_integer).unwrap_or_default() as u32;
        // Reports of before know no pairs.
        let eyes = fact("eyes").and_then(Value::as_integer).unwrap_or(1).max(1) as usize;
        let shown = Shown { eyes, width: size("width-px"), height: size("height-px") };
        let display_fps = display_fps.ok_or(key("display-fps", "number"))?;
        let incomplete = incomplete.ok_or(key("incomplete", "true or false"))?;
        Ok(Side {
            label: label.to_owned(),
            machine: text("machine"),
            energy_table: text("energy-table"),
            node_nm: fact("node-nm").and_then(Value::as_float),
            task: basis::task(facts),
            is_block: !is_whole_chip(&record),
            power_scope: power_scope(&record),
            left_out: {
                let all = fact("left-out").and_then(Value::as_array).into_iter().flatten();
                all.filter_map(Value::as_str).map(str::to_owned).collect()
            },
            masters: masters_of(&record),
            model: string("model")?.to_owned(),
            dram_model: dram
                .and_then(|d| d.get("model"))
                .and_then(Value::as_str)
                .unwrap_or_default()
                .to_owned(),
            dram_prices: dram_prices(&record),
            off_clock: off_clock(&record),
            trace: text("trace"),
            trace_hash: input("trace", "xxh3-128"),
            energy_hash: input("energy", "xxh3-128"),
            tool_version: string("tool-version")?.to_owned(),
            model_version: integer("model-version")?,
            schema_version: integer("schema-version")?,
            display_fps,
            frames,
            shown,
            incomplete,
            dram_peak_gb_s: fact("dram-peak-gb-s").and_then(Value::as_float),
            statistics: statistics(frames, display_fps)?,
            record,
        })
    }
}

/// What the DRAM prices of a recorded run rest on, sorted: what the prices at work cite.
fn dram_prices(record: &toml::Table) -> Vec<String> {
    fn add(value: &Value, found: &mut BTreeSet<String>) {
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
    let at = |path: &[&str]| configured(record, path);
    let model = at(&["machine", "dram", "model"]).and_then(Value::as_str);
    let by_device = at(&["energy", "dram", "device"]).and_then(Value::as_bool);
    let device = at(&["dram", "energy"]).filter(|_| by_device == Some(true));
    let prices = match device {
        Some(device) if model == Some(DramModel::Bandwidth.name()) => {
            [Some(device), at(&["energy", "dram", "row-hits"])]
        }
        Some(device) => [Some(device), None],
        None => [at(&["energy", "dram", "flat"]), None],
    };
    let mut found = BTreeSet::new();
    prices.into_iter().flatten().for_each(|prices| add(prices, &mut found));
    found.into_iter().collect()
}

/// Whether the areas of a recorded machine are those of a chip that does other things too.
fn is_whole_chip(record: &toml::Table) -> bool {
    let scope = configured(record, &["energy", "scope", "area"]).and_then(Value::as_str);
    scope.is_some_and(|scope| scope != AreaScope::Block.name())
}

/// What the powers of a recorded machine are of.
fn power_scope(record: &toml::Table) -> String {
    let scope = configured(record, &["energy", "scope", "power"]).and_then(Value::as_str);
    scope.unwrap_or(PowerScope::BlockAndMemory.name()).replace('-', " ")
}

/// What other masters of a recorded machine ask for.
fn masters_of(record: &toml::Table) -> MastersAsked {
    MastersAsked(MASTERS.map(|name| {
        let table = format!("{name}-master");
        let rate = configured(record, &["machine", "dram", &table, "rate"]);
        let rate = rate.and_then(Value::as_str);
        let rate: Option<BytesPerSecond> = rate.and_then(|rate| rate.parse().ok());
        rate.map_or(0.0, |rate| rate.0 * 1e-9)
    }))
}

/// The clock of a recorded machine and that of its prices, where these differ and there is no curve
/// between them.
fn off_clock(record: &toml::Table) -> Option<OffClock> {
    let supply = configured(record, &["energy", "supply"])?;
    let hertz = |value: Option<&Value>| value?.as_str()?.parse::<Hertz>().ok();
    let clock = hertz(configured(record, &["machine", "clock"]))?;
    let prices = hertz(supply.get("clock")).filter(|_| supply.get("curve").is_none())?;
    (clock != prices).then_some(OffClock { clock, prices })
}

/// A key of the configuration in a record.
pub(super) fn configured<'a>(record: &'a toml::Table, path: &[&str]) -> Option<&'a Value> {
    path.iter().try_fold(record.get("configuration")?, |value, key| value.get(key))
}
