//! `sensitivity`: what every key of a machine moves on some traces, what every modelling assumption
//! does, and how keys act together.

mod output;

use std::path::{Path, PathBuf};

use super::chart_args::ChartArgs;
use super::dram_model::{self, DramModelArg};
use super::inputs::{MachineArgs, TraceArgs};
use super::invocation::Started;
use super::progress::{ProgressCounts, WatchedProgress};
use super::run_folder::ReportArgs;
use super::{Context, Exit, Failure, inputs, out, output_file};
use powergs_base::config::assumptions::assumptions;
use powergs_core::run::TraceFile;
use powergs_core::run::store::atomic::write_atomically;
use powergs_study::findings::sensitivity::Sensitivity;
use powergs_study::sensitivity::{
    AssumptionStudy, InteractionStudy, KeyResults, KeySelection, KeyStudy, Method,
};

/// Shown under `sensitivity --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim sensitivity gscore traces/demo.bin
  powergs-sim sensitivity mine.toml room.bin street.bin --frames ..4 -o out
  powergs-sim sensitivity gscore scene.bin --interactions morris
  powergs-sim sensitivity gscore scene.bin --interactions sobol --samples 128 \\
    --keys 'vru.cores=2..8,ccu.units=2..8,geometry.subtile=4|8'
  powergs-sim sensitivity gscore scene.bin --assumptions --only A4,A5,A27 --json

Every key of the machine, of its energy table and of its DRAM device is varied
in turn: by a small step down and up (elasticity), to half and double, to other
names. --interactions varies the twelve that matter most, or those of --keys,
together. --assumptions varies the modelling assumptions of docs/model.md (A4)
by 50 % instead.";

/// The arguments of `sensitivity`.
#[derive(Debug, Clone, clap::Args)]
pub struct SensitivityArgs {
    /// Machine: a name of `arch list`, or a TOML file
    pub arch: String,
    /// Traces, as written by `extract`
    #[arg(required = true, value_name = "TRACE")]
    pub traces: Vec<PathBuf>,
    /// What is otherwise in the machine.
    #[command(flatten)]
    pub machine: MachineArgs,
    /// DRAM model, in place of the machine's [default: calibrated in place of banked]
    #[arg(long, value_enum, value_name = "MODEL")]
    pub dram_model: Option<DramModelArg>,
    /// Only these keys, `*` at the end is any rest; with --interactions also their
    /// values: KEY, KEY=LOW..HIGH, KEY=A|B|C
    #[arg(long, value_name = "KEYS", value_delimiter = ',', value_parser = selection)]
    pub keys: Vec<(String, KeySelection)>,
    /// Relative step of elasticities; where it gives an invalid machine, the next larger one
    #[arg(long, value_name = "SHARE", default_value = "0.1", value_parser = step)]
    pub step: f64,
    /// What of the traces is simulated.
    #[command(flatten)]
    pub shown: TraceArgs,
    /// Vary keys together: which interact, and how much
    #[arg(long, value_enum, value_name = "METHOD")]
    pub interactions: Option<MethodArg>,
    /// Trajectories of morris [default: 20], rows of sobol [default: 128]
    #[arg(long, value_name = "N", requires = "interactions")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub samples: Option<u32>,
    /// Seed of the sample of --interactions
    #[arg(long, value_name = "SEED", default_value = "1")]
    pub seed: u64,
    /// Vary the modelling assumptions of docs/model.md instead of keys
    #[arg(long, conflicts_with_all = ["keys", "interactions"])]
    pub assumptions: bool,
    /// Only these assumptions: A4,A27
    #[arg(long, value_name = "NUMBERS", requires = "assumptions")]
    #[arg(value_delimiter = ',', value_parser = number)]
    pub only: Vec<u32>,
    /// Also write the main table as CSV to this file
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArgs,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
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

/// An item of `--keys`, and as it was typed.
fn selection(text: &str) -> Result<(String, KeySelection), String> {
    Ok((text.to_owned(), text.parse()?))
}

/// How keys are perturbed together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MethodArg {
    /// Elementary effects: cheap, says which keys matter and which act alone
    Morris,
    /// Shares of the variance, alone and with others, with intervals
    Sobol,
}

impl SensitivityArgs {
    fn interaction_study(&self) -> Option<InteractionStudy> {
        let method = match self.interactions? {
            MethodArg::Morris => Method::Morris,
            MethodArg::Sobol => Method::Sobol,
        };
        let samples = self.samples.map(|n| n as usize);
        Some(InteractionStudy { method, samples, seed: self.seed })
    }
}

/// What traces are called.
const TRACE_END: &str = "bin";

impl SensitivityArgs {
    /// Refuses a key behind `--keys KEY` that is given alone, and would be a trace.
    fn no_stray_key(&self) -> Result<(), Failure> {
        let is_key =
            |path: &&PathBuf| !path.exists() && path.extension().is_none_or(|end| end != TRACE_END);
        let stray = self.traces.iter().find(is_key).filter(|_| !self.keys.is_empty());
        let Some(stray) = stray.map(|path| path.display()) else { return Ok(()) };
        let typed: Vec<&str> = self.keys.iter().map(|(typed, _)| typed.as_str()).collect();
        let what = format!(
            "{stray}: no such trace; if it is a key, give all of them in one list: --keys \
             '{},{stray}'",
            typed.join(",")
        );
        Err(Failure::new(Exit::BadInput, what))
    }
}

/// What came out.
enum SensitivityResults {
    Assumptions(Sensitivity),
    Keys(KeyResults),
}

/// Runs the command.
pub fn run(args: &SensitivityArgs, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    if let Some((typed, _)) = args.keys.iter().find(|(_, key)| key.has_values())
        && args.interactions.is_none()
    {
        let what = format!(
            "--keys {typed}: values are for --interactions; add that, or name the key alone"
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    args.no_stray_key()?;
    args.csv.iter().try_for_each(|path| output_file::check(path, args.report.force))?;
    if inputs::is_trace(Path::new(&args.arch)) {
        let what = format!("{}: the machine goes first, the traces after it", args.arch);
        return Err(Failure::new(Exit::Usage, what));
    }
    let mut sets = args.machine.changes.sets.clone();
    sets.extend(DramModelArg::set(args.dram_model));
    let system = inputs::system(&args.arch, &sets, args.machine.energy.as_deref())?;
    let (system, is_calibrated) = dram_model::for_many(system, args.dram_model)?;
    if is_calibrated && !context.global.quiet {
        out::complain(dram_model::NOTE);
    }
    let open = |path: &PathBuf| inputs::trace(path, args.shown.only.frames, context);
    let mut sources: Vec<TraceFile> = args.traces.iter().map(open).collect::<Result<_, _>>()?;
    let folder = args.report.folder(&format!("sensitivity-{}", system.machine().name))?;
    let watch = WatchedProgress::new(context, ProgressCounts::Simulations);
    let found = if args.assumptions {
        let display_fps = args.shown.fps;
        let study = AssumptionStudy { system: &system, only: &args.only, display_fps };
        study.run(&mut sources, &watch)?.map(SensitivityResults::Assumptions)
    } else {
        let keys: Vec<KeySelection> = args.keys.iter().map(|(_, key)| key.clone()).collect();
        let study = KeyStudy {
            system: &system,
            keys: &keys,
            step: args.step,
            display_fps: args.shown.fps,
            interactions: args.interaction_study(),
        };
        study.run(&mut sources, &watch)?.map(SensitivityResults::Keys)
    };
    drop(watch);
    let Some(found) = found else {
        out::complain("interrupted before the first frame was done: no report");
        return Ok(Exit::Interrupted);
    };
    if let SensitivityResults::Keys(KeyResults { interactions: None, .. }) = &found
        && args.interactions.is_some()
    {
        out::complain("interrupted: the report is without interactions");
    }
    let table = output::write(&folder, &found, &context.drawing)?;
    if let Some(path) = &args.csv {
        write_atomically(path, |w| w.write_all(&table))?;
    }
    folder.write("run.toml", output::record(args, &system, &sources)?.as_bytes())?;
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?.join("summary.md");
    if context.global.json {
        out::json(&output::json(&found))?;
    } else if !context.global.quiet {
        out::document(&output::document(&found, &path.display().to_string()))?;
    }
    Ok(if context.is_cancelled() { Exit::Interrupted } else { Exit::Done })
}
