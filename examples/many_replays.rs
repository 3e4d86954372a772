//! Replays the first frame of a trace again and again, from memory: what a caller in Rust pays for
//! each. `benches/python.py` sets the same beside it from Python. Prints seconds for all of them.
//!
//! ```console
//! $ cargo run --release --example many_replays -- traces/demo.bin 100
//! ```

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use powergs_sim::run::session::Target;
use powergs_sim::run::{Frames, MemoryFrames, System, TraceFile};
use powergs_sim::study::replay::Replay;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let trace = arguments.next().unwrap_or_else(|| "traces/demo.bin".to_owned());
    let count: u32 = arguments.next().map_or(Ok(10), |count| count.parse())?;
    let mut file = TraceFile::open(Path::new(&trace))?;
    let frame = file.take(file.range().start)?.get()?;
    let mut frames = MemoryFrames { name: trace, frames: vec![frame] };
    let system = System::named("gscore")?;
    let replay = Replay {
        latency_ms: None,
        target: Target::System(&system),
        display_fps: 60.0,
        what_if_frames: 0,
        calibrates_what_if: true,
        compares_models: false,
    };
    let start = Instant::now();
    for _ in 0..count {
        replay.run(&mut frames, &())?;
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("replays    seconds    ms each");
    println!("{count:7} {seconds:10.6} {:10.3}", 1e3 * seconds / f64::from(count));
    Ok(())
}
