//! A trace on three machines: frames per second, watts and what a frame costs.
//!
//! ```console
//! $ cargo run --release --example three_machines -- traces/demo.bin
//! ```

use std::path::Path;

use powergs_sim::run::FrameReport;
use powergs_sim::run::files::DiskFiles;
use powergs_sim::run::{RunError, Session, System, SystemSpec, TraceFile};

/// Frames per second that the display shows.
const DISPLAY_FPS: f64 = 60.0;

fn main() -> Result<(), RunError> {
    let trace = std::env::args().nth(1).unwrap_or_else(|| "traces/demo.bin".to_owned());
    let mut trace = TraceFile::open(Path::new(&trace))?;
    // A name, a name with changed keys, and a machine with another energy table.
    let gscore = System::named("gscore")?;
    let eight = gscore.with(&["vru.cores=8".parse().map_err(RunError::Request)?])?;
    let spec = SystemSpec { energy: Some("gscore-7nm".to_owned()), ..SystemSpec::named("gscore") };
    let shrunk = System::load(&spec, &DiskFiles)?;
    let systems = [gscore, eight, shrunk];
    let reports = Session::new(&mut trace, &()).reports(&systems)?;
    println!("{:24} {:>9} {:>12} {:>9}", "machine", "FPS", "mW at 60 FPS", "uJ/frame");
    for (name, reports) in ["gscore", "gscore, 8 cores", "gscore at 7 nm"].iter().zip(&reports) {
        let mean = |of: &dyn Fn(&FrameReport) -> f64| {
            reports.iter().map(of).sum::<f64>() / reports.len() as f64
        };
        println!(
            "{name:24} {:>9.0} {:>12.1} {:>9.1}",
            mean(&|r| r.achieved_fps().unwrap_or(0.0)),
            mean(&|r| r.power_display_rate_w(DISPLAY_FPS) * 1e3),
            mean(&|r| r.energy.total().0 * 1e-6),
        );
    }
    Ok(())
}
