//! What happens around every command: threads, Ctrl-C, and what a broken invariant looks like.

use std::any::Any;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::invocation::BUILD;
use super::{Context, Exit, Failure, Global, out};
use powergs_base::build;
use powergs_report::Drawing;

/// Runs the command of a program and returns its exit code; errors are on standard error by then.
pub fn start(
    global: &Global,
    drawing: Drawing,
    run: impl FnOnce(&Context) -> Result<Exit, Failure>,
) -> Exit {
    build::is(BUILD);
    std::panic::set_hook(Box::new(announce));
    guarded(|| {
        prepare(global, drawing).and_then(|context| run(&context)).unwrap_or_else(|failure| {
            out::complain(format_args!("error: {failure}"));
            failure.exit
        })
    })
}

/// Runs `work`; a panic in it (a failed assertion) becomes [`Exit::Internal`], after
/// everything on the stack was cleaned up: temporary files go away.
pub fn guarded(work: impl FnOnce() -> Exit) -> Exit {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(Exit::Internal)
}

/// Threads for each core at most: more of them only wait for each other.
const THREADS_PER_CORE: usize = 4;

/// Sizes the thread pool and takes over Ctrl-C.
fn prepare(global: &Global, drawing: Drawing) -> Result<Context, Failure> {
    if let Some(jobs) = global.jobs {
        let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
        // A few threads are always allowed, so that a script runs on a small machine too.
        let most = (THREADS_PER_CORE * cores).max(64);
        if jobs.get() > most {
            let what = format!(
                "--jobs {jobs}: at most {most} threads on this machine; it has {cores} cores, and \
                 more threads make nothing faster"
            );
            return Err(Failure::new(Exit::Usage, what));
        }
        rayon::ThreadPoolBuilder::new().num_threads(jobs.get()).build_global().map_err(|e| {
            Failure::new(Exit::Usage, format!("--jobs {jobs}: cannot start the threads: {e}"))
        })?;
    }
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&cancelled);
    on_interruption(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(Exit::Interrupted as i32);
        }
        out::complain("interrupted: finishing what is under way; Ctrl-C again stops at once");
    });
    Ok(Context { global: global.clone(), drawing, cancelled })
}

/// Calls `handler` at Ctrl-C, and at the SIGTERM that batch systems send at the end of their time.
/// SIGHUP stays as it is: `nohup` ignores it. Without a handler Ctrl-C ends the program at once:
/// less kind, but no reason not to run.
#[cfg(unix)]
fn on_interruption(handler: impl Fn() + Send + 'static) {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGINT, SIGTERM]) else { return };
    std::thread::spawn(move || signals.forever().for_each(|_| handler()));
}

/// Calls `handler` at Ctrl-C.
#[cfg(not(unix))]
fn on_interruption(handler: impl Fn() + Send + 'static) {
    let _ = ctrlc::set_handler(handler);
}

/// The panic hook: once, without a backtrace unless `RUST_BACKTRACE` asks for one.
fn announce(info: &PanicHookInfo<'_>) {
    static FIRST: AtomicBool = AtomicBool::new(true);
    if !FIRST.swap(false, Ordering::Relaxed) {
        return;
    }
    let place = info.location().map(ToString::to_string);
    out::complain(internal_error(info.payload(), place.as_deref()));
    let backtrace = std::backtrace::Backtrace::capture();
    if backtrace.status() == std::backtrace::BacktraceStatus::Captured {
        out::complain(backtrace);
    }
}

/// What the user reads when an assertion failed.
pub fn internal_error(payload: &(dyn Any + Send), place: Option<&str>) -> String {
    let message = payload
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("no message");
    format!(
        "internal error: {message}\n  at {}, powergs-sim {}\n  This is a mistake in the simulator, \
         not in your input; please report it with the\n  command line and the input files. Nothing \
         that this run would have written is\n  to be used.",
        place.unwrap_or("an unknown place"),
        env!("CARGO_PKG_VERSION")
    )
}
