//! A run of one machine over one trace: what went in, and the frames that came out.

mod file;

pub use file::record;

use crate::findings::masters::MastersAsked;
use powergs_base::format::{counted, rate};
use powergs_core::flow::Task;
use powergs_core::machine::DramModel;
use powergs_core::run::{Frames, Input, PaperModel, RunError, System};
use powergs_core::sim::statistics::Record;
use powergs_core::sim::{FrameReport, Model};
use powergs_energy::DramCosts;
use powergs_frame::scene::ShDegree;

use crate::findings::limits::{self, Effect};
use crate::findings::prices::PriceBars;
use crate::findings::roofline::Roofline;
use crate::findings::tile_load::TileLoad;
use crate::findings::what_if::WhatIf;

pub use powergs_base::SCHEMA_VERSION;

/// What went into a run besides the frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Which model counted.
    pub model: Model,
    /// The display rate, frames per second, for power and deadlines; positive and finite.
    pub display_fps: f64,
    /// The longest that a frame may take from its first read to its last write, milliseconds, where
    /// it was said.
    pub latency_ms: Option<f64>,
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
    /// What each of them shows.
    pub shown: Shown,
}

/// What a frame of the display shows: one view, or a pair for both eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shown {
    /// Views of a frame: 2 where they are in pairs, else 1.
    pub eyes: usize,
    /// Width of the first view, pixels.
    pub width: u32,
    /// Height of the first view, pixels.
    pub height: u32,
}

impl Shown {
    /// `3 frames`; of both eyes `3 pairs`.
    pub fn counted(&self, frames: impl Into<u64>) -> String {
        counted(frames.into(), if self.eyes > 1 { "pair" } else { "frame" })
    }

    /// `979x546`; of both eyes `2 x 979x546`.
    pub fn size(&self) -> String {
        let eyes = if self.eyes > 1 { format!("{} x ", self.eyes) } else { String::new() };
        format!("{eyes}{}x{}", self.width, self.height)
    }

    /// `3 pairs of 2 x 2064x2208 at 72 Hz`: frames, what each shows, the rate of the display.
    pub fn at_rate(&self, frames: impl Into<u64>, fps: f64) -> String {
        format!("{} of {} at {} Hz", self.counted(frames), self.size(), rate(fps))
    }
}

/// The machine of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineFacts {
    /// Name of the machine.
    pub name: String,
    /// What a frame of it is.
    pub task: Task,
    /// Name of the energy table.
    pub energy_table: String,
    /// Technology node of the energy table, nanometres, where it says one.
    pub node_nm: Option<f64>,
    /// Clock, hertz; `None` in the `paper` model.
    pub clock_hz: Option<f64>,
    /// Peak DRAM rate, 10⁹ bytes per second; `None` in the `paper` model.
    pub dram_peak_gb_s: Option<f64>,
    /// The model of the DRAM; `None` in the `paper` model.
    pub dram_model: Option<DramModel>,
    /// Who states the price of a DRAM byte, where it does not follow from those of commands: a key
    /// of `references.toml` or the number of an assumption.
    pub dram_byte_price: Option<String>,
    /// What other masters of the DRAM ask for.
    pub masters: MastersAsked,
    /// The effects that its runs leave out; all of them in the `paper` model.
    pub left_out: Vec<Effect>,
    /// Peaks and operation counts for the roofline; `None` in the `paper` model.
    pub roofline: Option<Roofline>,
    /// Keys of `references.toml` that its files cite.
    pub sources: Vec<String>,
    /// What is right in its files and doubtful, in sentences without their ends.
    pub doubts: Vec<String>,
}

impl TraceFacts {
    /// What a report says about a list of frames.
    ///
    /// # Errors
    /// [`RunError::Input`]: its first frame cannot be read.
    pub fn of(frames: &mut dyn Frames) -> Result<TraceFacts, RunError> {
        let (width, height) = frames.size()?;
        let (name, eyes) = (frames.name().to_owned(), frames.eyes());
        let shown = Shown { eyes, width, height };
        Ok(TraceFacts { name, frames: frames.range().len() / eyes, shown })
    }
}

impl MachineFacts {
    /// What a report says about a machine.
    pub fn of(system: &System) -> MachineFacts {
        MachineFacts {
            name: system.label(),
            task: system.machine().flow().task(system.machine()),
            energy_table: system.energy_table().name.clone(),
            node_nm: system.energy_table().node.map(|node| node.0),
            clock_hz: Some(system.machine().clock.0),
            dram_peak_gb_s: Some(system.dram_peak() * 1e-9),
            dram_model: Some(system.machine().dram.model),
            dram_byte_price: dram_byte_price(system),
            masters: {
                let all = system.machine().dram.masters();
                MastersAsked(all.map(|master| master.rate.0 * 1e-9))
            },
            left_out: limits::left_out_by(system.machine()),
            roofline: Some(Roofline::of(system)),
            sources: system.sources().into_iter().collect(),
            doubts: system.doubts(),
        }
    }

    /// The same about the published model.
    pub fn paper(model: &PaperModel) -> MachineFacts {
        MachineFacts {
            name: "paper".into(),
            task: Task::RENDER,
            energy_table: model.table().origin.clone(),
            node_nm: None,
            clock_hz: None,
            dram_peak_gb_s: None,
            dram_model: None,
            dram_byte_price: Some("powergs".into()),
            masters: MastersAsked::default(),
            left_out: limits::not_modelled(),
            roofline: None,
            sources: vec!["powergs".into()],
            doubts: Vec::new(),
        }
    }
}

/// Who states the price of a DRAM byte; `None` where it follows from the prices of commands.
fn dram_byte_price(system: &System) -> Option<String> {
    let DramCosts::Bytes { .. } = system.prices().dram else { return None };
    let prices = &system.energy_table().dram;
    let of_device = system.device().filter(|_| prices.device);
    match of_device.and_then(|device| device.energy.flat.as_ref()) {
        Some(flat) => Some(flat.source.clone()),
        None => prices.flat.as_ref().map(|flat| flat.read.source.clone()),
    }
}

/// XXH3 of a file as files and reports write it: 32 hexadecimal digits.
pub fn hash_text(input: &Input) -> String {
    format!("{:032x}", input.xxh3)
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
    pub experiments: Experiments,
}

/// What a run may carry beside its frames.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Experiments {
    /// What doubling single resources would buy.
    pub what_if: Option<WhatIf>,
    /// The same frames under two models of the DRAM.
    pub dram_models: Option<DramModels>,
    /// What the price assumptions do to the power; not simulated, priced again.
    pub prices: Option<PriceBars>,
}

/// The same frames with the `calibrated` DRAM and with its banks.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DramModels {
    /// Frame time of the `calibrated` model, milliseconds, mean over the frames.
    pub calibrated_ms: f64,
    /// Frame time of the `banked` model, milliseconds, mean over the frames.
    pub banked_ms: f64,
    /// Bytes that the `calibrated` model moved, mean over the frames.
    pub calibrated_bytes: f64,
    /// Bytes that the `banked` model moved, mean over the frames.
    pub banked_bytes: f64,
}

impl DramModels {
    /// `calibrated` against `banked`: relative differences of time and of bytes moved.
    pub fn differences(&self) -> [f64; 2] {
        let of = |other: f64, banked: f64| if banked == 0.0 { 0.0 } else { other / banked - 1.0 };
        [of(self.calibrated_ms, self.banked_ms), of(self.calibrated_bytes, self.banked_bytes)]
    }
}

impl Run {
    /// Every statistic over the frames; `None` without frames.
    pub fn statistics(&self) -> Option<Record> {
        Record::of(&self.frames, self.facts.display_fps)
    }

    /// The SH degree of the scene as the frames have it, and whether it was assumed because the
    /// trace does not say; `None` without frames. Of frames that differ, the highest.
    pub fn sh_degree(&self) -> Option<(ShDegree, bool)> {
        let degree = self.frames.iter().map(FrameReport::colour_degree).max()?;
        Some((degree, self.frames.iter().any(|frame| frame.sh_degree.is_none())))
    }

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
