//! Sweeps, what their tables say, replays, sensitivity, and published numbers beside ours.

mod analysis;
mod estimators;
mod extract;
mod ledger;
mod regressions;
mod replay;
mod sensitivity;
mod slurm;
mod sweep_results;
mod sweep_space;
mod validate;

use std::path::Path;

use powergs_core::run::{Frames, MemoryFrames, TraceFile};

/// The first frames of the demo trace, in memory.
fn frames(count: usize) -> MemoryFrames {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../traces/demo.bin");
    let mut trace = TraceFile::open(&path).expect("the demo trace");
    let frame = |k| trace.take(k).and_then(|pending| pending.get()).expect("a frame");
    let frames: Vec<_> = (0..count).map(frame).collect();
    MemoryFrames { name: "demo".to_owned(), frames }
}
