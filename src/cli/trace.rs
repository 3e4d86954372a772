//! `trace info`, `verify`, `dump` and `repair`: what a trace holds, and whether it can be trusted.

mod dump;
mod info;
mod repair;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::output_file::OutputArgs;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_base::format::counted;
use powergs_frame::trace::{self, Reader, VerifyReport};

/// Shown under `trace --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim trace info traces/demo.bin
  powergs-sim trace verify scene.bin
  powergs-sim trace dump scene.bin --frame 3 -o splats.csv
  powergs-sim trace dump scene.bin --frame 0 --what facts
  powergs-sim trace repair damaged.bin -o repaired.bin

docs/trace-format.md describes the file.";

/// Look at traces, check them, dump frames as CSV
#[derive(Debug, clap::Args)]
pub struct TraceCommandArgs {
    #[command(subcommand)]
    command: TraceCommand,
}

#[derive(Debug, clap::Subcommand)]
enum TraceCommand {
    /// Print header, frames, and what a visible splat and a pixel take on disk
    Info {
        /// The trace
        file: PathBuf,
        /// List every frame, not only the first twelve
        #[arg(long)]
        all: bool,
    },
    /// Check every byte and every value; list what is damaged
    Verify {
        /// The trace, whole or not
        file: PathBuf,
    },
    /// Write one frame as CSV
    Dump(dump::DumpArgs),
    /// Write the intact frames of a damaged or unfinished trace as a new one
    Repair {
        /// The damaged trace
        file: PathBuf,
        #[command(flatten)]
        to: OutputArgs,
    },
}

/// Runs the command.
pub fn run(args: &TraceCommandArgs, context: &Context) -> Result<Exit, Failure> {
    match &args.command {
        TraceCommand::Info { file, all } => info::run(file, *all, context),
        TraceCommand::Verify { file } => verify(file, context),
        TraceCommand::Dump(args) => dump::run(args, context),
        TraceCommand::Repair { file, to } => repair::run(file, to.file()?, context),
    }
}

/// Opens a complete trace.
pub fn open(path: &Path) -> Result<Reader<BufReader<File>>, Failure> {
    Reader::open(BufReader::new(open_file(path)?)).or_exit(Exit::BadInput, path.display())
}

fn open_file(path: &Path) -> Result<File, Failure> {
    File::open(path).or_exit(Exit::BadInput, format_args!("{}: cannot be opened", path.display()))
}

fn verify(path: &Path, context: &Context) -> Result<Exit, Failure> {
    let file = open_file(path)?;
    let report = check(path, file, context, |_, _| Ok(()))?;
    let Some(report) = report else { return Ok(Exit::Interrupted) };
    if context.global.json {
        out::json(&as_json(&report))?;
    } else if report.is_good() {
        if !context.global.quiet {
            out::text(&format!(
                "{}: good: {}, {} bytes, every checksum and value checked\n",
                path.display(),
                counted(report.intact, "frame"),
                report.bytes
            ))?;
        }
    } else {
        out::text(&damage_lines(path, &report))?;
    }
    Ok(if report.is_good() { Exit::Done } else { Exit::BadInput })
}

/// Reads all of a trace and hands on the intact frames; `None` after Ctrl-C.
fn check(
    path: &Path,
    file: File,
    context: &Context,
    mut keep: impl FnMut(&trace::TraceHeader, trace::EncodedFrame) -> Result<(), trace::TraceError>,
) -> Result<Option<VerifyReport>, Failure> {
    let size = file.metadata().map_or(0, |m| m.len());
    let progress = super::progress::Progress::new(context, size, "bytes");
    let visited = trace::visit_intact(file, context.global.memory, |header, frame| {
        progress.advance(frame.bytes());
        keep(header, frame)?;
        Ok(match context.is_cancelled() {
            true => std::ops::ControlFlow::Break(()),
            false => std::ops::ControlFlow::Continue(()),
        })
    });
    let report = visited.or_exit(Exit::BadInput, path.display())?;
    Ok((!context.is_cancelled()).then_some(report))
}

fn damage_lines(path: &Path, report: &VerifyReport) -> String {
    let mut text = format!("{}: damaged\n", path.display());
    for damage in &report.damage {
        text += &format!("  byte {}: {}\n", damage.offset, damage.what);
    }
    let unlisted = report.damaged_places - report.damage.len() as u64;
    if unlisted > 0 {
        text += &format!("  and {} more\n", counted(unlisted, "place"));
    }
    text += &match report.listed {
        Some(n) => format!("{} of {} intact", report.intact, counted(n, "frame")),
        None => format!("{} intact", counted(report.intact, "frame")),
    };
    text += match report.intact {
        0 => "; extract the trace again\n",
        _ => "; extract the trace again, or keep those:\n  powergs-sim trace repair FILE -o NEW\n",
    };
    text
}

fn as_json(report: &VerifyReport) -> serde_json::Value {
    let damage = report.damage.iter().map(|d| json!({ "offset": d.offset, "what": d.what }));
    json!({
        "good": report.is_good(),
        "complete": report.complete,
        "format_version": format!("{}.{}", report.version.0, report.version.1),
        "bytes": report.bytes,
        "frames_intact": report.intact,
        "frames_listed": report.listed,
        "damaged_places": report.damaged_places,
        "damage": damage.collect::<Vec<_>>(),
    })
}

/// Text of a file for a terminal: control characters are escaped.
fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        match c.is_control() {
            true => shown.extend(c.escape_default()),
            false => shown.push(c),
        }
    }
    shown
}
