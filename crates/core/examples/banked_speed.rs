//! Bursts per second of processor time of the DRAM model `banked` inside a frame, the accelerator
//! included: the figures in `evidence/performance.md`.
//!
//! ```console
//! $ cargo run --release -p powergs-core --example banked_speed -- 3 traces/demo.bin
//! ```
//!
//! Simulates the first frame of each trace on `gscore`, so many times, alone and with a second
//! master of 8 GB/s; the best time counts. Binning and what is measured of the frame before are
//! not timed.

#[path = "../../../benches/processor.rs"]
mod processor;

use std::path::Path;

use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{RunError, Session, System, SystemSpec, TraceFile};
use powergs_core::sim::{Label, priced, time};

fn system(master: &str) -> Result<System, RunError> {
    let sets = ["dram.model=banked".to_owned(), format!("dram.second-master.rate={master}")];
    System::load(&SystemSpec { sets: sets.into(), ..SystemSpec::named("gscore") }, &EmbeddedFiles)
}

fn main() -> Result<(), RunError> {
    let mut args = std::env::args().skip(1);
    let rounds = args.next().and_then(|rounds| rounds.parse().ok()).unwrap_or(3);
    println!("trace | second master | M bursts | M commands | s | M bursts/s");
    for trace in args {
        for master in ["0 B/s", "8 GB/s"] {
            let system = system(master)?;
            let mut frames = TraceFile::open(Path::new(&trace))?;
            let on = Session::new(&mut frames, &()).frame_on(&system, 0)?;
            let mut best = f64::INFINITY;
            let mut moved = [0; 2];
            for _ in 0..rounds {
                let start = processor::seconds();
                let timed = time(&on.task()).map_err(|e| RunError::in_frame("0", e))?;
                let report = priced(Label::default(), &timed, system.prices())
                    .map_err(|e| RunError::in_frame("0", e.into()))?;
                best = best.min(processor::seconds() - start);
                if let Some(commands) = report.timing().and_then(|timing| timing.dram.commands) {
                    let total = commands.total();
                    let bursts = total.reads + total.writes;
                    moved = [bursts, bursts + total.activates + commands.precharges];
                }
            }
            let [bursts, commands] = moved.map(|count| count as f64 * 1e-6);
            let speed = bursts / best;
            println!("{trace} | {master} | {bursts:.2} | {commands:.2} | {best:.3} | {speed:.2}");
        }
    }
    Ok(())
}
