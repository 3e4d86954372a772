//! Reports: what a run looks like, for people and for machines. Nothing is simulated here, nothing
//! is opened: every format is a function from a [`Run`] to bytes, and the same run gives the same
//! bytes.

pub mod bottleneck;
pub mod breakdown;
pub mod charts;
pub mod claims;
pub mod compare;

pub mod csv;
pub mod docs;
pub mod fit;
pub mod format;
pub mod json;
pub mod limits;
pub mod means;
pub mod optimize;
pub mod perfetto;
pub mod record;
pub mod results;
pub mod roofline;
pub mod schema;
pub mod sensitivity;
pub mod summary;
pub mod sweep;
pub mod table;
pub mod terminal;
pub mod tile_load;
pub mod timeline;
pub mod what_if;

pub use bottleneck::{Bottleneck, Limit};
pub use means::Means;
pub use table::Table;
pub use tile_load::{Picture, TileLoad};
pub use what_if::WhatIf;

use powergs_core::run::Input;
use powergs_core::sim::{FrameReport, Model};

pub use powergs_base::SCHEMA_VERSION;

/// What went into a run besides the frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Which model counted.
    pub model: Model,
    /// The display rate, frames per second, for power and deadlines; positive and finite.
    pub display_fps: f64,
    /// The trace.
    pub trace: TraceFacts,
    /// The machine.
    pub machine: MachineFacts,
    /// Files that were read, in a fixed order.
    pub inputs: Vec<Input>,
    /// The configuration as resolved (`machine`, `energy`, …): goes into `run.toml` as it is.
    pub configuration: toml::Table,
}

/// The trace of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceFacts {
    /// Name for people: the file name without its ending.
    pub name: String,
    /// Frames that were asked for. Fewer reported frames make the run incomplete.
    pub frames: usize,
    /// Width of the first frame, pixels.
    pub width: u32,
    /// Height of the first frame, pixels.
    pub height: u32,
}

/// The machine of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineFacts {
    /// Name of the machine.
    pub name: String,
    /// Name of the energy table.
    pub energy_table: String,
    /// Clock, hertz; `None` in the `paper` model.
    pub clock_hz: Option<f64>,
    /// Peak DRAM rate, 10⁹ bytes per second; `None` in the `paper` model.
    pub dram_peak_gb_s: Option<f64>,
    /// Peaks and operation counts for the roofline; `None` in the `paper` model.
    pub roofline: Option<roofline::Roofline>,
}

/// A finished (or interrupted) run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What went in.
    pub facts: Facts,
    /// Reported frames, in order: all that were asked for, or those done before an interruption.
    pub frames: Vec<FrameReport>,
    /// Tile lists of the slowest frame (in the `paper` model: the one with most loads).
    pub tiles: Option<TileLoad>,
    /// What was simulated beside the frames.
    pub extras: Extras,
}

/// What a run may carry beside its frames.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extras {
    /// What doubling single resources would buy.
    pub what_if: Option<WhatIf>,
    /// The same frames under two models of the DRAM.
    pub dram_models: Option<DramModels>,
}

/// The same frames with the DRAM in windows and with its banks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DramModels {
    /// Frame time of the `window` model, milliseconds, mean over the frames.
    pub window_ms: f64,
    /// Frame time of the `banked` model, milliseconds, mean over the frames.
    pub banked_ms: f64,
    /// Bytes that the `window` model moved, mean over the frames.
    pub window_bytes: f64,
    /// Bytes that the `banked` model moved, mean over the frames.
    pub banked_bytes: f64,
}

impl DramModels {
    /// `window` against `banked`: relative differences of time and of bytes moved.
    pub fn differences(&self) -> [f64; 2] {
        let of = |window: f64, banked: f64| if banked == 0.0 { 0.0 } else { window / banked - 1.0 };
        [of(self.window_ms, self.banked_ms), of(self.window_bytes, self.banked_bytes)]
    }

    /// The comparison in one line of at most 80 columns.
    pub fn line(&self) -> String {
        let [time, bytes] = self.differences().map(|d| format!("{:+.2} %", d * 100.0));
        format!("dram window against banked: time {time}, bytes moved {bytes}\n")
    }
}

impl Run {
    /// Whether frames are missing. Every output says so.
    pub fn incomplete(&self) -> bool {
        self.frames.len() < self.facts.trace.frames
    }

    /// `INCOMPLETE: 3 of 24 frames`, if so.
    pub fn incomplete_note(&self) -> Option<String> {
        let (done, all) = (self.frames.len(), self.facts.trace.frames);
        self.incomplete().then(|| format!("INCOMPLETE: {done} of {all} frames"))
    }

    /// `garden on gscore`, for titles.
    pub fn title(&self) -> String {
        format!("{} on {}", self.facts.trace.name, self.facts.machine.name)
    }
}

/// A report could not be made; all of these are mistakes of ours.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A chart could not be drawn.
    #[error(transparent)]
    Chart(#[from] powergs_chart::DrawError),
    /// A table could not be written.
    #[error("results.csv: {0}; please report this")]
    Csv(#[from] ::csv::Error),
    /// The configuration could not be written.
    #[error("run.toml: {0}; please report this")]
    Toml(#[from] toml::ser::Error),
}

/// A file of a report folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Name in the folder.
    pub name: String,
    /// Contents.
    pub bytes: Vec<u8>,
}

/// Names of all files that a report folder may hold.
pub const FILE_NAMES: [&str; 48] = [
    "run.toml",
    "invocation.toml",
    "results.csv",
    "compare.csv",
    "sensitivity.csv",
    "summary.md",
    "energy.png",
    "energy.svg",
    "cycles.png",
    "cycles.svg",
    "roofline.png",
    "roofline.svg",
    "buffers.png",
    "buffers.svg",
    "frame_time.png",
    "frame_time.svg",
    "tiles.png",
    "tiles.svg",
    "tile_load.png",
    "tile_load.svg",
    "timeline.png",
    "timeline.svg",
    "tornado.png",
    "tornado.svg",
    "tornado_2.png",
    "tornado_2.svg",
    "tornado_3.png",
    "tornado_3.svg",
    "tornado_4.png",
    "tornado_4.svg",
    "elasticity.csv",
    "interactions.csv",
    "designs.csv",
    "tornado_fps.png",
    "tornado_fps.svg",
    "tornado_energy.png",
    "tornado_energy.svg",
    "tornado_area.png",
    "tornado_area.svg",
    "morris_fps.png",
    "morris_fps.svg",
    "morris_energy.png",
    "morris_energy.svg",
    "morris_area.png",
    "morris_area.svg",
    "sobol.png",
    "sobol.svg",
    "trace.json.gz",
];

/// Those of them that `replay` writes only when they are asked for, or that `compare` and
/// `sensitivity` write.
pub const ASKED_FOR: [&str; 30] = [
    "compare.csv",
    "timeline.png",
    "timeline.svg",
    "trace.json.gz",
    "sensitivity.csv",
    "tornado.png",
    "tornado.svg",
    "tornado_2.png",
    "tornado_2.svg",
    "tornado_3.png",
    "tornado_3.svg",
    "tornado_4.png",
    "tornado_4.svg",
    "elasticity.csv",
    "interactions.csv",
    "designs.csv",
    "tornado_fps.png",
    "tornado_fps.svg",
    "tornado_energy.png",
    "tornado_energy.svg",
    "tornado_area.png",
    "tornado_area.svg",
    "morris_fps.png",
    "morris_fps.svg",
    "morris_energy.png",
    "morris_energy.svg",
    "morris_area.png",
    "morris_area.svg",
    "sobol.png",
    "sobol.svg",
];

/// The files of the report folder, all but `invocation.toml`.
pub fn files(run: &Run) -> Result<Vec<File>, ReportError> {
    let table = Table::of(run);
    let charts = charts::all(run, &table);
    let summary = summary::markdown(run, &table, &charts);
    let mut files = vec![
        File { name: "run.toml".into(), bytes: record::run_toml(run)?.into_bytes() },
        File { name: "results.csv".into(), bytes: csv::results(run, &table)? },
        File { name: "summary.md".into(), bytes: summary.into_bytes() },
    ];
    for chart in charts {
        files.push(File { name: format!("{}.png", chart.name), bytes: chart.png()? });
        files.push(File { name: format!("{}.svg", chart.name), bytes: chart.svg()?.into_bytes() });
    }
    Ok(files)
}
