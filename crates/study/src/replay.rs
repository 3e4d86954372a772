//! A replay: frames on one machine or on the published model, and beside them what doubling each
//! resource of the machine would buy and what another DRAM model makes of the same frames.

mod doubling;
mod prices;

use powergs_core::machine::DramModel;
use powergs_core::run::frames::spread;
use powergs_core::run::session::Target;
use powergs_core::run::{Change, FrameView, Frames, RunError, Session, Subject, System, Watch};
use powergs_core::sim::{FrameReport, Model};
use powergs_dram::DramCommands;

use crate::findings::{Picture, TileLoad, WhatIf};
use crate::run_record::{DramModels, Experiments, Facts, MachineFacts, Run, TraceFacts};
use doubling::Doubling;

/// What is simulated besides the frames themselves.
#[derive(Debug, Clone, Copy)]
pub struct Replay<'a> {
    /// The machine, or the published model.
    pub target: Target<'a>,
    /// Display rate, frames per second, for power and deadlines; positive and finite.
    pub display_fps: f64,
    /// The longest that a frame may take from its first read to its last write, milliseconds.
    pub latency_ms: Option<f64>,
    /// Frames, spread evenly over the list, on which doubling each resource is tried; not on the
    /// published model.
    pub what_if_frames: usize,
    /// Whether doubling is tried with the `calibrated` model where the machine has `banked`.
    pub calibrates_what_if: bool,
    /// Whether the `calibrated` model of the DRAM sees the same frames; the machine has `banked`.
    pub compares_models: bool,
}

/// What is kept of one machine's frames.
#[derive(Debug, Default)]
struct ReplayKept {
    reports: Vec<FrameReport>,
    /// The tile lists of the slowest frame so far, if they are wanted, and what makes it slow.
    slowest: Option<(u64, TileLoad)>,
    wants_tiles: bool,
}

impl ReplayKept {
    fn add(&mut self, view: FrameView<'_>) {
        let (position, preview, tiles) = (view.position, view.preview, view.tiles());
        let report = &view.report;
        if let Some(workload) = tiles.filter(|_| self.wants_tiles) {
            let weight = report.timing().map_or(report.counters.tile_loads, |t| t.frame);
            if self.slowest.as_ref().is_none_or(|(w, _)| weight > *w) {
                let picture = preview.map(|p| Picture {
                    width: p.width,
                    height: p.height,
                    rgb: p.rgb.clone(),
                });
                self.slowest = Some((weight, TileLoad::of(position, workload, picture)));
            }
        }
        self.reports.push(view.report);
    }
}

impl Replay<'_> {
    /// What a report says besides its frames.
    ///
    /// # Errors
    /// [`RunError::Input`]: frames that cannot be read.
    pub fn facts(&self, frames: &mut dyn Frames) -> Result<Facts, RunError> {
        let (model, machine, of_model, configuration) = match self.target {
            Target::System(system) => {
                let facts = MachineFacts::of(system);
                (Model::Cycle, facts, system.inputs(), system.configuration())
            }
            Target::Paper(model) => {
                let facts = MachineFacts::paper(model);
                (Model::Paper, facts, model.inputs(), model.configuration())
            }
        };
        let mut inputs = vec![frames.identity()?];
        inputs.extend(of_model);
        let trace = TraceFacts::of(frames)?;
        let (display_fps, latency_ms) = (self.display_fps, self.latency_ms);
        Ok(Facts { model, display_fps, latency_ms, trace, machine, inputs, configuration })
    }

    /// Simulates all frames, or as many as were done when it was cancelled.
    ///
    /// # Errors
    /// [`RunError::Config`]: the machine cannot have the `calibrated` model; otherwise as
    /// [`Session::fold`].
    pub fn run(&self, frames: &mut dyn Frames, watch: &dyn Watch) -> Result<Run, RunError> {
        let facts = self.facts(frames)?;
        let tried = spread(frames.range(), frames.eyes(), self.what_if_frames);
        let (mut subjects, mut doubling, mut compared) = (Vec::new(), None, None);
        let mut calibrated = None;
        match self.target {
            Target::System(system) => {
                subjects.push(Subject::of(system).checking_order());
                if self.calibrates_what_if && !tried.is_empty() {
                    calibrated = system.calibrated()?;
                }
                let base = calibrated.as_ref().unwrap_or(system);
                doubling = (!tried.is_empty()).then(|| Doubling::of(base));
                if self.compares_models {
                    let model = DramModel::Calibrated.name();
                    compared = Some(system.with(&[Change::machine("dram.model", model)])?);
                }
            }
            Target::Paper(model) => subjects.push(Subject::paper(model)),
        }
        let doubled = doubling.iter().flat_map(|doubling| &doubling.systems);
        subjects.extend(doubled.map(|system| Subject::of(system).only(&tried)));
        subjects.extend(calibrated.iter().map(|system| Subject::of(system).only(&tried)));
        subjects.extend(compared.iter().map(Subject::of));
        let start = |i| ReplayKept { wants_tiles: i == 0, ..ReplayKept::default() };
        let folded = Session::new(frames, watch).fold(&subjects, start, ReplayKept::add)?;
        drop(subjects);
        let mut kept = folded.states.into_iter();
        let main = kept.next().expect("the first subject");
        let mut others: Vec<Vec<FrameReport>> = kept.map(|kept| kept.reports).collect();
        let compared = compared.is_some().then(|| others.pop().expect("the last subject"));
        let dram_models = compared.and_then(|compared| dram_models(&main.reports, &compared));
        let base = calibrated.is_some().then(|| others.pop().expect("the one before it"));
        let is_calibrated = base.is_some();
        let base = base.as_ref().unwrap_or(&main.reports);
        let what_if = doubling
            .and_then(|doubling| doubling.finish(&tried, base, &others, self.display_fps))
            .map(|what_if| WhatIf { is_calibrated, ..what_if });
        let prices = match self.target {
            Target::System(system) => prices::bars(system, &main.reports, self.display_fps),
            Target::Paper(_) => None,
        };
        Ok(Run {
            facts,
            frames: main.reports,
            tiles: main.slowest.map(|(_, tiles)| tiles),
            experiments: Experiments { what_if, dram_models, prices },
        })
    }
}

/// The same frames on several machines, a run for each; of frames at `counted` alone where that is
/// given, of which those before are what machines remember.
///
/// # Errors
/// As [`Session::fold`].
pub fn on_each(
    systems: &[System],
    display_fps: f64,
    frames: &mut dyn Frames,
    counted: Option<&[usize]>,
    watch: &dyn Watch,
) -> Result<Vec<Run>, RunError> {
    let facts = |system| {
        let target = Target::System(system);
        Replay {
            target,
            display_fps,
            latency_ms: None,
            what_if_frames: 0,
            calibrates_what_if: false,
            compares_models: false,
        }
        .facts(frames)
    };
    let mut facts: Vec<Facts> = systems.iter().map(facts).collect::<Result<_, _>>()?;
    if let Some(counted) = counted {
        // Those before are not asked for.
        facts
            .iter_mut()
            .for_each(|facts| facts.trace.frames = counted.len() / facts.trace.shown.eyes);
    }
    let subject = |system| {
        let subject = Subject::of(system).checking_order();
        match counted {
            Some(counted) => subject.only(counted),
            None => subject,
        }
    };
    let subjects: Vec<Subject> = systems.iter().map(subject).collect();
    let keep = |reports: &mut Vec<FrameReport>, view: FrameView<'_>| reports.push(view.report);
    let folded = Session::new(frames, watch).fold(&subjects, |_| Vec::new(), keep)?;
    let run = |((system, facts), frames): ((&System, Facts), Vec<FrameReport>)| {
        let prices = prices::bars(system, &frames, display_fps);
        Run {
            facts,
            frames,
            tiles: None,
            experiments: Experiments { prices, ..Experiments::default() },
        }
    };
    Ok(systems.iter().zip(facts).zip(folded.states).map(run).collect())
}

/// The same frames with the `calibrated` DRAM and with its banks; `None` without a frame.
fn dram_models(banked: &[FrameReport], calibrated: &[FrameReport]) -> Option<DramModels> {
    let moved = |report: &FrameReport| {
        let Some(timing) = report.timing() else { return 0.0 };
        let bursts = |c: &DramCommands| {
            c.stages.iter().map(|s| s.reads + s.writes).sum::<u64>() * c.burst_bytes
        };
        timing.dram.commands.as_ref().map_or(0, bursts) as f64
    };
    let n = calibrated.len();
    let mean = |reports: &[FrameReport], of: &dyn Fn(&FrameReport) -> f64| {
        reports.iter().take(n).map(of).sum::<f64>() / n as f64
    };
    let time = |report: &FrameReport| report.frame_time_s().unwrap_or(0.0) * 1e3;
    (n > 0).then(|| DramModels {
        calibrated_ms: mean(calibrated, &time),
        banked_ms: mean(banked, &time),
        calibrated_bytes: mean(calibrated, &moved),
        banked_bytes: mean(banked, &moved),
    })
}
