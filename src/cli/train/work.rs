//! The loop: iterations, reports, traces, checkpoints.

use std::path::Path;
use std::time::{Duration, Instant};

use super::inputs::TrainViews;
use super::traces::StepTraces;
use super::{Context, Exit, Failure, Progress, out};
use powergs_core::run::store::FileStore;
use powergs_optimize::checkpoint::Checkpoints;
use powergs_optimize::references::References;
use powergs_optimize::train::{TrainState, TrainStep, Trainer};

/// Time between two checkpoints.
const PULSE: Duration = Duration::from_secs(60);

/// The file that keeps where a training is, if there is one.
pub struct CheckpointFile {
    /// Its folder, its name in it, and its path for people.
    file: Option<(FileStore, String, String)>,
    fingerprint: u128,
}

impl CheckpointFile {
    /// That of the training with this fingerprint.
    pub fn new(path: Option<&Path>, fingerprint: u128) -> CheckpointFile {
        let file = path.map(|path| {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            (FileStore::new(folder.unwrap_or(Path::new("."))), name, path.display().to_string())
        });
        CheckpointFile { file, fingerprint }
    }

    /// Where the training is.
    ///
    /// # Errors
    /// Exit code 2: there is no file; 3: it is damaged or of another training.
    pub fn load(&self) -> Result<TrainState, Failure> {
        let Some((store, name, place)) = &self.file else {
            return Err(Failure::new(Exit::Usage, "--resume: give --checkpoint FILE"));
        };
        let state = Checkpoints::new(store, self.fingerprint).load_training(name)?;
        state.ok_or_else(|| {
            let what = format!("{place}: no checkpoint is there; leave out --resume to begin");
            Failure::new(Exit::Usage, what)
        })
    }

    fn save(&self, state: &TrainState) -> Result<(), Failure> {
        match &self.file {
            Some((store, name, _)) => {
                Ok(Checkpoints::new(store, self.fingerprint).save_training(name, state)?)
            }
            None => Ok(()),
        }
    }

    /// What to do after an interruption.
    fn advice(&self) -> String {
        match &self.file {
            Some((.., place)) => format!("{place}: the same command with --resume goes on"),
            None => "nothing was kept; --checkpoint FILE does".to_owned(),
        }
    }
}

/// A training at work.
pub struct Worked<'a> {
    /// It.
    pub trainer: Trainer<'a>,
    /// Where it is kept.
    pub checkpoint: CheckpointFile,
    /// Its views.
    pub views: &'a TrainViews,
    /// Its traces.
    pub traces: &'a StepTraces,
    /// Iterations between reports.
    pub every: u32,
}

impl<'a> Worked<'a> {
    /// Works to the end; `None` after Ctrl-C.
    ///
    /// # Errors
    /// Exit code 2: something cannot be written; 3: the training went wrong.
    pub fn work(mut self, context: &Context) -> Result<Option<Trainer<'a>>, Failure> {
        let total = self.trainer.rules().iterations;
        let progress = Progress::new(context, total.into(), "iterations");
        progress.advance(self.trainer.state().iteration.into());
        let mut saved = Instant::now();
        let mut mean = RunningMean::default();
        while !self.trainer.is_done() {
            if context.is_cancelled() {
                self.checkpoint.save(self.trainer.state())?;
                drop(progress);
                if !context.global.quiet {
                    out::complain(format!("interrupted, {}", self.checkpoint.advice()));
                }
                return Ok(None);
            }
            let was_capped = self.trainer.state().is_capped;
            let step = self.trainer.step();
            // A photo that could not be read back was black.
            self.views.images.check()?;
            let step = step.map_err(|e| Failure::new(Exit::BadInput, e))?;
            mean.add(step.psnr_db);
            self.say_cap(was_capped, &step, context);
            self.traces.write(
                step.iteration,
                self.trainer.scene(),
                self.views,
                self.trainer.background(),
                context,
            )?;
            if step.iteration.is_multiple_of(self.every) || self.trainer.is_done() {
                self.report(&step, &mut mean, &progress, context);
            }
            if saved.elapsed() > PULSE || self.trainer.is_done() {
                self.checkpoint.save(self.trainer.state())?;
                saved = Instant::now();
            }
            progress.advance(1);
        }
        drop(progress);
        Ok(Some(self.trainer))
    }

    fn say_cap(&self, was_capped: bool, step: &TrainStep, context: &Context) {
        if self.trainer.state().is_capped && !was_capped && !context.global.quiet {
            out::complain(format_args!(
                "note: iteration {}: {} Gaussians; cloning and splitting would make more than \
                 --max-points {}, so none is added",
                step.iteration,
                self.trainer.scene().len(),
                self.trainer.rules().max_points
            ));
        }
    }

    fn report(
        &self,
        step: &TrainStep,
        mean: &mut RunningMean,
        progress: &Progress,
        context: &Context,
    ) {
        if context.global.quiet {
            return;
        }
        let seen = self.trainer.held_out();
        let held_out = seen.map_or(String::new(), |seen| {
            format!(", held out {:.2} dB, SSIM {:.4}", seen.psnr_db, seen.ssim)
        });
        let reset = if step.is_reset { " (opacities were just reset)" } else { "" };
        let (points, train) = (self.trainer.scene().len(), mean.take());
        progress.say(format!("; {points} Gaussians, training views {train:.2} dB{held_out}"));
        out::complain(format_args!(
            "iteration {:>6}: {points:>8} Gaussians, training views {train:.2} dB{held_out}{reset}",
            step.iteration
        ));
    }
}

/// The mean since the last report.
#[derive(Default)]
struct RunningMean {
    sum: f64,
    count: u32,
}

impl RunningMean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn take(&mut self) -> f64 {
        let mean = self.sum / f64::from(self.count.max(1));
        *self = RunningMean::default();
        mean
    }
}
