//! `replay`: a trace on a machine gives a summary and a report folder.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::chart_args::ChartArgs;
use super::inputs::DISPLAY_FPS;
use super::inputs::{MachineArgs, TraceArgs};
use super::invocation::Started;
use super::progress::{ProgressCounts, WatchedProgress};
use super::run_folder::{ReportArgs, RunFolder};
use super::timeline::{self, TimelineRequest};
use super::{Context, Exit, Failure, OrExit, inputs, out, output_file, sight};
use powergs_base::shell;
use powergs_core::flow::{Task, TaskKind};
use powergs_core::run::files::DiskFiles;
use powergs_core::run::session::Target;
use powergs_core::run::store::atomic::write_atomically;
use powergs_core::run::{Frames, PaperModel, Session, System, SystemSpec, TraceFile};
use powergs_core::workload::Geometry;
use powergs_core::workload::paper::Padding;
use powergs_report as report;
use powergs_study::findings::what_if::Advice;
use powergs_study::replay::Replay;
use powergs_study::run_record::{Facts, Run};

/// Shown under `replay --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim replay traces/demo.bin
  powergs-sim replay scene.bin --set vru.cores=8 --out reports/eight
  powergs-sim replay scene.bin --frames 0..24 --fps 72 --json
  powergs-sim replay scene.bin --energy gscore-7nm
  powergs-sim replay scene.bin --dram-model both --what-if 0
  powergs-sim replay scene.bin --timeline 3:100..140 --out reports/look
  powergs-sim replay scene.bin --model paper

docs/results.md defines every number, as does `powergs-sim explain NAME`.";

/// The machine that is used if none is named.
pub const DEFAULT_ARCH: &str = "gscore";

/// The display that is used if none is named.
pub const DEFAULT_DISPLAY: &str = "oled-powergs";

/// The arguments of `replay`.
#[derive(Debug, Clone, clap::Args)]
pub struct ReplayArgs {
    /// The trace, as written by `extract`
    pub trace: PathBuf,
    /// Machine: a name of `arch list`, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_ARCH)]
    pub arch: String,
    /// What is otherwise in the machine.
    #[command(flatten)]
    pub machine: MachineArgs,
    /// Model: the simulated machine, or the published closed-form counts
    #[arg(long, value_enum, default_value = "cycle")]
    pub model: ModelArg,
    /// What of the trace is simulated.
    #[command(flatten)]
    pub shown: TraceArgs,
    /// Display: a preset of `arch-configs/display`, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_DISPLAY)]
    pub display: String,
    /// `paper` model: pad odd image sizes as the published code does
    #[arg(long)]
    pub reference_padding: bool,
    /// DRAM model, in place of the machine's; both: banked, and its difference to
    /// calibrated
    #[arg(long, value_enum, value_name = "MODEL")]
    pub dram_model: Option<DramArg>,
    /// Frames, spread over the trace, on which doubling each resource is tried; 0:
    /// none
    #[arg(long, value_name = "N", default_value = "3")]
    pub what_if: usize,
    /// What every unit did in a frame, as a picture (of the tiles A to B, or of all of
    /// it) and as trace.json.gz for ui.perfetto.dev
    #[arg(long, value_name = "FRAME[:A..B]", value_parser = timeline::asked)]
    pub timeline: Option<timeline::TimelineRequest>,
    /// Write the DRAM requests of the first frame to a file, one a line: R 0x1f40 64
    #[arg(long, value_name = "FILE")]
    pub dump_dram: Option<PathBuf>,
    /// Where the report goes.
    #[command(flatten)]
    pub report: ReportArgs,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
}

/// The models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ModelArg {
    /// Closed-form counts of the published PowerGS model; has no time.
    Paper,
    /// The simulated machine.
    Cycle,
}

/// The DRAM models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum DramArg {
    /// One server with a latency and a rate.
    Bandwidth,
    /// One server with rates and latencies as a banked run of the frame has them.
    Calibrated,
    /// The device, with its banks, rows, queues and timings.
    Banked,
    /// `banked`, and what `calibrated` makes of the same frames.
    Both,
}

impl DramArg {
    /// The value of `dram.model`.
    pub const fn key(self) -> &'static str {
        match self {
            DramArg::Bandwidth => "bandwidth",
            DramArg::Calibrated => "calibrated",
            DramArg::Banked | DramArg::Both => "banked",
        }
    }
}

/// A rate from 1 to 1000 frames per second.
pub fn display_rate(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (1.0..=1000.0).contains(&rate) { Ok(rate) } else { Err("must be 1 to 1000".into()) }
}

/// The models of a replay.
#[derive(Debug)]
enum Model {
    Cycle(Box<System>),
    Paper(Box<PaperModel>),
}

impl Model {
    fn target(&self) -> Target<'_> {
        match self {
            Model::Cycle(system) => Target::System(system),
            Model::Paper(model) => Target::Paper(model),
        }
    }

    /// Width and height of the tiles of an image.
    fn tile(&self, image: [u32; 2]) -> [u32; 2] {
        match self {
            Model::Cycle(system) => {
                let machine = system.machine();
                machine.flow().tile(machine, image)
            }
            Model::Paper(_) => [Geometry::REFERENCE.tile; 2],
        }
    }
}

/// The machine or the published model, with the display.
fn model(args: &ReplayArgs) -> Result<Model, Failure> {
    let display = Some(args.display.clone());
    if args.model == ModelArg::Cycle {
        if args.reference_padding {
            let what = "--reference-padding belongs to --model paper";
            return Err(Failure::new(Exit::Usage, what));
        }
        let mut sets = args.machine.changes.sets.clone();
        if let Some(model) = args.dram_model {
            sets.push(format!("dram.model={}", model.key()));
        }
        let (machine, energy) = (args.arch.clone(), args.machine.energy.clone());
        let spec = SystemSpec { machine, sets, energy, display };
        return Ok(Model::Cycle(Box::new(inputs::loaded(&spec)?)));
    }
    if args.arch != DEFAULT_ARCH {
        let what = "--arch: the paper model has no machine; use --model cycle, or leave it out";
        return Err(Failure::new(Exit::Usage, what));
    }
    let machine_only = args.dram_model.is_some() || args.timeline.is_some();
    if !args.machine.changes.sets.is_empty() || machine_only || args.machine.energy.is_some() {
        let what = "--set, --energy, --dram-model, --timeline: the paper model has no machine; \
                    use --model cycle";
        return Err(Failure::new(Exit::Usage, what));
    }
    let padding = if args.reference_padding { Padding::Reference } else { Padding::TrueTiles };
    let model = PaperModel::new(padding)?.with_display(&args.display, &DiskFiles)?;
    Ok(Model::Paper(Box::new(model)))
}

/// Writes the DRAM requests of the first frame; the file appears whole or not at all.
fn dump_dram(path: &Path, trace: &mut TraceFile, model: &Model) -> Result<(), Failure> {
    let first = trace.range().start;
    let Model::Cycle(system) = model else {
        let what = "--dump-dram: the paper model makes no requests; use --model cycle";
        return Err(Failure::new(Exit::Usage, what));
    };
    let frame = Session::new(trace, &()).frame_on(system, first)?;
    Ok(write_atomically(path, |out| frame.write_dram_requests(out).map(drop))?)
}

/// Runs the command.
pub fn run(args: &ReplayArgs, context: &Context) -> Result<Exit, Failure> {
    args.dump_dram.iter().try_for_each(|path| output_file::check(path, args.report.force))?;
    let model = model(args)?;
    let mut trace = inputs::trace(&args.trace, args.shown.only.frames, context)?;
    let replay = Replay {
        target: model.target(),
        display_fps: args.shown.fps,
        latency_ms: args.shown.latency_ms(),
        what_if_frames: args.what_if,
        calibrates_what_if: args.dram_model.is_none(),
        compares_models: args.dram_model == Some(DramArg::Both),
    };
    let facts = replay.facts(&mut trace)?;
    if let Some(asked) = &args.timeline {
        let shown = facts.trace.shown;
        let [width, height] = model.tile([shown.width, shown.height]);
        let tiles = shown.width.div_ceil(width) * shown.height.div_ceil(height);
        asked.check(trace.range(), tiles)?;
    }
    let started = Started::now();
    if let Some(path) = &args.dump_dram {
        dump_dram(path, &mut trace, &model)?;
    }
    let folder = folder(args, &facts)?;
    let run = replay.run(&mut trace, &WatchedProgress::new(context, ProgressCounts::Frames))?;
    if let Some(first) = run.frames.first() {
        let seen = run.frames.iter().map(|frame| frame.counters.intersecting_points).max();
        sight::warn(seen.unwrap_or(0), first.counters.points, context);
    }
    let mut timeline = |folder: &RunFolder, asked: &TimelineRequest| match &model {
        Model::Cycle(system) => {
            let frame = Session::new(&mut trace, &()).frame_on(system, asked.frame)?;
            let name = args.trace.file_stem().unwrap_or_default().to_string_lossy();
            timeline::write(folder, asked, &name, &frame, &context.drawing)
        }
        Model::Paper(_) => Ok(None),
    };
    publish(args, context, &started, folder, &run, &mut timeline)
}

/// The report folder, refused before any work if it is finished.
///
/// # Errors
/// Exit code 2.
pub fn folder(args: &ReplayArgs, facts: &Facts) -> Result<RunFolder, Failure> {
    let name = format!("{}-{}", facts.trace.name, facts.machine.name);
    args.report.folder(&name)
}

/// Writes a timeline into a folder; returns what the user should know.
pub type WriteTimeline<'a> =
    dyn FnMut(&RunFolder, &TimelineRequest) -> Result<Option<String>, Failure> + 'a;

/// Writes the report folder and prints the summary.
///
/// # Errors
/// Exit code 2: the folder cannot be written; 4: a defect.
pub fn publish(
    args: &ReplayArgs,
    context: &Context,
    started: &Started,
    folder: RunFolder,
    run: &Run,
    timeline: &mut WriteTimeline<'_>,
) -> Result<Exit, Failure> {
    if run.frames.is_empty() {
        out::complain("interrupted before the first frame was done: no report");
        return Ok(Exit::Interrupted);
    }
    for file in report::files(run, &context.drawing).or_exit(Exit::Internal, "report")? {
        folder.write(&file.name, &file.bytes)?;
    }
    let note = args.timeline.as_ref().map(|asked| timeline(&folder, asked)).transpose()?;
    if let Some(note) = note.flatten().filter(|_| !context.global.quiet) {
        out::complain(format_args!("note: {note}"));
    }
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?;
    print(args, context, run, &path)?;
    Ok(if run.incomplete() { Exit::Interrupted } else { Exit::Done })
}

fn print(args: &ReplayArgs, context: &Context, run: &Run, folder: &Path) -> Result<(), Failure> {
    if context.global.json {
        return out::json(&report::json::report(run));
    }
    if context.global.quiet {
        return Ok(());
    }
    let next = next_command(
        args,
        run.facts.machine.task,
        run.experiments.what_if.as_ref().map(|w| w.advice()),
    );
    let summary = folder.join("summary.md").display().to_string();
    out::document(&report::page::document(run, &[], &[("report", summary), ("next", next)]))
}

/// A machine that does the same, to compare one with; `None` where there is no other.
fn other_machine(arch: &str, task: Task) -> Option<&'static str> {
    let all = match task.kind {
        TaskKind::Render if task.one_in == 1 => ["gscore", "gcc"],
        TaskKind::Train(_) if task.one_in == 1 => ["orin-nx-train", "gsarch"],
        _ => return None,
    };
    all.into_iter().find(|other| *other != arch)
}

/// The same command with the step that is advised. Where none is, a sweep of the preset's units, or
/// a comparison with another machine.
fn next_command(args: &ReplayArgs, task: Task, advice: Option<Advice<'_>>) -> String {
    let step: &[String] = match advice {
        Some(Advice::Take(step) | Advice::Fastest(step)) => &step.sets,
        Some(Advice::AreaOnly(_) | Advice::Nothing) | None => &[],
    };
    let mut shown = Vec::new();
    let mut flag = |name: &str, value: String| shown.extend([name.to_owned(), value]);
    args.shown.only.frames.iter().for_each(|frames| flag("--frames", frames.to_string()));
    if args.shown.fps != DISPLAY_FPS {
        flag("--fps", args.shown.fps.to_string());
    }
    if args.display != DEFAULT_DISPLAY {
        flag("--display", args.display.clone());
    }
    let mut machine = Vec::new();
    let mut flag = |name: &str, value: String| machine.extend([name.to_owned(), value]);
    if args.arch != DEFAULT_ARCH {
        flag("--arch", args.arch.clone());
    }
    args.machine.changes.sets.iter().chain(step).for_each(|set| flag("--set", set.clone()));
    args.machine.energy.iter().for_each(|energy| flag("--energy", energy.clone()));
    if let Some(model) = args.dram_model.and_then(|model| model.to_possible_value()) {
        flag("--dram-model", model.get_name().to_owned());
    }
    let trace = args.trace.display().to_string();
    let words = if machine.is_empty() && matches!(advice, Some(Advice::AreaOnly(_))) {
        [words_of(&["sweep", "gscore-units", "--traces", &trace]), shown].concat()
    } else if args.model == ModelArg::Cycle && step.is_empty() {
        let other = other_machine(&args.arch, task);
        let is_changed = machine.iter().any(|word| word == "--set" || word == "--energy");
        match other.filter(|_| !is_changed && args.dram_model.is_none()) {
            Some(other) => [words_of(&["compare", &args.arch, other, &trace]), shown].concat(),
            None => words_of(&["arch", "check", &args.arch]),
        }
    } else {
        [words_of(&["replay", &trace]), machine, shown].concat()
    };
    let words = ["powergs-sim".to_owned()].into_iter().chain(words);
    continued(words.map(|word| shell::quoted(&word)))
}

fn words_of(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

/// Words of a command in lines that a shell takes for one, as wide as the terminal beside `next`.
fn continued(words: impl Iterator<Item = String>) -> String {
    let mut text = String::new();
    let mut column = 0;
    for word in words {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > 70 {
            text.push_str(" \\\n");
            column = 0;
        } else if column > 0 {
            text.push(' ');
            column += 1;
        }
        text.push_str(&word);
        column += length;
    }
    text
}
