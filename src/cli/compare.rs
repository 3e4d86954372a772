//! `compare`: machines on one trace beside each other, or finished reports.

use std::fs::File;
use std::io::Read;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use super::camera_file::{FrameRange, frame_range};
use super::engine::{machine_facts, refused};
use super::invocation::Started;
use super::machine_file::{LoadedMachine, load_machine};
use super::progress::Progress;
use super::replay::display_rate;
use super::run_folder::RunFolder;
use super::trace_source::{TraceFrame, TraceSource, hashed};
use super::{Context, Exit, Failure, OrExit, out};
use powergs_core::sim::{FrameReport, Model, simulate};
use powergs_core::workload::{Geometry, bin};
use powergs_report::compare::{self, Comparison, Side};
use powergs_report::{Extras, Facts, Run, Table};

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
    let folder = RunFolder::create(args.out.as_deref(), &labels.join("-"), args.force)?;
    write(&folder, &comparison)?;
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?.join("summary.md");
    if context.global.json {
        out::json(&compare::json(&comparison))?;
    } else if !context.global.quiet {
        let path = path.display().to_string();
        out::text(&compare::terminal(&comparison, Some(&path)))?;
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
    let csv = compare::compare_csv(comparison).or_exit(Exit::Internal, "compare.csv")?;
    folder.write("compare.csv", &csv)?;
    let charts = compare::charts(comparison).or_exit(Exit::Internal, "charts")?;
    folder.write("summary.md", compare::markdown(comparison, &charts).as_bytes())?;
    for chart in charts {
        let png = chart.drawing.png().or_exit(Exit::Internal, chart.name)?;
        folder.write(&format!("{}.png", chart.name), &png)?;
        let svg = chart.drawing.svg().or_exit(Exit::Internal, chart.name)?;
        folder.write(&format!("{}.svg", chart.name), svg.as_bytes())?;
    }
    Ok(())
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
    let load = |arch: &PathBuf| load_machine(&arch.to_string_lossy(), &args.sets);
    let machines: Vec<LoadedMachine> = machines.iter().map(load).collect::<Result<_, _>>()?;
    let mut source = TraceSource::open(trace, args.frames, super::replay::DEFAULT_DISPLAY)?;
    let facts = |m: &LoadedMachine| facts(args, &source, m);
    let facts: Vec<Facts> = machines.iter().map(facts).collect::<Result<_, _>>()?;
    let mut runs: Vec<Run> = facts
        .into_iter()
        .map(|facts| Run { facts, frames: Vec::new(), tiles: None, extras: Extras::default() })
        .collect();
    let progress = Progress::new(context, source.facts.frames as u64, "frames");
    source.in_order(
        |frame| on_each(&machines, &frame),
        |reports| {
            for (run, report) in runs.iter_mut().zip(reports) {
                run.frames.push(report);
            }
            progress.advance(1);
            if context.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        },
    )?;
    if runs[0].frames.is_empty() {
        return Ok(None);
    }
    Ok(Some(runs.iter().map(|run| Side::of_run(run, &Table::of(run))).collect()))
}

/// One frame on every machine; binned once for every geometry.
fn on_each(machines: &[LoadedMachine], frame: &TraceFrame) -> Result<Vec<FrameReport>, Failure> {
    let mut reports: Vec<Option<FrameReport>> = vec![None; machines.len()];
    let mut geometries: Vec<Geometry> = machines.iter().map(|m| m.machine.geometry).collect();
    geometries.sort();
    geometries.dedup();
    for geometry in geometries {
        let workload = bin(&frame.frame, geometry);
        for (report, loaded) in reports.iter_mut().zip(machines) {
            if loaded.machine.geometry == geometry {
                let label = frame.label.clone();
                let name = label.name.clone();
                let simulated = simulate(label, &workload, &loaded.machine, &loaded.prices);
                *report = Some(simulated.map_err(|breach| refused(breach, &name))?);
            }
        }
    }
    Ok(reports.into_iter().flatten().collect())
}

fn facts(args: &Args, source: &TraceSource, loaded: &LoadedMachine) -> Result<Facts, Failure> {
    let [trace, display] = source.inputs.clone();
    let mut inputs = vec![trace];
    let mut configuration = toml::Table::new();
    for (role, file, resolved) in [
        ("machine", &loaded.machine_file, &loaded.resolved_toml),
        ("energy", &loaded.energy_file, &loaded.energy_toml),
    ] {
        inputs.push(hashed(role, &file.origin, &mut file.text.as_bytes(), &file.origin)?);
        let table = resolved.parse().or_exit(Exit::Internal, &file.origin)?;
        configuration.insert(role.to_owned(), toml::Value::Table(table));
    }
    inputs.push(display);
    configuration.insert("display".into(), toml::Value::Table(source.display_toml.clone()));
    Ok(Facts {
        model: Model::Cycle,
        display_fps: args.fps,
        trace: source.facts.clone(),
        machine: machine_facts(loaded),
        inputs,
        configuration,
    })
}
