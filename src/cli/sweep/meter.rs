//! What the user sees of a sweep on its way: designs per second, the time left, the best so far.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::cli::progress::Progress;
use crate::cli::{Context, out};
use powergs_core::run::Watch;
use powergs_report::format::significant;
use powergs_study::sweep::metric;
use powergs_study::sweep::run::SweepWatch;
use powergs_study::sweep::{Goal, Objective, Record};

/// Ctrl-C and a bar on standard error, for people at a terminal only.
pub struct Meter<'a> {
    context: &'a Context,
    stage: Mutex<MeterStage>,
}

/// What a sweep is at.
enum MeterStage {
    Nothing,
    /// Designs are planned.
    Planning(Progress),
    /// Machines are timed.
    Working(MeterBar),
}

/// The bar of the work.
struct MeterBar {
    bar: Progress,
    /// The first objective that is a metric, and its best value so far.
    best: Option<(Objective, Option<f64>)>,
}

impl<'a> Meter<'a> {
    /// No bar yet.
    pub fn new(context: &'a Context) -> Meter<'a> {
        Meter { context, stage: Mutex::new(MeterStage::Nothing) }
    }

    fn stage(&self) -> MutexGuard<'_, MeterStage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        *self.stage() = MeterStage::Nothing;
    }
}

impl Watch for Meter<'_> {
    fn is_cancelled(&self) -> bool {
        self.context.is_cancelled()
    }

    fn simulated(&self, n: u64) {
        if let MeterStage::Working(MeterBar { bar, .. }) = &*self.stage() {
            bar.advance(n);
        }
    }
}

impl SweepWatch for Meter<'_> {
    fn planning(&self, points: u64) {
        let progress = Progress::new(self.context, points, "designs looked at");
        *self.stage() = MeterStage::Planning(progress);
    }

    fn planned(&self, n: u64) {
        if let MeterStage::Planning(progress) = &*self.stage() {
            progress.advance(n);
        }
    }

    fn working(&self, machine_frames: u64, objectives: &[Objective]) {
        *self.stage() =
            MeterStage::Working(MeterBar::new(self.context, machine_frames, objectives));
    }

    fn known(&self, machine_frames: u64) {
        if let MeterStage::Working(MeterBar { bar, .. }) = &*self.stage() {
            bar.skip(machine_frames);
        }
    }

    fn result(&self, record: &Record) {
        if let MeterStage::Working(bar) = &mut *self.stage() {
            bar.result(record);
        }
    }

    fn note(&self, text: &str) {
        if !self.context.global.quiet {
            out::complain(format_args!("note: {text}"));
        }
    }
}

impl MeterBar {
    fn new(context: &Context, machine_frames: u64, objectives: &[Objective]) -> MeterBar {
        let bar = Progress::new(context, machine_frames, "machine-frames");
        let metric = |o: &&Objective| metric::metrics().iter().any(|m| m.name == o.name);
        let best = objectives.iter().find(metric).map(|o| (o.clone(), None));
        MeterBar { bar, best }
    }

    fn result(&mut self, record: &Record) {
        let (Some((objective, best)), Record::Ok(outcome)) = (&mut self.best, record) else {
            return;
        };
        if !self.bar.is_shown() {
            return;
        }
        let values = metric::values(&[(1.0, outcome)]);
        let place = metric::metrics().iter().position(|m| m.name == objective.name);
        let Some(value) = place.and_then(|p| values[p]) else { return };
        let better = |b: f64| match objective.goal {
            Goal::Maximize => value > b,
            Goal::Minimize => value < b,
        };
        if best.is_none_or(better) {
            *best = Some(value);
            self.bar.say(format!(", best {} {}", objective.name, significant(value)));
        }
    }
}
