//! Long calls: they run on a thread of their own without the interpreter's lock, while the calling
//! thread hears Ctrl-C and shows progress.
//!
//! A call that is interrupted raises at once. Its worker is told to stop; it ends after the frame
//! in hand and its results are dropped, so that whoever waits never waits for a long frame. A call
//! with a store waits for such workers first: one of them may still have it open.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::error::{Fault, defect, lost, panicked};
use powergs_core::run::Watch;

/// How often signals and progress are looked at.
const TICK: Duration = Duration::from_millis(50);

/// How long an interrupted worker may take to end before it is left to itself.
const GRACE: Duration = Duration::from_millis(50);

/// The stack of a worker, bytes: that of a main thread.
const STACK: usize = 8 << 20;

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counts {
    /// Frames.
    Frames,
    /// Frames, once for every machine that they go through.
    Simulations,
    /// Whatever the work counts itself.
    Steps,
}

/// What worker and caller tell each other.
#[derive(Debug)]
pub struct Shared {
    counts: Counts,
    cancelled: AtomicBool,
    total: AtomicU64,
    done: AtomicU64,
    /// The worker holds nothing any more.
    ended: AtomicBool,
}

/// Workers that were left to themselves and may hold a store, with their processes: a process that
/// was forked off has none of its parent's.
static LEFT: Mutex<Vec<(u32, Arc<Shared>)>> = Mutex::new(Vec::new());

impl Shared {
    /// Waits until interrupted calls have let go of their stores, or this one is interrupted too.
    pub fn after_interrupted(&self) {
        while !self.is_over() {
            let mut left = LEFT.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            let here = std::process::id();
            left.retain(|(process, worker)| *process == here && !worker.ended.load(Acquire));
            if left.is_empty() {
                return;
            }
            drop(left);
            std::thread::sleep(TICK / 5);
        }
    }

    /// Sets how much there is to do.
    pub fn total(&self, total: u64) {
        self.done.store(0, Relaxed);
        self.total.store(total, Relaxed);
    }

    /// `n` more are done.
    pub fn advance(&self, n: u64) {
        self.done.fetch_add(n, Relaxed);
    }

    /// How much is done.
    pub fn set_done(&self, done: u64) {
        self.done.store(done, Relaxed);
    }

    /// Whether the work is to stop.
    pub fn is_over(&self) -> bool {
        self.cancelled.load(Relaxed)
    }
}

impl Watch for Shared {
    fn is_cancelled(&self) -> bool {
        self.is_over()
    }

    fn begins(&self, frames: u64, simulations: u64) {
        match self.counts {
            Counts::Frames => self.total(frames),
            Counts::Simulations => self.total(simulations),
            Counts::Steps => {}
        }
    }

    fn simulated(&self, n: u64) {
        if self.counts == Counts::Simulations {
            self.advance(n);
        }
    }

    fn frame_done(&self) {
        if self.counts == Counts::Frames {
            self.advance(1);
        }
    }
}

/// What is called with `(done, total)` while work goes on.
struct Meter<'py> {
    bar: Option<Bound<'py, PyAny>>,
    last: (u64, u64),
}

impl<'py> Meter<'py> {
    /// `progress` as `powergs` takes it: `True`, a function of `(done, total)`, or a bar of tqdm.
    fn new(py: Python<'py>, progress: Option<&Bound<'py, PyAny>>, unit: &str) -> PyResult<Self> {
        let bar = match progress {
            None => None,
            Some(progress) => {
                let meter = py.import("powergs.progress")?.getattr("meter")?;
                Some(meter.call1((progress, unit))?).filter(|bar| !bar.is_none())
            }
        };
        Ok(Meter { bar, last: (0, 0) })
    }

    fn show(&mut self, shared: &Shared) -> PyResult<()> {
        let now = (shared.done.load(Relaxed), shared.total.load(Relaxed));
        if let Some(bar) = self.bar.as_ref().filter(|_| now != self.last && now.1 > 0) {
            self.last = now;
            bar.call_method1("show", now)?;
        }
        Ok(())
    }

    fn close(&self) -> PyResult<()> {
        self.bar.as_ref().map_or(Ok(()), |bar| bar.call_method0("close").map(drop))
    }
}

/// Runs `work` and waits for it; `unit` is what is counted (`frames`).
pub fn run<T, F>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    counts: (Counts, &str),
    work: F,
) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce(&Shared) -> Result<T, Fault> + Send + 'static,
{
    run_and(py, progress, counts, &mut || Ok(()), work)
}

/// As [`run`], and calls `meanwhile` again and again on the thread that waits, also when the work
/// is done; an error of it ends the work.
pub fn run_and<T, F>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    (counts, unit): (Counts, &str),
    meanwhile: &mut dyn FnMut() -> PyResult<()>,
    work: F,
) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce(&Shared) -> Result<T, Fault> + Send + 'static,
{
    let mut meter = Meter::new(py, progress, unit)?;
    let result = wait(py, counts, &mut meter, meanwhile, work);
    let closed = meter.close();
    let value = result?;
    closed.map(|()| value)
}

fn wait<T, F>(
    py: Python<'_>,
    counts: Counts,
    meter: &mut Meter<'_>,
    meanwhile: &mut dyn FnMut() -> PyResult<()>,
    work: F,
) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce(&Shared) -> Result<T, Fault> + Send + 'static,
{
    let (cancelled, total, done) = (AtomicBool::new(false), AtomicU64::new(0), AtomicU64::new(0));
    let ended = AtomicBool::new(false);
    let shared = Arc::new(Shared { counts, cancelled, total, done, ended });
    let (sender, mut receiver) = channel();
    let (of_worker, of_worker_ended) = (Arc::clone(&shared), Arc::clone(&shared));
    let pool = pool()?;
    let body = move || {
        let work = AssertUnwindSafe(|| match pool {
            Some(pool) => pool.install(|| work(&of_worker)),
            None => work(&of_worker),
        });
        let result = catch_unwind(work);
        of_worker_ended.ended.store(true, Release);
        // Nobody listens any more after an interrupt.
        let _ = sender.send(result);
    };
    let spawned = std::thread::Builder::new().stack_size(STACK).spawn(body);
    spawned.map_err(|e| defect(format_args!("no thread could be started: {e}")))?;
    loop {
        let (back, answer) = py.detach(move || {
            let answer = receiver.recv_timeout(TICK);
            (receiver, answer)
        });
        receiver = back;
        match answer {
            Ok(Ok(result)) => {
                meter.show(&shared)?;
                meanwhile()?;
                return result.map_err(Fault::raise);
            }
            Ok(Err(payload)) => return Err(panicked(&*payload)),
            Err(RecvTimeoutError::Disconnected) => return Err(lost()),
            Err(RecvTimeoutError::Timeout) => {
                let heard = py.check_signals().and_then(|()| meanwhile());
                let heard = heard.and_then(|()| meter.show(&shared));
                if let Err(raised) = heard {
                    abandon(py, &shared, receiver);
                    return Err(raised);
                }
            }
        }
    }
}

/// Tells the worker to stop, and waits a little for that.
fn abandon<T: Send>(py: Python<'_>, shared: &Arc<Shared>, receiver: Receiver<T>) {
    shared.cancelled.store(true, Relaxed);
    py.detach(move || drop(receiver.recv_timeout(GRACE)));
    let mut left = LEFT.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    left.push((std::process::id(), Arc::clone(shared)));
}

/// The process that used threads first, and the threads of a process that was forked off it: those
/// of its parent do not exist there.
static FORKED: Mutex<Option<(u32, Option<Arc<ThreadPool>>)>> = Mutex::new(None);

fn pool() -> PyResult<Option<Arc<ThreadPool>>> {
    let mut known = FORKED.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let here = std::process::id();
    if let Some((process, pool)) = &*known
        && *process == here
    {
        return Ok(pool.clone());
    }
    let pool = match known.take() {
        None => None,
        Some((_, parents)) => {
            // Dropped, it would wait for threads that are not there.
            std::mem::forget(parents);
            let pool = rayon::ThreadPoolBuilder::new().build();
            Some(Arc::new(pool.map_err(|e| defect(format_args!("no threads: {e}")))?))
        }
    };
    *known = Some((here, pool.clone()));
    Ok(pool)
}
