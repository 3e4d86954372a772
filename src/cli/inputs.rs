//! What commands run on: machines, displays and traces, opened as they are named on the command
//! line.

use std::io::Read;
use std::path::Path;

use super::camera_file::{FrameArgs, FrameRange};
use super::replay::display_rate;
use super::{Context, Failure, out};
use powergs_base::quantity::Nanoseconds;
use powergs_core::run::files::{DiskFiles, Files};
use powergs_core::run::{FileKind, Frames, RunError, System, SystemSpec, TraceFile};
use powergs_frame::display::Display;

/// The first bytes of a trace.
const MAGIC: [u8; 8] = *b"\x89PGST\r\n\x1a";

/// Changes of machines.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct SetArgs {
    /// Change a key of the machine, of each if there are several: vru.cores=8; keys of its other
    /// files behind energy:, dram: or display:; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
}

/// What is otherwise than in the file of a machine.
#[derive(Debug, Clone, clap::Args)]
pub struct MachineArgs {
    /// Its keys.
    #[command(flatten)]
    pub changes: SetArgs,
    /// Energy table, in place of the machine's: a name of `arch list`, a TOML file, or an
    /// energy reference table of Accelergy (FILE.yaml)
    #[arg(long, value_name = "NAME|FILE")]
    pub energy: Option<String>,
}

/// Frames per second of a display of which nothing is said.
pub const DISPLAY_FPS: f64 = 60.0;

/// What of a trace is simulated, and how often it is shown.
#[derive(Debug, Clone, clap::Args)]
pub struct TraceArgs {
    /// Display rate, frames per second, for power and deadlines
    #[arg(long, value_name = "RATE", default_value_t = DISPLAY_FPS, value_parser = display_rate)]
    pub fps: f64,
    /// The longest that a frame may take from its first read to its last write: 20ms
    #[arg(long, value_name = "TIME", value_parser = time)]
    pub latency: Option<Nanoseconds>,
    /// Only some frames.
    #[command(flatten)]
    pub only: FrameArgs,
}

impl TraceArgs {
    /// The longest that a frame may take, milliseconds.
    pub fn latency_ms(&self) -> Option<f64> {
        self.latency.map(|time| time.0 * 1e-6)
    }
}

/// A time with its unit, above zero: `20ms`.
fn time(text: &str) -> Result<Nanoseconds, String> {
    let time: Nanoseconds = text.parse().map_err(|e| format!("{e}"))?;
    if time.0 > 0.0 { Ok(time) } else { Err("must be above zero".into()) }
}

/// A machine by name or path with `--set` values, and `--energy` in place of its energy table.
///
/// # Errors
/// Exit code 2: an unknown name (with the known ones), a file that cannot be read, and everything
/// that is wrong in it.
pub fn system(arch: &str, sets: &[String], energy: Option<&str>) -> Result<System, Failure> {
    let spec = SystemSpec {
        machine: arch.to_owned(),
        sets: sets.to_vec(),
        energy: energy.map(str::to_owned),
        display: None,
    };
    loaded(&spec)
}

/// Machine, prices, device and display, with warnings of what is right in them and doubtful.
///
/// # Errors
/// As [`system`].
pub fn loaded(spec: &SystemSpec) -> Result<System, Failure> {
    let system = System::load(spec, &DiskFiles)?;
    for doubt in system.doubts() {
        out::complain(format_args!("warning: {doubt}"));
    }
    Ok(system)
}

/// A display preset by name or path.
///
/// # Errors
/// As [`system`].
pub fn display(name: &str) -> Result<Display, Failure> {
    let file = DiskFiles.read(FileKind::Display, name, None)?;
    let parsed = Display::parse(&file.text).map_err(|e| RunError::config(&file.origin, e))?;
    Ok(parsed)
}

/// A trace, and the frames of it that `--frames` leaves.
///
/// # Errors
/// Exit code 3 for a trace that cannot be read, 2 for a range that it has no frames in.
pub fn trace(
    path: &Path,
    range: Option<FrameRange>,
    context: &Context,
) -> Result<TraceFile, Failure> {
    let mut trace = TraceFile::open(path)?;
    trace.allow(context.global.memory);
    if let Some(range) = range {
        trace.select(range.start, range.end)?;
    }
    if trace.looks_paired()? && !context.global.quiet {
        out::complain(unpaired(path.display()));
    }
    Ok(trace)
}

/// What is said of a trace of views that were written as no pairs and look like some.
pub fn unpaired(place: impl std::fmt::Display) -> String {
    format!(
        "warning: {place}: views are called NAME_left and NAME_right, and the trace does not say \
         that they are pairs (it is of an older version): each eye counts as a frame of its own, \
         so that deadline and power at the display rate are those of ONE eye; extract it again \
         with --stereo"
    )
}

/// Whether a file begins as a trace does.
pub fn is_trace(path: &Path) -> bool {
    let mut magic = [0; MAGIC.len()];
    if !path.is_file() {
        return false;
    }
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut magic));
    read.is_ok() && magic == MAGIC
}
