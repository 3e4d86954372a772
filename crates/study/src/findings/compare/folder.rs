//! A finished report folder as a side of a comparison: its `run.toml` and `results.csv`, read by
//! the names that files have.

use std::collections::BTreeMap;

use powergs_core::accel::Stall;
use powergs_core::sim::statistics::catalogue;
use powergs_energy::action::{Buffer, Stage, UnitKind};
use powergs_energy::{Component, Standby};
use powergs_frame::fovea::REGIONS;
use toml::Value;

use super::Side;
use super::side::dram_prices;
use crate::findings::summary::{
    BufferSummary, ColourSummary, CommandMeans, CycleSummary, DramSummary, EnergyMeans, ReadWrite,
    RegionMeans, RunSummary, UnitSummary,
};
use crate::run_record::Shown;

/// Columns of `results.csv` before the statistics.
pub const RESULTS_FIRST: [&str; 4] = ["row", "frame", "name", "incomplete"];

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
    #[error("results.csv: row `{row}`, column `{column}`: `{cell}` is not a number")]
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
    /// A finished report folder called `label`.
    ///
    /// # Errors
    /// Which of the two files is broken, and where.
    pub fn of_folder(label: &str, run_toml: &str, results_csv: &[u8]) -> Result<Side, SideError> {
        side(label, run_toml.parse()?, results_csv)
    }
}

fn side(label: &str, record: toml::Table, results_csv: &[u8]) -> Result<Side, SideError> {
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
    let frames = integer("frames-reported")?.unsigned_abs();
    let size = |name: &str| fact(name).and_then(Value::as_integer).unwrap_or_default() as u32;
    // Reports of before know no pairs.
    let eyes = fact("eyes").and_then(Value::as_integer).unwrap_or(1).max(1) as usize;
    let shown = Shown { eyes, width: size("width-px"), height: size("height-px") };
    let display_fps = display_fps.ok_or(key("display-fps", "number"))?;
    let incomplete = incomplete.ok_or(key("incomplete", "true or false"))?;
    let mean = ResultsRow::read(results_csv, "mean")?;
    Ok(Side {
        label: label.to_owned(),
        machine: text("machine"),
        energy_table: text("energy-table"),
        node_nm: fact("node-nm").and_then(Value::as_float),
        model: string("model")?.to_owned(),
        dram_model: dram
            .and_then(|d| d.get("model"))
            .and_then(Value::as_str)
            .unwrap_or_default()
            .to_owned(),
        dram_prices: dram_prices(&record),
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
        summary: summary(&mean, results_csv, frames, display_fps)?,
        means: catalogue().iter().map(|s| mean.known(&s.name)).collect(),
        record,
    })
}

/// One aggregate of `results.csv`: cells by the name of their statistic.
struct ResultsRow(BTreeMap<String, f64>);

impl ResultsRow {
    fn read(results_csv: &[u8], kind: &'static str) -> Result<ResultsRow, SideError> {
        Ok(ResultsRow(cells(results_csv, kind)?))
    }

    /// A cell that may be empty.
    fn known(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    /// A cell that no run of this version leaves empty: not a number in an older report.
    fn value(&self, name: &str) -> f64 {
        self.known(name).unwrap_or(f64::NAN)
    }
}

/// The summary of a run of `frames` frames. An older report without a column leaves a gap: what
/// this version would have written is then not a number.
fn summary(
    mean: &ResultsRow,
    results_csv: &[u8],
    frames: u64,
    display_fps: f64,
) -> Result<RunSummary, SideError> {
    let bytes = |path: String| ReadWrite {
        read: mean.value(&format!("{path}dram_read_bytes")),
        write: mean.value(&format!("{path}dram_write_bytes")),
    };
    Ok(RunSummary {
        energy: energy(mean),
        displayed_fps: mean.known("displayed_fps").unwrap_or(display_fps),
        power_w: mean.value("power_w.total"),
        standby_w: Standby::COMPONENTS.map(|c| mean.value(&format!("power_w.{}", c.name()))),
        dram_bytes: Stage::WORK.map(|stage| bytes(format!("stages.{}.", stage.name()))),
        all_dram_bytes: bytes(String::new()),
        display_w: mean.known("display_power_w"),
        rendering_plus_display_w: mean.known("rendering_plus_display_w"),
        // The first name of the area of a chip.
        area_mm2: mean.known("area_mm2.total").or_else(|| mean.known("area_mm2")),
        core_mm2: mean.known("area_mm2.core"),
        cycle: match mean.known("frame_time_ms") {
            Some(_) => Some(cycle(mean, results_csv, frames)?),
            None => None,
        },
    })
}

fn energy(mean: &ResultsRow) -> EnergyMeans {
    let of = |stage: Stage, component: Component| {
        mean.value(&format!("energy_by_stage_pj.{}.{}", stage.name(), component.name()))
    };
    EnergyMeans {
        total_pj: mean.value("energy_pj.total"),
        component_pj: Component::ALL.map(|c| mean.value(&format!("energy_pj.{}", c.name()))),
        stage_pj: Stage::ALL.map(|s| mean.value(&format!("energy_pj.{}", s.name()))),
        work_pj: Stage::WORK.map(|s| EnergyMeans::WORK.map(|c| of(s, c))),
    }
}

fn cycle(mean: &ResultsRow, results_csv: &[u8], frames: u64) -> Result<CycleSummary, SideError> {
    let (p99, max) = (ResultsRow::read(results_csv, "p99")?, ResultsRow::read(results_csv, "max")?);
    Ok(CycleSummary {
        frame_time_ms: mean.value("frame_time_ms"),
        frame_time_p99_ms: p99.value("frame_time_ms"),
        frame_time_max_ms: max.value("frame_time_ms"),
        deadline_misses: (mean.value("deadline_missed") * frames as f64).round() as u64,
        frame_cycles: mean.value("frame_cycles"),
        preprocessing_cycles: mean.value("preprocessing_cycles"),
        units: UnitKind::ALL.map(|kind| unit(mean, kind)),
        colour: colour(mean),
        lane_utilisation: mean.known("units.vru.lane_utilisation"),
        dram: DramSummary {
            busy_frac: mean.value("dram.busy_frac"),
            bandwidth_gb_s: mean.known("dram.bandwidth_gb_s"),
            second_master_gb_s: mean.known("dram.second_master_gb_s"),
            unwritten_bytes: mean.known("dram.unwritten_bytes"),
            row_hit_frac: mean.known("dram.row_hit_frac"),
            moved_per_requested: mean.known("dram.moved_per_requested"),
            commands: commands(mean),
        },
        buffers: Buffer::FILLED.into_iter().filter_map(|b| buffer(mean, b)).collect(),
        regions: regions(mean),
    })
}

fn unit(mean: &ResultsRow, unit: UnitKind) -> UnitSummary {
    let path = |end: &str| format!("units.{}.{end}", unit.name());
    UnitSummary {
        unit,
        instances: mean.value(&path("instances")) as u32,
        busy: mean.value(&path("busy_cycles")),
        stalls: Stall::ALL.map(|s| mean.value(&path(&format!("stall_{}_cycles", s.name())))),
        idle: mean.value(&path("idle_cycles")),
    }
}

/// `None` where CCUs evaluate colours.
fn colour(mean: &ResultsRow) -> Option<ColourSummary> {
    let all = mean.known("frame_cycles")? * mean.known("colour.units")?;
    let busy = mean.known("colour.busy_cycles")?;
    Some(ColourSummary { busy_frac: busy / all.max(1.0), waits: mean.known("colour.wait_cycles")? })
}

/// `None` where the model of the DRAM counts no commands.
fn commands(mean: &ResultsRow) -> Option<[CommandMeans; Stage::WORK.len()]> {
    let of = |stage: Stage| {
        let known = |end: &str| mean.known(&format!("dram.stages.{}.{end}", stage.name()));
        let (reads, writes) = (known("reads")?, known("writes")?);
        Some(CommandMeans { reads, writes, activates: known("activates")? })
    };
    let [preprocessing, sorting, rendering] = Stage::WORK.map(of);
    Some([preprocessing?, sorting?, rendering?])
}

/// `None` where the machine has no such buffer.
fn buffer(mean: &ResultsRow, buffer: Buffer) -> Option<BufferSummary> {
    let known = |end: &str| mean.known(&format!("buffers.{}.{end}", buffer.name()));
    Some(BufferSummary {
        buffer,
        capacity: known("capacity_bytes")? as u64,
        peak: known("peak_bytes")?,
        mean: known("mean_bytes"),
        filled: known("filled_bytes")?,
        consumed: known("consumed_bytes")?,
        discarded: known("discarded_bytes")?,
    })
}

/// `None` where frames are not foveated.
fn regions(mean: &ResultsRow) -> Option<[RegionMeans; REGIONS.len()]> {
    let of = |region: &str| {
        let known = |end: &str| mean.known(&format!("regions.{}.{end}", region.to_lowercase()));
        Some(RegionMeans {
            tiles: known("tiles")?,
            entries: known("entries")?,
            cycles: known("cycles")?,
            energy_pj: known("energy_pj")?,
        })
    };
    let [r1, r2, r3, r4] = REGIONS.map(of);
    Some([r1?, r2?, r3?, r4?])
}

/// The cells of an aggregate that are not empty, by the name of their statistic.
fn cells(results_csv: &[u8], kind: &'static str) -> Result<BTreeMap<String, f64>, SideError> {
    let mut reader = ::csv::Reader::from_reader(results_csv);
    let names = reader.headers()?.clone();
    for record in reader.records() {
        let record = record?;
        if record.get(0) != Some(kind) {
            continue;
        }
        let cells = names.iter().zip(&record).skip(RESULTS_FIRST.len());
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
