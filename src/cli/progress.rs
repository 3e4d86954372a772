//! A progress bar on standard error: for people at a terminal, and only if the work takes longer
//! than a second.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::Context;
use powergs_core::run::Watch;

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar that appears after a second, goes away when dropped, and never writes to a file or pipe.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    started: Instant,
    /// Whether a bar may be shown at all.
    wanted: bool,
}

impl Progress {
    /// A bar for `total` items of `what` (plural: `frames`).
    pub fn new(context: &Context, total: u64, what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let template = format!("{{bar:24}} {{pos}}/{{len}} {what}, {{eta}} left{{msg}}");
        // The template is ours and fixed: if it did not parse, the default style is good enough.
        bar.set_style(
            ProgressStyle::with_template(&template)
                .unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        Self { bar, started: Instant::now(), wanted: !context.global.quiet }
    }

    /// Other work begins, `total` items of it.
    pub fn restart(&self, total: u64) {
        self.bar.reset();
        self.bar.set_length(total);
    }

    /// Says how things are, behind the time that is left.
    pub fn say(&self, how: String) {
        self.bar.set_message(how);
    }

    /// `n` more items are done. May be called from any thread.
    pub fn advance(&self, n: u64) {
        if self.wanted && self.bar.is_hidden() && self.started.elapsed() > PATIENCE {
            // Hides itself when standard error is not a terminal.
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        self.bar.inc(n);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// What a bar counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counts {
    /// Frames.
    Frames,
    /// Frames, once for every machine that they go through.
    Simulations,
}

/// Ctrl-C and a bar, for the engine.
pub struct Watched<'a> {
    context: &'a Context,
    progress: Progress,
    counts: Counts,
    /// Whether the bar begins again with every session.
    by_session: bool,
}

impl<'a> Watched<'a> {
    /// A bar for each session.
    pub fn new(context: &'a Context, counts: Counts) -> Watched<'a> {
        Watched { by_session: true, ..Watched::of_total(context, 0, counts) }
    }

    /// One bar for `total` of what is counted.
    pub fn of_total(context: &'a Context, total: u64, counts: Counts) -> Watched<'a> {
        let what = match counts {
            Counts::Frames => "frames",
            Counts::Simulations => "frames on machines",
        };
        let progress = Progress::new(context, total, what);
        Watched { context, progress, counts, by_session: false }
    }
}

impl Watch for Watched<'_> {
    fn is_cancelled(&self) -> bool {
        self.context.is_cancelled()
    }

    fn begins(&self, frames: u64, simulations: u64) {
        if self.by_session {
            self.progress.restart(match self.counts {
                Counts::Frames => frames,
                Counts::Simulations => simulations,
            });
        }
    }

    fn simulated(&self, n: u64) {
        if self.counts == Counts::Simulations {
            self.progress.advance(n);
        }
    }

    fn frame_done(&self) {
        if self.counts == Counts::Frames {
            self.progress.advance(1);
        }
    }
}
