//! `sensitivity`: what every key of a machine moves on some traces, what every modelling assumption
//! does, and how keys act together.

mod interactions;
mod keys;
mod levels;
mod measure;
mod output;
mod turned;

use std::path::PathBuf;

use super::camera_file::{FrameRange, frame_range};
use super::invocation::Started;
use super::replay::display_rate;
use super::run_folder::RunFolder;
use super::{Context, Exit, Failure, inputs, out};
use interactions::{Asked, Method};
use keys::{Candidate, Key};
use levels::Wanted;
use measure::Machines;
use powergs_base::config::assumptions::assumptions;
use powergs_base::config::knob;
use powergs_core::run::store::atomic::write_atomically;
use powergs_core::run::{System, TraceFile};
use powergs_study::findings::sensitivity::Sensitivity;
use powergs_study::findings::sensitivity::interactions::Interactions;
use powergs_study::findings::sensitivity::keys::{KeyRow, Keys, Turned};

/// Shown under `sensitivity --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim sensitivity gscore traces/demo.bin
  powergs-sim sensitivity mine.toml room.bin street.bin --frames ..4 --out reports/s
  powergs-sim sensitivity gscore scene.bin --interactions morris
  powergs-sim sensitivity gscore scene.bin --interactions sobol --samples 128 \\
    --keys 'vru.cores=2..8,dram.bandwidth=25 GB/s..100 GB/s,geometry.subtile=4|8'
  powergs-sim sensitivity gscore scene.bin --assumptions --only A4,A5,A27 --json

Every key of the machine, of its energy table and of its DRAM device is turned one
after the other: by a step down and up (elasticity), to half and double, to other
names. --interactions turns the twelve that matter most, or those of --keys, together.
--assumptions turns the knobs of docs/model.md (A4) by 50 % instead.";

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
    /// Only these keys, `*` at the end is any rest; with --interactions also their
    /// values: KEY, KEY=LOW..HIGH, KEY=A|B|C
    #[arg(long, value_name = "KEYS", value_delimiter = ',', value_parser = levels::wanted)]
    pub keys: Vec<Wanted>,
    /// Relative step of elasticities; where that is no machine, the next larger one
    #[arg(long, value_name = "SHARE", default_value = "0.1", value_parser = step)]
    pub step: f64,
    /// Display rate, frames per second, for power
    #[arg(long, value_name = "RATE", default_value = "60", value_parser = display_rate)]
    pub fps: f64,
    /// Turn keys together: which interact, and how much
    #[arg(long, value_enum, value_name = "METHOD")]
    pub interactions: Option<Method>,
    /// Trajectories of morris [default: 20], rows of sobol [default: 128]
    #[arg(long, value_name = "N", requires = "interactions")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub samples: Option<u32>,
    /// Seed of the sample of --interactions
    #[arg(long, value_name = "SEED", default_value = "1")]
    pub seed: u64,
    /// Turn the modelling assumptions of docs/model.md instead of keys
    #[arg(long, conflicts_with_all = ["keys", "interactions"])]
    pub assumptions: bool,
    /// Only these assumptions: A4,A27
    #[arg(long, value_name = "NUMBERS", requires = "assumptions")]
    #[arg(value_delimiter = ',', value_parser = number)]
    pub only: Vec<u32>,
    /// Only frames A to B of each trace, B excluded, counted from 0: 0..24, 10.., ..5
    #[arg(long, value_name = "A..B", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
    /// Also write the main table as CSV to this file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Report folder [default: reports/sensitivity-MACHINE, with a counter if it exists]
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the finished report in --out
    #[arg(long)]
    pub force: bool,
}

/// A step between what rounding hides and half.
fn step(text: &str) -> Result<f64, String> {
    let step = text.parse().ok().filter(|s| (0.001..=0.5).contains(s));
    step.ok_or_else(|| "a share from 0.001 to 0.5, e.g. 0.1".to_owned())
}

fn number(text: &str) -> Result<u32, String> {
    let number = text.trim().trim_start_matches(['A', 'a']).parse().ok();
    let known = number.filter(|n| assumptions().contains_key(n));
    known.ok_or_else(|| {
        let all: Vec<String> = assumptions().keys().map(|n| format!("A{n}")).collect();
        format!("no such assumption; known: {}", all.join(" "))
    })
}

/// What came out.
enum Found {
    Assumptions(Sensitivity),
    Keys(Keys, Option<Interactions>),
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    let system = inputs::system(&args.arch, &args.sets, args.energy.as_deref())?;
    let open = |path: &PathBuf| inputs::trace(path, args.frames);
    let mut sources: Vec<TraceFile> = args.traces.iter().map(open).collect::<Result<_, _>>()?;
    let folder_name = format!("sensitivity-{}", system.machine().name);
    let folder = RunFolder::create(args.out.as_deref(), &folder_name, args.force)?;
    let found = match args.assumptions {
        true => of_assumptions(args, &system, &mut sources, context)?,
        false => of_keys(args, &system, &mut sources, context)?,
    };
    let Some(found) = found else {
        out::complain("interrupted before the first frame was done: no report");
        return Ok(Exit::Interrupted);
    };
    let table = output::write(&folder, &found)?;
    if let Some(path) = &args.csv {
        write_atomically(path, |w| w.write_all(&table))?;
    }
    folder.write("run.toml", output::record(args, &system, &sources)?.as_bytes())?;
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?.join("summary.md");
    if context.global.json {
        out::json(&output::json(&found))?;
    } else if !context.global.quiet {
        out::text(&output::terminal(&found, &path.display().to_string()))?;
    }
    Ok(if context.is_cancelled() { Exit::Interrupted } else { Exit::Done })
}

/// Every key, and keys together; `None` if not even one frame was done.
fn of_keys(
    args: &Args,
    system: &System,
    sources: &mut [TraceFile],
    context: &Context,
) -> Result<Option<Found>, Failure> {
    let base = system;
    let (all, mut not_tried) = keys::all(base);
    let all = levels::only(all, &args.keys)?;
    if !args.keys.is_empty() {
        not_tried.clear();
    }
    let tried = keys::candidates(&all, base, args.step);
    let systems = tried.iter().flatten().filter_map(|c| c.system.as_ref().ok());
    let machines = Machines::of(std::iter::once(base).chain(systems), args.fps);
    let Some(means) = measure::all(sources, &machines, context)? else { return Ok(None) };
    let turned = |c: &Candidate| Turned {
        reach: c.reach,
        value: knob::shown(&c.value),
        ratio: c.ratio,
        outcomes: c.system.as_ref().map_err(Clone::clone).map(|s| machines.outcomes(s, &means)),
    };
    let row = |(key, tried): (&Key, &Vec<Candidate>)| KeyRow {
        file: key.file.name(),
        key: key.path.clone(),
        value: knob::shown(&key.value),
        base: machines.outcomes(base, &means),
        turns: tried.iter().map(turned).collect(),
        reason: key.reason(),
    };
    let found = Keys {
        machine: system.machine().name.clone(),
        display_fps: args.fps,
        step: args.step,
        traces: measure::traced(&means),
        rows: all.iter().zip(&tried).map(row).collect(),
        not_tried,
    };
    let found = found.sorted();
    let Some(method) = args.interactions else { return Ok(Some(Found::Keys(found, None))) };
    if context.is_cancelled() {
        out::complain("interrupted: the report is without interactions");
        return Ok(Some(Found::Keys(found, None)));
    }
    let factors = levels::levelled(&all, &args.keys, &found, base)?;
    let samples = args.samples.map(|n| n as usize);
    let asked = Asked { method, samples, seed: args.seed, display_fps: args.fps };
    let name = &system.machine().name;
    let together = interactions::run(&asked, name, base, &factors, sources, context)?;
    if together.is_none() {
        out::complain("interrupted: the report is without interactions");
    }
    Ok(Some(Found::Keys(found, together)))
}

/// Every assumption; `None` if not even one frame was done.
fn of_assumptions(
    args: &Args,
    system: &System,
    sources: &mut [TraceFile],
    context: &Context,
) -> Result<Option<Found>, Failure> {
    let wanted = |n: &u32| args.only.is_empty() || args.only.contains(n);
    let all = assumptions().iter().map(|(n, a)| (*n, a)).filter(|(n, _)| wanted(n));
    let (turns, fixed) = turned::turns(system, all);
    let machines = Machines::of(measure::systems(system, &turns), args.fps);
    let Some(means) = measure::all(sources, &machines, context)? else { return Ok(None) };
    let found = Sensitivity {
        machine: system.machine().name.clone(),
        traces: measure::traced(&means),
        rows: measure::rows(&turns, &machines, &means),
        fixed,
    };
    Ok(Some(Found::Assumptions(found.sorted())))
}
