//! `compare`: machines on one trace beside each other, or finished reports.

mod workloads;

pub use workloads::names as workload_names;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::chart_args::ChartArgs;
use super::inputs::{DISPLAY_FPS, SetArgs, TraceArgs};
use super::invocation::Started;
use super::progress::{ProgressCounts, WatchedProgress};
use super::replay::DEFAULT_DISPLAY;
use super::run_folder::{ReportArgs, RunFolder};
use super::{Context, Exit, Failure, OrExit, inputs, out};
use clap::ValueEnum;
use powergs_base::config::embedded::{MACHINES, find};
use powergs_base::config::knob;
use powergs_base::quantity::Watts;
use powergs_chart::Chart;
use powergs_core::run::files::DiskFiles;
use powergs_core::run::{Change, System, SystemSpec, TraceFile};
use powergs_report::compare::Decided;
use powergs_report::document::Table;
use powergs_report::{Drawing, compare, speedup};
use powergs_study::ablation::ablations;
use powergs_study::common::{KeptMemory, one_memory};
use powergs_study::findings::compare::{Across, AskedLimits, Comparison, Decision, Side};
use powergs_study::findings::limits::{Bias, Effect, left_out_by};
use powergs_study::replay::on_each;
use powergs_study::speedup::SpeedUp;
use powergs_study::sweep::expr::Expr;

/// Shown under `compare --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim compare gscore edge traces/demo.bin
  powergs-sim compare gscore mine.toml scene.bin --set energy=gscore-28nm-flat
  powergs-sim compare reports/monday reports/today --json
  powergs-sim compare gscore mine.toml scene.bin --at-least 0.95 || echo slower
  powergs-sim compare gscore mine.toml room.bin truck.bin snow.bin
  powergs-sim compare gscore mine.toml --workloads lego,train,garden
  powergs-sim compare gscore --all-machines --workloads standard
  powergs-sim compare gscore gcc room.bin --fps 90 --budget 1.2W --latency 20ms
  powergs-sim compare gsarch vorion-train orin-nx-train fox.bin
  powergs-sim compare gscore gcc vorion room.bin --common
  powergs-sim compare neo path.bin --ablate
  powergs-sim compare gscore room.bin --ablate geometry.test=aabb --table tex

The first machine (or report) is what the others are compared with.";

/// The largest `run.toml` or `results.csv` that is read.
const RECORD_MAX: u64 = 1 << 28;

/// The arguments of `compare`.
#[derive(Debug, Clone, clap::Args)]
pub struct CompareCommandArgs {
    /// Two or more machines (names of `arch list`, or TOML files), then a trace, or several
    /// for speed-ups with their geometric mean; or two or more report folders
    #[arg(required_unless_present = "all_machines", num_args = 1.., value_name = "ITEM")]
    pub items: Vec<PathBuf>,
    /// In place of traces: workloads of `validate`, comma-separated; `standard` are the scenes at
    /// the size of their captures, `all` those of single views. Scenes are generated
    #[arg(long, value_name = "NAMES", value_delimiter = ',', conflicts_with = "frames")]
    pub workloads: Vec<String>,
    /// With --workloads: the other machines that come with the program too; those that a workload
    /// is not for are left out, and named
    #[arg(long, requires = "workloads")]
    pub all_machines: bool,
    /// What is otherwise in the machines.
    #[command(flatten)]
    pub changes: SetArgs,
    /// What of the traces is simulated.
    #[command(flatten)]
    pub shown: TraceArgs,
    /// Who draws more at the display rate does not meet what is asked for; a line at this
    /// power in the charts: 1.5W, 800mW
    #[arg(long, value_name = "POWER", value_parser = watts)]
    pub budget: Option<Watts>,
    /// Nor does one for which this does not hold: 'area_mm2.total <= 4 && dram.busy_frac.max < 0.9'
    /// (`docs/results.md` has the names)
    #[arg(long = "where", value_name = "CONDITION")]
    pub condition: Option<Expr>,
    /// Put areas, energies and powers of different technology nodes into ratios, and energies
    /// and powers of blocks and of whole modules
    #[arg(long)]
    pub across_nodes: bool,
    /// Give all machines the memory of the first: device, channels, model, second master, price,
    /// PHY; those that cannot have it are named
    #[arg(long)]
    pub common: bool,
    /// Put times and energies of rendering, training and tracking into ratios
    #[arg(long)]
    pub across_tasks: bool,
    /// Exit with code 1 if any other side has less than RATIO times the frame rate of
    /// the first
    #[arg(long, value_name = "RATIO", value_parser = ratio)]
    pub at_least: Option<f64>,
    /// Print tables for a paper in place of the page: who meets what, and speed-ups over several
    /// traces
    #[arg(long, value_enum, value_name = "FORMAT", conflicts_with = "json")]
    pub table: Option<TableFormat>,
    /// One machine: also without each of its optional parts in turn, or with KEY=VALUE where
    /// that is given (several times)
    #[arg(long, value_name = "KEY=VALUE", num_args = 0..=1, default_missing_value = "")]
    pub ablate: Vec<String>,
    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArgs,
    /// Display: a preset of `arch-configs/display`, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_DISPLAY)]
    pub display: String,
    /// Only these charts
    #[arg(long = "charts", value_enum, value_name = "CHARTS", value_delimiter = ',')]
    #[arg(help_heading = "Charts", hide_short_help = true)]
    pub only_charts: Vec<CompareChart>,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
}

/// Charts of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum CompareChart {
    /// Slowest frames and powers, with the lines of what is asked for
    Decision,
    /// Power at the display rate by component, of one trace
    Power,
    /// Where the cycles go, of one trace
    Cycles,
    /// Energy per frame by component, over several traces
    Breakdown,
    /// Speed-ups and energy gains over several traces
    Speedup,
    /// Where a step of training goes
    Steps,
}

impl CompareChart {
    /// Those of `charts` that are asked for.
    ///
    /// # Errors
    /// Exit code 2: none of these comes of what is compared.
    fn of(asked: &[CompareChart], mut charts: Vec<Chart>) -> Result<Vec<Chart>, Failure> {
        let has_name = |chart: &Chart, asked: &CompareChart| {
            asked.to_possible_value().is_some_and(|value| value.get_name() == chart.name)
        };
        let made: Vec<&str> = charts.iter().map(|chart| chart.name).collect();
        if let Some(missing) = asked.iter().find(|asked| !charts.iter().any(|c| has_name(c, asked)))
        {
            let name = missing.to_possible_value();
            let name = name.as_ref().map_or("", |value| value.get_name());
            let what = format!("--charts {name}: what is compared has {}", made.join(", "));
            return Err(Failure::new(Exit::Usage, what));
        }
        charts.retain(|chart| asked.is_empty() || asked.iter().any(|asked| has_name(chart, asked)));
        Ok(charts)
    }
}

/// How tables for papers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum TableFormat {
    /// LaTeX, with the package `booktabs`.
    Tex,
    /// Comma-separated, exact.
    Csv,
    /// Markdown.
    Md,
}

impl TableFormat {
    fn write(self, table: &Table) -> String {
        match self {
            TableFormat::Tex => table.latex(),
            TableFormat::Csv => String::from_utf8_lossy(&table.csv()).into_owned(),
            TableFormat::Md => table.markdown(),
        }
    }

    /// What a table is not to be read without, as comments where there are some.
    fn caveats(self, lines: &[String]) -> String {
        match self {
            TableFormat::Tex => lines.iter().map(|line| format!("% {line}\n")).collect(),
            TableFormat::Md => lines.iter().map(|line| format!("\n- {line}\n")).collect(),
            TableFormat::Csv => String::new(),
        }
    }
}

/// A power with its unit, above zero: `1.5W`.
pub fn watts(text: &str) -> Result<Watts, String> {
    let watts: Watts = text.parse().map_err(|e| format!("{e}"))?;
    if watts.0 > 0.0 { Ok(watts) } else { Err("must be above zero".into()) }
}

fn ratio(text: &str) -> Result<f64, String> {
    let ratio: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if ratio > 0.0 && ratio.is_finite() { Ok(ratio) } else { Err("must be above zero".into()) }
}

/// Runs the command.
pub fn run(args: &CompareCommandArgs, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    // What is given is looked at before anything is simulated.
    let given = args.report.out.is_some().then(|| args.report.folder("")).transpose()?;
    let folders = args.items.iter().filter(|p| p.is_dir()).count();
    let traces = if !args.workloads.is_empty() {
        on_workloads(args, context)?
    } else if folders == args.items.len() {
        vec![of_folders(args)?]
    } else if folders > 0
        && let Some(missing) = args.items.iter().find(|p| is_missing_folder(p))
    {
        return Err(Failure::new(
            Exit::Usage,
            format!("{}: there is no such report folder", missing.display()),
        ));
    } else if folders > 0 {
        let what = "report folders cannot be compared with machines: replay the trace on the \
                    machines, or give folders only";
        return Err(Failure::new(Exit::Usage, what));
    } else {
        simulated(args, context)?
    };
    let across = Across { nodes: args.across_nodes, tasks: args.across_tasks };
    let all: Vec<Comparison> =
        traces.into_iter().map(|sides| Comparison::new(sides, across)).collect();
    let Some(comparison) = all.first() else {
        out::complain("interrupted before the first frame was done: no report");
        return Ok(Exit::Interrupted);
    };
    let limits = AskedLimits {
        budget_w: args.budget.map(|watts| watts.0),
        latency_ms: args.shown.latency_ms(),
        condition: args.condition.clone(),
    };
    let decision = Decision::of(&all, &limits).or_exit(Exit::Usage, "--where")?;
    let decided = Decided { decision: &decision, limits: &limits };
    let speedup = SpeedUp::of_comparisons(&all);
    let labels = comparison.labels();
    let folder = match given {
        Some(folder) => folder,
        None => match &labels[..] {
            [first, others @ ..] if others.len() > 3 => {
                args.report.folder(&format!("{first}-and-{}-machines", others.len()))?
            }
            labels => args.report.folder(&labels.join("-"))?,
        },
    };
    match &speedup {
        Some(speedup) => {
            let charts =
                CompareChart::of(&args.only_charts, charts_of_all(&all, decided, speedup))?;
            write_all(&folder, &all, decided, speedup, &charts, &context.drawing)?;
        }
        None => {
            let charts = CompareChart::of(&args.only_charts, charts_of(comparison, decided))?;
            write(&folder, comparison, decided, &charts, &context.drawing)?;
        }
    }
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?.join("summary.md");
    if context.global.json {
        out::json(&compare::json_of(&all, &decision, speedup.as_ref()))?;
    } else if let Some(format) = args.table {
        let one = std::slice::from_ref(&comparison.sides[0].trace);
        let traces = speedup.as_ref().map_or(one, |speedup| &speedup.traces);
        let table = compare::decision_table(&all, &decision, traces);
        let means = speedup.as_ref().map(speedup::means_table);
        let tables = [Some(table), means].into_iter().flatten();
        let tables: Vec<String> = tables.map(|table| format.write(&table)).collect();
        out::text(&(tables.join("\n") + &format.caveats(&compare::caveats(comparison))))?;
    } else if !context.global.quiet {
        let path = path.display().to_string();
        let page = match &speedup {
            Some(speedup) => compare::document_of(&all, decided, speedup, &[], Some(&path)),
            None => compare::document(comparison, decided, &[], Some(&path)),
        };
        out::document(&page)?;
    }
    if context.is_cancelled() {
        return Ok(Exit::Interrupted);
    }
    all.iter().map(|comparison| goal(args, comparison)).try_fold(Exit::Done, |worst, exit| {
        let exit = exit?;
        Ok(if exit == Exit::Done { worst } else { exit })
    })
}

/// Something that is not there, and is called as folders are.
fn is_missing_folder(path: &Path) -> bool {
    let name = path.to_string_lossy();
    !path.exists() && path.extension().is_none() && find(MACHINES, &name).is_none()
}

/// Whether the others are fast enough.
fn goal(args: &CompareCommandArgs, comparison: &Comparison) -> Result<Exit, Failure> {
    let Some(wanted) = args.at_least else { return Ok(Exit::Done) };
    let Some(least) = comparison.least_speedup() else {
        let what = match comparison.task() {
            Some(_) => "--at-least: one of the sides has no frame time",
            None => {
                "--at-least: the sides do different things, so that they have no ratio: \
                     compare machines of one task, or take ratios --across-tasks"
            }
        };
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

/// The charts of machines on one trace.
fn charts_of(comparison: &Comparison, decided: Decided<'_>) -> Vec<Chart> {
    let (one, trace) = (std::slice::from_ref(comparison), &comparison.sides[0].trace);
    let decision = compare::decision_chart(one, decided, std::slice::from_ref(trace));
    let own = compare::charts(comparison, decided.limits.budget_w);
    [decision].into_iter().chain(own).collect()
}

/// The charts of machines on several traces.
fn charts_of_all(all: &[Comparison], decided: Decided<'_>, speedup: &SpeedUp) -> Vec<Chart> {
    let frames = all.iter().map(|c| c.sides[0].frames).sum::<u64>();
    let frames = all[0].sides[0].shown.counted(frames);
    let chart = speedup::chart(speedup, format!("{} traces, {frames}", all.len()));
    let decision = compare::decision_chart(all, decided, &speedup.traces);
    let mut charts = vec![decision, chart, compare::breakdown(all, &speedup.traces)];
    charts.extend(compare::steps_chart(all, &speedup.traces));
    charts
}

fn write(
    folder: &RunFolder,
    comparison: &Comparison,
    decided: Decided<'_>,
    charts: &[Chart],
    drawing: &Drawing,
) -> Result<(), Failure> {
    let record = compare::run_toml(comparison).or_exit(Exit::Internal, "run.toml")?;
    folder.write("run.toml", record.as_bytes())?;
    folder.write("compare.csv", &compare::compare_csv(comparison))?;
    let (one, trace) = (std::slice::from_ref(comparison), &comparison.sides[0].trace);
    let table = compare::decision_csv(one, decided.decision, std::slice::from_ref(trace));
    folder.write("decision.csv", &table)?;
    folder.write_pages(&compare::document(comparison, decided, charts, None), drawing)?;
    folder.write_charts(charts, drawing)
}

/// The files of machines on several traces.
fn write_all(
    folder: &RunFolder,
    all: &[Comparison],
    decided: Decided<'_>,
    speedup: &SpeedUp,
    charts: &[Chart],
    drawing: &Drawing,
) -> Result<(), Failure> {
    let record = compare::run_toml_of(all).or_exit(Exit::Internal, "run.toml")?;
    folder.write("run.toml", record.as_bytes())?;
    folder.write("speedup.csv", &speedup::csv(speedup))?;
    folder.write("compare.csv", &compare::compare_csv_of(all, &speedup.traces))?;
    let table = compare::decision_csv(all, decided.decision, &speedup.traces);
    folder.write("decision.csv", &table)?;
    folder.write_pages(&compare::document_of(all, decided, speedup, charts, None), drawing)?;
    folder.write_charts(charts, drawing)
}

/// Finished reports.
fn of_folders(args: &CompareCommandArgs) -> Result<Vec<Side>, Failure> {
    let has_rate = args.shown.fps != DISPLAY_FPS;
    if !args.changes.sets.is_empty() || args.shown.only.frames.is_some() || has_rate {
        let what = "--set, --frames, --fps: finished reports are not simulated again";
        return Err(Failure::new(Exit::Usage, what));
    }
    if args.common || !args.ablate.is_empty() {
        let what = "--common, --ablate: finished reports are not simulated again; give machines \
                    and a trace";
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

/// Simulates standard workloads on every machine, a list of sides a workload.
fn on_workloads(args: &CompareCommandArgs, context: &Context) -> Result<Vec<Vec<Side>>, Failure> {
    if let Some(trace) = args.items.iter().find(|path| inputs::is_trace(path)) {
        let what =
            format!("{}: is a trace; with --workloads all items are machines", trace.display());
        return Err(Failure::new(Exit::Usage, what));
    }
    let chosen = workloads::chosen(&args.workloads)?;
    let machines = workloads::machines(&args.items, args.all_machines);
    let mut systems = loaded(args, &machines)?;
    if args.all_machines {
        systems = workloads::fitting(systems, &chosen, args.items.len())?;
    }
    if systems.len() < 2 {
        let what = "one machine only that these workloads are for: name two, or add --all-machines";
        return Err(Failure::new(Exit::Usage, what));
    }
    if !context.global.quiet {
        workloads::note_paths(&systems, &chosen);
    }
    workloads::simulated(args, &systems, &chosen, context)
}

fn loaded(args: &CompareCommandArgs, machines: &[PathBuf]) -> Result<Vec<System>, Failure> {
    let load = |arch: &PathBuf| {
        let spec = SystemSpec {
            machine: arch.to_string_lossy().into_owned(),
            sets: args.changes.sets.clone(),
            energy: None,
            display: Some(args.display.clone()),
        };
        inputs::loaded(&spec)
    };
    let mut systems = machines.iter().map(load).collect::<Result<Vec<System>, _>>()?;
    if !args.ablate.is_empty() {
        if systems.len() > 1 {
            let what = "--ablate: takes parts out of one machine; name one only";
            return Err(Failure::new(Exit::Usage, what));
        }
        let variants = ablated(&systems[0], &args.ablate)?;
        systems.extend(variants);
    }
    if !args.common {
        return Ok(systems);
    }
    let (systems, kept) = one_memory(systems, &DiskFiles)?;
    for KeptMemory { machine, why } in kept {
        out::complain(format_args!("note: {machine} keeps its own memory: {why}"));
    }
    Ok(systems)
}

/// A machine without each of its mechanisms, or with what is said in their place.
///
/// # Errors
/// Exit code 2: there is nothing that it could be without, or it cannot be so.
fn ablated(system: &System, asked: &[String]) -> Result<Vec<System>, Failure> {
    let changes: Result<Vec<Change>, String> =
        asked.iter().filter(|text| !text.is_empty()).map(|text| text.parse()).collect();
    let mut changes =
        changes.map_err(|why| Failure::new(Exit::Usage, format!("--ablate: {why}")))?;
    if changes.is_empty() {
        changes = ablations(system.machine());
        if changes.is_empty() {
            let what = "--ablate: the machine has no part that it may be without; say what to \
                        change, e.g. --ablate geometry.test=aabb";
            return Err(Failure::new(Exit::Usage, what));
        }
    }
    let is_named = asked.iter().any(|text| !text.is_empty());
    let task = |system: &System| system.machine().flow().task(system.machine());
    let mut variants = Vec::new();
    for change in &changes {
        let name = format!("{}-{}", system.label(), words(change));
        let name = Change::machine("name", name);
        match system.with(&[change.clone(), name]) {
            Ok(variant) if !is_named && !is_less(&variant, system) => out::complain(format_args!(
                "note: {} stays with its `{}`: without it the work is left out and not done \
                 otherwise; --ablate {change} asks for it",
                system.label(),
                change.path
            )),
            // A machine that does something else is no part less.
            Ok(variant) if is_named || task(&variant) == task(system) => variants.push(variant),
            Ok(_) => {}
            Err(e) if is_named => {
                let what = format!("--ablate {change}: {} cannot do without: {e}", system.label());
                return Err(Failure::new(Exit::Usage, what));
            }
            Err(e) => out::complain(format_args!(
                "note: {} stays with its `{}`: {e}",
                system.label(),
                change.path
            )),
        }
    }
    if variants.is_empty() {
        let what = "--ablate: without any of its parts the machine does something else, or \
                    nothing; say what to change, e.g. --ablate geometry.test=aabb";
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(variants)
}

/// Whether a variant leaves nothing out that its machine does: what is for nothing is no other way.
fn is_less(variant: &System, system: &System) -> bool {
    let own = left_out_by(system.machine());
    let is_known = |effect: &Effect| own.iter().any(|known| known.what == effect.what);
    left_out_by(variant.machine())
        .iter()
        .all(|effect| effect.bias != Bias::Optimistic || is_known(effect))
}

/// What a variant is called after: `pixels.impl-all`.
fn words(change: &Change) -> String {
    let text = format!("{}-{}", change.path, knob::shown(&change.value));
    let is_name = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    text.chars().map(|c| if is_name(c) { c } else { '-' }).collect()
}

/// Machines and traces among the items: traces stand last.
fn parted(items: &[PathBuf]) -> (&[PathBuf], &[PathBuf]) {
    let traces = items.iter().rev().take_while(|path| inputs::is_trace(path)).count();
    // What is no trace is said when it is opened as one.
    items.split_at(items.len() - traces.max(1))
}

/// Simulates every trace on every machine, a list of sides a trace; without traces of which not
/// even one frame was done.
fn simulated(args: &CompareCommandArgs, context: &Context) -> Result<Vec<Vec<Side>>, Failure> {
    let (machines, traces) = parted(&args.items);
    let usage = "compare MACHINE MACHINE... TRACE..., or two report folders";
    if let Some(trace) = machines.iter().find(|path| inputs::is_trace(path)) {
        let what = format!("{}: is a trace; traces go last: {usage}", trace.display());
        return Err(Failure::new(Exit::Usage, what));
    }
    if let [machine] = machines
        && args.ablate.is_empty()
    {
        let only = match traces {
            [no_file] if !no_file.exists() => {
                format!("no trace: {} is not a file", no_file.display())
            }
            _ => format!("{}: one machine only", machine.display()),
        };
        return Err(Failure::new(Exit::Usage, format!("{only}; {usage}")));
    }
    if let ([], [machine]) = (machines, traces)
        && !inputs::is_trace(machine)
    {
        let what = format!("{}: one machine only; {usage}", machine.display());
        return Err(Failure::new(Exit::Usage, what));
    }
    if machines.is_empty() {
        return Err(Failure::new(Exit::Usage, format!("no machine; {usage}")));
    }
    let mut sources: Vec<TraceFile> = traces
        .iter()
        .map(|path| inputs::trace(path, args.shown.only.frames, context))
        .collect::<Result<_, _>>()?;
    let systems = loaded(args, machines)?;
    let watch = WatchedProgress::new(context, ProgressCounts::Frames);
    let mut all = Vec::new();
    for source in &mut sources {
        let runs = on_each(&systems, args.shown.fps, source, None, &watch)?;
        let sides: Option<Vec<Side>> = runs.iter().map(Side::of_run).collect();
        all.extend(sides);
    }
    Ok(all)
}
