//! `sensitivity`: what every modelling assumption moves on a machine and some traces.

mod measure;
mod turned;

use std::path::PathBuf;

use super::camera_file::{FrameRange, frame_range};
use super::invocation::Started;
use super::machine_file::{LoadedMachine, load_machine_with};
use super::replay::DEFAULT_DISPLAY;
use super::run_folder::RunFolder;
use super::trace_source::{TraceSource, hashed};
use super::{Context, Exit, Failure, OrExit, out};
use crate::config::assumptions::assumptions;
use crate::report::sensitivity::{self, Fixed, Sensitivity};
use crate::report::{MODEL_VERSION, TOOL_VERSION};
use measure::Machines;
use turned::Files;

/// Shown under `sensitivity --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim sensitivity gscore traces/demo.bin
  powergs-sim sensitivity mine.toml room.bin street.bin --frames ..4 --out reports/s
  powergs-sim sensitivity gscore scene.bin --only A4,A5,A27 --json
  powergs-sim sensitivity gscore scene.bin --set dram.model=banked --csv table.csv

Each assumption of docs/model.md has a number (A4) and, where possible, a key in a
machine, energy or DRAM file (arch-configs/assumptions.toml). Every key is turned
by 50 % down and up, one after the other; names are turned to the other names.";

/// The arguments of `sensitivity`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Machine: a name of `arch list`, or a TOML file
    pub arch: String,
    /// Traces, as written by `extract`
    #[arg(required = true, value_name = "TRACE")]
    pub traces: Vec<PathBuf>,
    /// Change a key of the machine file for this run; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// Energy table, in place of the machine's: a name of `arch list`, or a file
    #[arg(long, value_name = "NAME|FILE")]
    pub energy: Option<String>,
    /// Only these assumptions: A4,A27
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', value_parser = number)]
    pub only: Vec<u32>,
    /// Only frames A to B of each trace, B excluded, counted from 0: 0..24, 10.., ..5
    #[arg(long, value_name = "A..B", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
    /// Also write the table as CSV to this file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Report folder [default: reports/sensitivity-MACHINE, with a counter if it exists]
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the finished report in --out
    #[arg(long)]
    pub force: bool,
}

fn number(text: &str) -> Result<u32, String> {
    let number = text.trim().trim_start_matches(['A', 'a']).parse().ok();
    let known = number.filter(|n| assumptions().contains_key(n));
    known.ok_or_else(|| {
        let all: Vec<String> = assumptions().keys().map(|n| format!("A{n}")).collect();
        format!("no such assumption; known: {}", all.join(" "))
    })
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    let loaded = load_machine_with(&args.arch, &args.sets, args.energy.as_deref())?;
    let open = |path: &PathBuf| TraceSource::open(path, args.frames, DEFAULT_DISPLAY);
    let mut sources: Vec<TraceSource> = args.traces.iter().map(open).collect::<Result<_, _>>()?;
    let folder_name = format!("sensitivity-{}", loaded.machine.name);
    let folder = RunFolder::create(args.out.as_deref(), &folder_name, args.force)?;
    let Some(found) = experiment(args, &loaded, &mut sources, context)? else {
        out::complain("interrupted before the first frame was done: no report");
        return Ok(Exit::Interrupted);
    };
    let csv = sensitivity::csv(&found).or_exit(Exit::Internal, "sensitivity.csv")?;
    if let Some(path) = &args.csv {
        super::aside::write_aside(path, |w| w.write_all(&csv))?;
    }
    write(&folder, &found, &csv)?;
    folder.write("run.toml", record(&loaded, &sources)?.as_bytes())?;
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?.join("summary.md");
    if context.global.json {
        out::json(&sensitivity::json(&found))?;
    } else if !context.global.quiet {
        out::text(&sensitivity::terminal(&found, Some(&path.display().to_string())))?;
    }
    Ok(if context.is_cancelled() { Exit::Interrupted } else { Exit::Done })
}

/// `None` if not even one frame was done.
fn experiment(
    args: &Args,
    loaded: &LoadedMachine,
    sources: &mut [TraceSource],
    context: &Context,
) -> Result<Option<Sensitivity>, Failure> {
    let wanted = |n: &u32| args.only.is_empty() || args.only.contains(n);
    let all = assumptions().iter().map(|(n, a)| (*n, a)).filter(|(n, _)| wanted(n));
    let (mut turns, mut fixed) = turned::turns(loaded, all);
    let base = Files::of(loaded, &[]).map_err(|e| Failure::new(Exit::Usage, e))?;
    let machines = Machines::of(&base, &turns);
    for (number, why) in measure::without_base(&turns, &machines) {
        turns.retain(|t| t.number != number);
        let text = assumptions()[&number].text.clone();
        fixed.push(Fixed { number: format!("A{number}"), text, why });
    }
    let mut means = Vec::new();
    for source in sources {
        if context.is_cancelled() {
            break;
        }
        means.extend(measure::measure(source, &machines, context)?);
    }
    if means.is_empty() {
        return Ok(None);
    }
    let found = Sensitivity {
        machine: loaded.machine.name.clone(),
        traces: measure::traced(&means),
        rows: measure::rows(&turns, &machines, &means),
        fixed,
    };
    Ok(Some(found.sorted()))
}

fn write(folder: &RunFolder, found: &Sensitivity, csv: &[u8]) -> Result<(), Failure> {
    folder.write("sensitivity.csv", csv)?;
    let charts = sensitivity::charts(found).or_exit(Exit::Internal, "charts")?;
    folder.write("summary.md", sensitivity::markdown(found, &charts).as_bytes())?;
    for chart in charts {
        let png = chart.drawing.png().or_exit(Exit::Internal, chart.name)?;
        folder.write(&format!("{}.png", chart.name), &png)?;
        let svg = chart.drawing.svg().or_exit(Exit::Internal, chart.name)?;
        folder.write(&format!("{}.svg", chart.name), svg.as_bytes())?;
    }
    Ok(())
}

/// `run.toml`: versions, inputs, configuration.
fn record(loaded: &LoadedMachine, sources: &[TraceSource]) -> Result<String, Failure> {
    let mut inputs = Vec::new();
    for (role, file) in [
        ("machine", &loaded.machine_file),
        ("energy", &loaded.energy_file),
        ("dram", &loaded.device_file),
    ] {
        inputs.push(hashed(role, &file.origin, &mut file.text.as_bytes(), &file.origin)?);
    }
    inputs.extend(sources.iter().map(|s| s.inputs[0].clone()));
    let input = |i: &crate::report::Input| {
        let mut table = toml::Table::new();
        table.insert("role".into(), i.role.into());
        table.insert("name".into(), i.name.clone().into());
        table.insert("bytes".into(), (i.bytes as i64).into());
        table.insert("xxh3".into(), format!("{:032x}", i.xxh3).into());
        toml::Value::Table(table)
    };
    let mut table = toml::Table::new();
    table.insert("tool-version".into(), TOOL_VERSION.into());
    table.insert("model-version".into(), i64::from(MODEL_VERSION).into());
    table.insert("inputs".into(), inputs.iter().map(input).collect::<Vec<_>>().into());
    let machine: toml::Table =
        loaded.resolved_toml.parse().or_exit(Exit::Internal, &loaded.machine_file.origin)?;
    table.insert("machine".into(), machine.into());
    Ok(table.to_string())
}
