//! What the user sees of a sweep on its way: designs per second, the time left, the best so far.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::opened::Objective;
use crate::cli::Context;
use powergs_report::format::significant;
use powergs_study::sweep::journal::Record;
use powergs_study::sweep::metric;

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar on standard error, for people at a terminal only.
pub struct Meter {
    bar: ProgressBar,
    started: Instant,
    wanted: bool,
    /// The first objective that is a metric, and its best value so far.
    best: Option<(Objective, Mutex<Option<f64>>)>,
}

impl Meter {
    /// A bar for the work of `frames` frames of machines, all machines together.
    pub fn new(context: &Context, frames: u64, objectives: &[Objective]) -> Meter {
        let bar = ProgressBar::with_draw_target(Some(frames), ProgressDrawTarget::hidden());
        let template = "{bar:16} {pos}/{len} machine-frames, {per_sec}, {eta} left{msg}";
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        let metric = |o: &&Objective| metric::metrics().iter().any(|m| m.name == o.column);
        let best = objectives.iter().find(metric).map(|o| (o.clone(), Mutex::new(None)));
        Meter { bar, started: Instant::now(), wanted: !context.global.quiet, best }
    }

    /// Work that is done already.
    pub fn known(&self, frames: u64) {
        self.bar.dec_length(frames);
    }

    /// Work that is done now.
    pub fn done(&self, frames: u64) {
        if self.wanted && self.bar.is_hidden() && self.started.elapsed() > PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.inc(frames);
    }

    /// A result.
    pub fn best(&self, record: &Record) {
        let (Some((objective, best)), Record::Ok(outcome)) = (&self.best, record) else { return };
        if self.bar.is_hidden() {
            return;
        }
        let values = metric::values(&[(1.0, outcome)]);
        let place = metric::metrics().iter().position(|m| m.name == objective.column);
        let Some(value) = place.and_then(|p| values[p]) else { return };
        let mut best = best.lock().expect("no panic while it is held");
        if best.is_none_or(|b| if objective.maximize { value > b } else { value < b }) {
            *best = Some(value);
            self.bar.set_message(format!(", best {} {}", objective.column, significant(value)));
        }
    }
}

impl Drop for Meter {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
