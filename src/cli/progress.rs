//! A progress bar on standard error: for people at a terminal, and only if the work takes longer
//! than a second. Elsewhere, a line a minute.

use std::fmt;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use super::{Context, out};
use powergs_core::run::Watch;

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between two lines in a file or pipe.
const PULSE: Duration = Duration::from_secs(60);

/// When the first items were done, and how many they were. What came before them is no pace: models
/// are read, frames rendered, and what an earlier run has done is told at once.
#[derive(Debug, Default)]
struct ProgressPace(Mutex<Option<(Instant, u64)>>);

impl ProgressPace {
    fn first(&self) -> MutexGuard<'_, Option<(Instant, u64)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// `done` items are done.
    fn reach(&self, at: u64) {
        self.first().get_or_insert_with(|| (Instant::now(), at));
    }

    /// The time that is left of `len` items.
    fn left(&self, at: u64, of: u64) -> Option<Duration> {
        let (since, first) = (*self.first())?;
        left(since.elapsed(), at.saturating_sub(first), of.saturating_sub(at))
    }
}

/// The time that is left where `done` items took `elapsed` and `rest` are to come, by the mean of
/// all of them: that of the last few says nothing where items rest while others are measured.
/// `None`: nobody knows.
pub fn left(elapsed: Duration, done: u64, rest: u64) -> Option<Duration> {
    let seconds = elapsed.as_secs_f64() * rest as f64 / done as f64;
    Duration::try_from_secs_f64(seconds).ok().filter(|_| done > 0)
}

/// A bar that appears after a second and goes away when dropped.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    started: Instant,
    pace: Arc<ProgressPace>,
    /// Whether anything may be shown at all.
    wanted: bool,
    is_terminal: bool,
    /// What is counted.
    what: &'static str,
    /// Lines that were written.
    pulses: AtomicU64,
}

impl Progress {
    /// A bar for `total` items of `what` (plural: `frames`).
    pub fn new(context: &Context, total: u64, what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let template = format!("{{bar:24}} {{pos}}/{{len}} {what}{{left}}{{msg}}");
        let pace = Arc::new(ProgressPace::default());
        let shown = Arc::clone(&pace);
        let says_left = move |state: &ProgressState, to: &mut dyn fmt::Write| {
            if let Some(left) = shown.left(state.pos(), state.len().unwrap_or_default()) {
                // A bar that cannot be written is not there.
                let _ = write!(to, ", {:#} left", HumanDuration(left));
            }
        };
        // The template is ours and fixed: if it did not parse, the default style is good enough.
        bar.set_style(
            ProgressStyle::with_template(&template)
                .unwrap_or_else(|_| ProgressStyle::default_bar())
                .with_key("left", says_left),
        );
        Self {
            bar,
            started: Instant::now(),
            pace,
            wanted: !context.global.quiet,
            is_terminal: std::io::stderr().is_terminal(),
            what,
            pulses: AtomicU64::new(0),
        }
    }

    /// Other work begins, `total` items of it.
    pub fn restart(&self, total: u64) {
        self.bar.reset();
        self.bar.set_length(total);
        *self.pace.first() = None;
    }

    /// Says how things are, behind the time that is left.
    pub fn say(&self, how: String) {
        self.bar.set_message(how);
    }

    /// `n` more items are done. May be called from any thread.
    pub fn advance(&self, n: u64) {
        self.bar.inc(n);
        self.pace.reach(self.bar.position());
        if self.wanted && self.is_terminal {
            if self.bar.is_hidden() && self.started.elapsed() > PATIENCE {
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
        } else if self.wanted {
            self.pulse();
        }
    }

    /// `n` of the items need not be done.
    pub fn skip(&self, n: u64) {
        self.bar.dec_length(n);
    }

    /// Whether a bar is there.
    pub fn is_shown(&self) -> bool {
        !self.bar.is_hidden()
    }

    fn pulse(&self) {
        let due = self.started.elapsed().as_secs() / PULSE.as_secs();
        // Of several threads one writes the line of a minute.
        if self.pulses.fetch_max(due, Ordering::Relaxed) < due {
            let (at, of) = (self.bar.position(), self.bar.length().unwrap_or_default());
            let left = self.pace.left(at, of).map_or(String::new(), |left| {
                format!(", about {} min left", left.as_secs().div_ceil(60))
            });
            out::complain(format_args!("{at}/{of} {}{left}", self.what));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// What a bar counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProgressCounts {
    /// Frames.
    Frames,
    /// Frames, once for every machine that they go through.
    Simulations,
}

/// Ctrl-C and a bar, for the engine.
pub struct WatchedProgress<'a> {
    context: &'a Context,
    progress: Progress,
    counts: ProgressCounts,
    /// Whether the bar begins again with every session.
    by_session: bool,
}

impl<'a> WatchedProgress<'a> {
    /// A bar for each session.
    pub fn new(context: &'a Context, counts: ProgressCounts) -> WatchedProgress<'a> {
        WatchedProgress { by_session: true, ..WatchedProgress::of_total(context, 0, counts) }
    }

    /// One bar for `total` of what is counted.
    pub fn of_total(
        context: &'a Context,
        total: u64,
        counts: ProgressCounts,
    ) -> WatchedProgress<'a> {
        let what = match counts {
            ProgressCounts::Frames => "frames",
            ProgressCounts::Simulations => "frames on machines",
        };
        let progress = Progress::new(context, total, what);
        WatchedProgress { context, progress, counts, by_session: false }
    }
}

impl Watch for WatchedProgress<'_> {
    fn is_cancelled(&self) -> bool {
        self.context.is_cancelled()
    }

    fn begins(&self, frames: u64, simulations: u64) {
        if self.by_session {
            self.progress.restart(match self.counts {
                ProgressCounts::Frames => frames,
                ProgressCounts::Simulations => simulations,
            });
        }
    }

    fn simulated(&self, n: u64) {
        if self.counts == ProgressCounts::Simulations {
            self.progress.advance(n);
        }
    }

    fn frame_done(&self) {
        if self.counts == ProgressCounts::Frames {
            self.progress.advance(1);
        }
    }
}
