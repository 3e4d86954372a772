//! `compare`: machines on one trace beside each other, or finished reports.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::camera_file::{FrameRange, frame_range};
use super::invocation::Started;
use super::progress::{Counts, Watched};
use super::replay::{DEFAULT_DISPLAY, display_rate};
use super::run_folder::RunFolder;
use super::{Context, Exit, Failure, OrExit, inputs, out};
use powergs_core::run::files::DiskFiles;
use powergs_core::run::{System, SystemSpec};
use powergs_report::compare;
use powergs_study::findings::compare::{Comparison, Side};
use powergs_study::replay::on_each;

/// Shown under `compare --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim compare gscore edge traces/demo.bin
  powergs-sim compare gscore mine.toml scene.bin --set energy=gscore-28nm-lpddr4
  powergs-sim compare reports/monday reports/today --json
  powergs-sim compare gscore mine.toml scene.bin --at-least 0.95 || echo slower

The first machine (or report) is what the others are compared with.";

/// The largest `run.toml` or `results.csv` that is read.
const RECORD_MAX: u64 = 1 << 28;

/// The arguments of `compare`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Two or more machines (names of `arch list`, or TOML files), then a trace; or two
    /// or more report folders
    #[arg(required = true, num_args = 2.., value_name = "ITEM")]
    pub items: Vec<PathBuf>,
    /// Change a key of every machine file for this run; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// Display rate, frames per second, for power
    #[arg(long, value_name = "RATE", default_value = "60", value_parser = display_rate)]
    pub fps: f64,
    /// Only frames A to B, B excluded, counted from 0: 0..24, 10.., ..5
    #[arg(long, value_name = "A..B", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
    /// Exit with code 1 if any other side has less than RATIO times the frame rate of
    /// the first
    #[arg(long, value_name = "RATIO", value_parser = ratio)]
    pub at_least: Option<f64>,
    /// Report folder [default: reports/A-B, with a counter if it exists]
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the finished report in --out
    #[arg(long)]
    pub force: bool,
}

fn ratio(text: &str) -> Result<f64, String> {
    let ratio: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if ratio > 0.0 && ratio.is_finite() { Ok(ratio) } else { Err("must be above zero".into()) }
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    // What is given is looked at before anything is simulated.
    let given = args.out.as_deref().map(|out| RunFolder::create(Some(out), "", args.force));
    let given = given.transpose()?;
    let folders = args.items.iter().filter(|p| p.is_dir()).count();
    let sides = if folders == args.items.len() {
        of_folders(args)?
    } else if folders > 0 {
        let what = "report folders cannot be compared with machines: replay the trace on the \
                    machines, or give folders only";
        return Err(Failure::new(Exit::Usage, what));
    } else {
        match simulated(args, context)? {
            Some(sides) => sides,
            None => {
                out::complain("interrupted before the first frame was done: no report");
                return Ok(Exit::Interrupted);
            }
        }
    };
    let comparison = Comparison::new(sides);
    let labels = comparison.labels();
    let folder = match given {
        Some(folder) => folder,
        None => RunFolder::create(None, &labels.join("-"), args.force)?,
    };
    write(&folder, &comparison)?;
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?.join("summary.md");
    if context.global.json {
        out::json(&compare::json(&comparison))?;
    } else if !context.global.quiet {
        let path = path.display().to_string();
        out::document(&compare::document(&comparison, &[], Some(&path)))?;
    }
    if context.is_cancelled() {
        return Ok(Exit::Interrupted);
    }
    goal(args, &comparison)
}

/// Whether the others are fast enough.
fn goal(args: &Args, comparison: &Comparison) -> Result<Exit, Failure> {
    let Some(wanted) = args.at_least else { return Ok(Exit::Done) };
    let Some(least) = comparison.least_speedup() else {
        let what = "--at-least: one of the sides has no frame time";
        return Err(Failure::new(Exit::Usage, what));
    };
    if least >= wanted {
        return Ok(Exit::Done);
    }
    out::complain(format_args!(
        "goal missed: {least:.3} times the frame rate of {}, at least {wanted} was asked for",
        comparison.sides[0].label
    ));
    Ok(Exit::GoalMissed)
}

fn write(folder: &RunFolder, comparison: &Comparison) -> Result<(), Failure> {
    let record = compare::run_toml(comparison).or_exit(Exit::Internal, "run.toml")?;
    folder.write("run.toml", record.as_bytes())?;
    folder.write("compare.csv", &compare::compare_csv(comparison))?;
    let charts = compare::charts(comparison);
    let page = compare::document(comparison, &charts, None).markdown();
    folder.write("summary.md", page.as_bytes())?;
    folder.write_charts(&charts)
}

/// Finished reports.
fn of_folders(args: &Args) -> Result<Vec<Side>, Failure> {
    if !args.sets.is_empty() || args.frames.is_some() {
        let what = "--set, --frames: finished reports are not simulated again";
        return Err(Failure::new(Exit::Usage, what));
    }
    let side = |folder: &PathBuf| {
        let label = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy();
        let run_toml = text(&folder.join("run.toml"))?;
        let results = text(&folder.join("results.csv"))?;
        Side::of_folder(&label, &run_toml, results.as_bytes())
            .or_exit(Exit::BadInput, folder.display())
    };
    args.items.iter().map(side).collect()
}

fn text(path: &Path) -> Result<String, Failure> {
    let mut bytes = Vec::new();
    let mut read = || {
        let n = File::open(path)?.take(RECORD_MAX + 1).read_to_end(&mut bytes)?;
        if n as u64 > RECORD_MAX {
            return Err(std::io::Error::other("larger than any report's"));
        }
        Ok(())
    };
    let what = || format!("{}: is its folder a finished report of `replay`?", path.display());
    read().or_exit(Exit::BadInput, what())?;
    String::from_utf8(bytes).or_exit(Exit::BadInput, what())
}

/// Simulates the trace on every machine; `None` if not even one frame was done.
fn simulated(args: &Args, context: &Context) -> Result<Option<Vec<Side>>, Failure> {
    let (trace, machines) = args.items.split_last().expect("clap: at least two items");
    if machines.len() < 2 {
        let what = format!(
            "{}: one machine only; compare MACHINE MACHINE... TRACE, or two report folders",
            machines.first().unwrap_or(trace).display()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    let load = |arch: &PathBuf| {
        let spec = SystemSpec {
            machine: arch.to_string_lossy().into_owned(),
            sets: args.sets.clone(),
            energy: None,
            display: Some(DEFAULT_DISPLAY.to_owned()),
        };
        System::load(&spec, &DiskFiles)
    };
    let systems: Vec<System> = machines.iter().map(load).collect::<Result<_, _>>()?;
    let mut trace = inputs::trace(trace, args.frames, context)?;
    let watch = Watched::new(context, Counts::Frames);
    let runs = on_each(&systems, args.fps, &mut trace, &watch)?;
    Ok(runs.iter().map(Side::of_run).collect())
}
