//! `replay`: a trace on a machine gives a summary and a report folder.

use std::path::{Path, PathBuf};

use super::camera_file::{FrameRange, frame_range};
use super::invocation::Started;
use super::machine_facts::machine_facts;
use super::progress::{Counts, Watched};
use super::run_folder::RunFolder;
use super::timeline::{self, Asked};
use super::what_if::Experiment;
use super::{Context, Exit, Failure, OrExit, dram_dump, inputs, out};
use powergs_core::accel::DramCommands;
use powergs_core::accel::timeline::{Observer, Span};
use powergs_core::run::files::DiskFiles;
use powergs_core::run::frames::spread;
use powergs_core::run::{
    Change, FrameView, Frames, PaperModel, Session, Subject, System, SystemSpec, TraceFile,
};
use powergs_core::sim::{self, FrameReport, observed};
use powergs_core::workload::Geometry;
use powergs_core::workload::paper::Padding;
use powergs_report::{self as report, terminal};
use powergs_study::findings::what_if::Cost;
use powergs_study::findings::{Picture, TileLoad};
use powergs_study::run_record::{DramModels, Extras, Facts, MachineFacts, Run, TraceFacts};

/// Shown under `replay --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim replay traces/demo.bin
  powergs-sim replay scene.bin --arch gscore --set vru.cores=8 --out reports/eight
  powergs-sim replay scene.bin --frames 0..24 --fps 72 --json
  powergs-sim replay scene.bin --energy gscore-7nm
  powergs-sim replay scene.bin --dram-model both --what-if 0
  powergs-sim replay scene.bin --timeline 3:100..140 --out reports/look
  powergs-sim replay scene.bin --model paper

docs/results.md defines every number; so does: powergs-sim explain NAME";

/// The machine that is used if none is named.
pub const DEFAULT_ARCH: &str = "gscore";

/// The display that is used if none is named.
pub const DEFAULT_DISPLAY: &str = "oled-powergs";

/// The arguments of `replay`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The trace, as written by `extract`
    pub trace: PathBuf,
    /// Machine: a name of `arch list`, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_ARCH)]
    pub arch: String,
    /// Change a key of the machine file for this run; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// Energy table, in place of the machine's: a name of `arch list`, a TOML file, or an
    /// energy reference table of Accelergy (FILE.yaml)
    #[arg(long, value_name = "NAME|FILE")]
    pub energy: Option<String>,
    /// Model: the simulated machine, or the published closed-form counts
    #[arg(long, value_enum, default_value = "cycle")]
    pub model: ModelArg,
    /// Display rate, frames per second, for power and deadlines
    #[arg(long, value_name = "RATE", default_value = "60", value_parser = display_rate)]
    pub fps: f64,
    /// Only frames A to B, B excluded, counted from 0: 0..24, 10.., ..5
    #[arg(long, value_name = "A..B", value_parser = frame_range)]
    pub frames: Option<FrameRange>,
    /// Display: a preset of `arch-configs/display`, or a TOML file
    #[arg(long, value_name = "NAME|FILE", default_value = DEFAULT_DISPLAY)]
    pub display: String,
    /// `paper` model: pad odd image sizes as the published code does
    #[arg(long)]
    pub reference_padding: bool,
    /// DRAM model, in place of the machine's; both: banked, and its difference to
    /// window
    #[arg(long, value_enum, value_name = "MODEL")]
    pub dram_model: Option<DramArg>,
    /// Frames, spread over the trace, on which doubling each resource is tried; 0:
    /// none
    #[arg(long, value_name = "N", default_value = "3")]
    pub what_if: usize,
    /// What every unit did in a frame, as a picture (of the tiles A to B, or of all of
    /// it) and as trace.json.gz for ui.perfetto.dev
    #[arg(long, value_name = "FRAME[:A..B]", value_parser = timeline::asked)]
    pub timeline: Option<timeline::Asked>,
    /// Write the DRAM requests of the first frame to a file, one a line: R 0x1f40 64
    #[arg(long, value_name = "FILE")]
    pub dump_dram: Option<PathBuf>,
    /// Report folder [default: reports/TRACE-MACHINE, with a counter if it exists]
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the finished report in --out
    #[arg(long)]
    pub force: bool,
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
    /// The device, counted in windows of requests.
    Window,
    /// The device, with its banks, rows, queues and timings.
    Banked,
    /// `banked`, and what `window` makes of the same frames.
    Both,
}

impl DramArg {
    /// The value of `dram.model`.
    pub const fn key(self) -> &'static str {
        match self {
            DramArg::Bandwidth => "bandwidth",
            DramArg::Window => "window",
            DramArg::Banked | DramArg::Both => "banked",
        }
    }
}

impl From<ModelArg> for sim::Model {
    fn from(model: ModelArg) -> sim::Model {
        match model {
            ModelArg::Paper => sim::Model::Paper,
            ModelArg::Cycle => sim::Model::Cycle,
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

/// Everything that a replay is made of, opened and checked.
struct Replay {
    trace: TraceFile,
    model: Model,
    facts: Facts,
    experiment: Experiment,
    /// The same machine with the `window` model of the DRAM, where both were asked for.
    window: Option<System>,
}

/// What is kept of one machine's frames.
#[derive(Debug, Default)]
struct Kept {
    reports: Vec<FrameReport>,
    /// The tile lists of the slowest frame so far, if they are wanted, and what makes it slow.
    slowest: Option<(u64, TileLoad)>,
    wants_tiles: bool,
}

impl Kept {
    fn add(&mut self, view: FrameView<'_>) {
        let FrameView { position, workload, preview, report, .. } = view;
        if self.wants_tiles {
            let weight = report.timing().map_or(report.counters.tile_loads, |t| t.frame);
            if self.slowest.as_ref().is_none_or(|(w, _)| weight > *w) {
                let picture = preview.map(|p| Picture {
                    width: p.width,
                    height: p.height,
                    rgb: p.rgb.clone(),
                });
                self.slowest = Some((weight, TileLoad::of(position, workload, picture)));
            }
        }
        self.reports.push(report);
    }
}

impl Replay {
    /// Opens and checks everything that `args` name.
    fn open(args: &Args) -> Result<Replay, Failure> {
        let model = model(args)?;
        let mut trace = inputs::trace(&args.trace, args.frames)?;
        let trace_facts = inputs::trace_facts(&mut trace)?;
        if let Some(asked) = &args.timeline {
            let tile = match &model {
                Model::Cycle(system) => system.machine().geometry.tile,
                Model::Paper(_) => Geometry::REFERENCE.tile,
            };
            let tiles = trace_facts.width.div_ceil(tile) * trace_facts.height.div_ceil(tile);
            asked.check(trace.range(), tiles)?;
        }
        let (mut experiment, mut window) = (Experiment::default(), None);
        if let Model::Cycle(system) = &model {
            experiment = Experiment::new(system, spread(trace.range(), args.what_if));
            if args.dram_model == Some(DramArg::Both) {
                window = Some(system.with(&[Change::machine("dram.model", "window")])?);
            }
        }
        let facts = facts(args, &trace, trace_facts, &model)?;
        Ok(Replay { trace, model, facts, experiment, window })
    }

    /// Simulates until the end or Ctrl-C.
    fn run(&mut self, context: &Context) -> Result<Run, Failure> {
        let main = match &self.model {
            Model::Cycle(system) => Subject::of(system).checking_order(),
            Model::Paper(model) => Subject::paper(model),
        };
        let experiment = std::mem::take(&mut self.experiment);
        let mut subjects = vec![main];
        let doubled = experiment.systems.iter();
        subjects.extend(doubled.map(|s| Subject::of(s).only(&experiment.frames)));
        subjects.extend(self.window.iter().map(Subject::of));
        let watch = Watched::new(context, Counts::Frames);
        let mut session = Session::new(&mut self.trace, &watch);
        let start = |i| Kept { wants_tiles: i == 0, ..Kept::default() };
        let folded = session.fold(&subjects, start, Kept::add)?;
        drop(subjects);
        let mut kept = folded.states.into_iter();
        let main = kept.next().expect("the first subject");
        let mut others: Vec<Vec<FrameReport>> = kept.map(|kept| kept.reports).collect();
        let window = self.window.is_some().then(|| others.pop().expect("the last subject"));
        let dram_models = window.and_then(|window| dram_models(&main.reports, &window));
        let what_if = experiment.finish(&main.reports, &others);
        Ok(Run {
            facts: self.facts.clone(),
            frames: main.reports,
            tiles: main.slowest.map(|(_, tiles)| tiles),
            extras: Extras { what_if, dram_models },
        })
    }

    /// Hands out the DRAM requests of the first frame in the order in which they are made.
    fn dram_requests(&mut self, sink: &mut dram_dump::Sink<'_>) -> Result<(), Failure> {
        let first = self.trace.range().start;
        let Model::Cycle(system) = &self.model else {
            let what = "--dump-dram: the paper model makes no requests; use --model cycle";
            return Err(Failure::new(Exit::Usage, what));
        };
        let (workload, measured) = Session::new(&mut self.trace, &()).frame_on(system, first)?;
        observed(&workload, &measured, system.machine(), &mut Requests(sink));
        Ok(())
    }

    /// Writes the timeline of a frame into the folder; returns what the user should know.
    fn timeline(&mut self, folder: &RunFolder, asked: &Asked) -> Result<Option<String>, Failure> {
        let Model::Cycle(system) = &self.model else { return Ok(None) };
        let session = &mut Session::new(&mut self.trace, &());
        let (workload, measured) = session.frame_on(system, asked.frame)?;
        timeline::write(folder, asked, system.machine(), (&workload, &measured))
    }
}

/// The machine or the published model, with the display.
fn model(args: &Args) -> Result<Model, Failure> {
    let display = Some(args.display.clone());
    if args.model == ModelArg::Cycle {
        if args.reference_padding {
            let what = "--reference-padding belongs to --model paper";
            return Err(Failure::new(Exit::Usage, what));
        }
        let mut sets = args.sets.clone();
        if let Some(model) = args.dram_model {
            sets.push(format!("dram.model={}", model.key()));
        }
        let (machine, energy) = (args.arch.clone(), args.energy.clone());
        let spec = SystemSpec { machine, sets, energy, display };
        return Ok(Model::Cycle(Box::new(System::load(&spec, &DiskFiles)?)));
    }
    let machine_only = args.dram_model.is_some() || args.timeline.is_some();
    if !args.sets.is_empty() || machine_only || args.energy.is_some() {
        let what = "--set, --energy, --dram-model, --timeline: the paper model has no machine; \
                    use --model cycle";
        return Err(Failure::new(Exit::Usage, what));
    }
    let padding = if args.reference_padding { Padding::Reference } else { Padding::TrueTiles };
    let model = PaperModel::new(padding)?.with_display(&args.display, &DiskFiles)?;
    Ok(Model::Paper(Box::new(model)))
}

fn facts(
    args: &Args,
    trace: &TraceFile,
    trace_facts: TraceFacts,
    model: &Model,
) -> Result<Facts, Failure> {
    let mut inputs = vec![trace.input().clone()];
    let (machine, of_model, configuration) = match model {
        Model::Cycle(system) => (machine_facts(system), system.inputs(), system.configuration()),
        Model::Paper(model) => {
            let machine = MachineFacts {
                name: "paper".into(),
                energy_table: model.table().origin.clone(),
                clock_hz: None,
                dram_peak_gb_s: None,
                dram_model: None,
                roofline: None,
            };
            (machine, model.inputs(), model.configuration())
        }
    };
    inputs.extend(of_model);
    let model = args.model.into();
    Ok(Facts { model, display_fps: args.fps, trace: trace_facts, machine, inputs, configuration })
}

/// Hands on the requests to the DRAM.
struct Requests<'a, 'b>(&'a mut dram_dump::Sink<'b>);

impl Observer for Requests<'_, '_> {
    const WANTS_REQUESTS: bool = true;

    fn span(&mut self, _: Span) {}

    fn request(&mut self, is_write: bool, address: u64, bytes: u64) {
        (self.0)(is_write, address, bytes);
    }
}

/// The same frames with the DRAM in windows and with its banks; `None` without a frame.
fn dram_models(banked: &[FrameReport], window: &[FrameReport]) -> Option<DramModels> {
    let moved = |report: &FrameReport| {
        let Some(timing) = report.timing() else { return 0.0 };
        let bursts = |c: &DramCommands| {
            c.stages.iter().map(|s| s.reads + s.writes).sum::<u64>() * c.burst_bytes
        };
        timing.dram.commands.as_ref().map_or(0, bursts) as f64
    };
    let n = window.len();
    let mean = |reports: &[FrameReport], of: &dyn Fn(&FrameReport) -> f64| {
        reports.iter().take(n).map(of).sum::<f64>() / n as f64
    };
    let time = |report: &FrameReport| Cost::of(report).frame_time_ms;
    (n > 0).then(|| DramModels {
        window_ms: mean(window, &time),
        banked_ms: mean(banked, &time),
        window_bytes: mean(window, &moved),
        banked_bytes: mean(banked, &moved),
    })
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let mut replay = Replay::open(args)?;
    let started = Started::now();
    if let Some(path) = &args.dump_dram {
        dram_dump::write(path, &mut |sink| replay.dram_requests(sink))?;
    }
    let folder = folder(args, &replay.facts)?;
    let run = replay.run(context)?;
    let mut timeline = |folder: &RunFolder, asked: &Asked| replay.timeline(folder, asked);
    publish(args, context, &started, folder, &run, &mut timeline)
}

/// The report folder, refused before any work if it is finished.
///
/// # Errors
/// Exit code 2.
pub fn folder(args: &Args, facts: &Facts) -> Result<RunFolder, Failure> {
    let name = format!("{}-{}", facts.trace.name, facts.machine.name);
    RunFolder::create(args.out.as_deref(), &name, args.force)
}

/// Writes a timeline into a folder; returns what the user should know.
pub type WriteTimeline<'a> = dyn FnMut(&RunFolder, &Asked) -> Result<Option<String>, Failure> + 'a;

/// Writes the report folder and prints the summary.
///
/// # Errors
/// Exit code 2: the folder cannot be written; 4: a defect.
pub fn publish(
    args: &Args,
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
    for file in report::files(run).or_exit(Exit::Internal, "report")? {
        folder.write(&file.name, &file.bytes)?;
    }
    let note = args.timeline.as_ref().map(|asked| timeline(&folder, asked)).transpose()?;
    if let Some(note) = note.flatten() {
        out::complain(format_args!("note: {note}"));
    }
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let path = folder.finish()?;
    print(args, context, run, &path)?;
    Ok(if run.incomplete() { Exit::Interrupted } else { Exit::Done })
}

fn print(args: &Args, context: &Context, run: &Run, folder: &Path) -> Result<(), Failure> {
    if context.global.json {
        return out::json(&report::json::report(run));
    }
    if context.global.quiet {
        return Ok(());
    }
    let best = run.extras.what_if.as_ref().and_then(|w| w.best());
    let next = next_command(args, best.map_or(&[], |step| &step.sets));
    let summary = folder.join("summary.md").display().to_string();
    out::text(&terminal::summary(run, Some(&summary), Some(&next)))
}

/// The same command with the step that buys most; without one, the other model.
fn next_command(args: &Args, step: &[String]) -> String {
    let mut words = vec!["powergs-sim".into(), "replay".into()];
    words.push(args.trace.display().to_string());
    if args.arch != DEFAULT_ARCH {
        words.extend(["--arch".into(), args.arch.clone()]);
    }
    for set in args.sets.iter().chain(step) {
        words.extend(["--set".into(), set.clone()]);
    }
    if let Some(energy) = &args.energy {
        words.extend(["--energy".into(), energy.clone()]);
    }
    if args.model == ModelArg::Cycle && step.is_empty() {
        words.extend(["--model".into(), "paper".into()]);
    }
    if args.fps != 60.0 {
        words.extend(["--fps".into(), report::format::rate(args.fps)]);
    }
    let quoted = |word: &String| {
        let plain = |c: char| c.is_alphanumeric() || "-_./=:,".contains(c);
        if word.chars().all(plain) { word.clone() } else { format!("'{word}'") }
    };
    continued(words.iter().map(quoted))
}

/// Words of a command in lines that a shell takes for one, as wide as the terminal beside `next`.
fn continued(words: impl Iterator<Item = String>) -> String {
    let mut text = String::new();
    let mut column = 0;
    for word in words {
        let length = word.chars().count();
        if column > 0 && column + 1 + length > 70 {
            text.push_str(" \\\n        ");
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
