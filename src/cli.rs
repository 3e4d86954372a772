//! The command line: arguments, exit codes and printing. Everything else is in the library.
//!
//! One file per command under `cli/`; each has its `Args` (clap) and a
//! `run(&Args, &Context) -> Result<Exit, Failure>`.

pub mod again;
pub mod arch;
pub mod background;
mod camera;
pub mod camera_file;
mod certificate;
pub mod chart_args;
mod codesign;
mod compare;
pub mod completions;
mod demo_scene;
mod display;
mod dram;
pub mod dram_model;
pub mod explain;
mod extract;
mod failure;
mod filter;
mod fit;
mod gaze;
pub mod inputs;
pub mod invocation;
mod lpips_file;
mod optimize;
pub mod out;
pub mod output_file;
pub mod pack;
mod pareto;
mod picture_file;
mod power_views;
pub mod progress;
mod quality;
mod references;
pub mod render;
pub mod replay;
pub mod run_folder;
mod scene;
pub mod scene_file;
mod sensitivity;
mod setting_args;
mod shard_arg;
mod sight;
mod slurm;
pub mod startup;
mod store_folder;
mod sweep;
pub mod synth;
pub mod timeline;
mod trace;
mod train;
mod training_args;
pub mod usage;
mod validate;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, Parser, Subcommand};

use powergs_base::budget::Budget;

pub use failure::{Exit, Failure, OrExit};

/// Simulates 3D Gaussian Splatting accelerators: frame rate, stalls, energy, power.
#[derive(Debug, Parser)]
#[command(name = "powergs-sim", version, long_version = invocation::built(), max_term_width = 80)]
pub struct Cli {
    /// Flags that every command takes.
    #[command(flatten)]
    pub global: Global,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Flags that every command takes.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Common options")]
pub struct Global {
    /// Print the result as JSON on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Print errors only: no progress, no summary
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Worker threads [default: all cores]; results are the same for any number
    #[arg(long, short, global = true, value_name = "N")]
    pub jobs: Option<std::num::NonZeroUsize>,
    /// Memory for frames and pictures in work; larger ones are refused
    #[arg(long, global = true, value_name = "SIZE", default_value_t = Budget::DEFAULT)]
    pub memory: Budget,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a trace on a machine: frame rate, stalls, energy, power
    #[command(after_help = replay::EXAMPLES)]
    Replay(replay::ReplayArgs),
    /// Compare machines on the same trace, or finished reports, side by side
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::CompareCommandArgs),
    /// Simulate many designs on some traces: a table of results
    #[command(after_help = sweep::EXAMPLES)]
    Sweep(sweep::SweepCommandArgs),
    /// Analyse a sweep: Pareto front, knee, marginal values, stability
    #[command(after_help = pareto::EXAMPLES)]
    Pareto(pareto::ParetoArgs),
    /// Vary every parameter, or every assumption, and report the effect
    #[command(after_help = sensitivity::EXAMPLES)]
    Sensitivity(sensitivity::SensitivityArgs),
    /// Check the simulator against published numbers
    #[command(after_help = validate::EXAMPLES)]
    Validate(validate::ValidateArgs),
    /// Render a scene and record a trace of it
    #[command(after_help = extract::EXAMPLES)]
    Extract(extract::ExtractArgs),
    /// Render views of a scene to PNG
    #[command(after_help = render::EXAMPLES)]
    Render(render::RenderArgs),
    /// Make a synthetic scene that behaves like a trained one
    #[command(after_help = synth::EXAMPLES)]
    Synth(synth::SynthArgs),
    /// Inspect trained models and convert them
    #[command(after_help = scene::EXAMPLES)]
    Scene(scene::SceneArgs),
    /// Inspect camera files, convert them, make paths
    #[command(after_help = camera::EXAMPLES)]
    Camera(camera::CameraCommandArgs),
    /// Inspect traces, check them, dump frames as CSV
    #[command(after_help = trace::EXAMPLES)]
    Trace(trace::TraceCommandArgs),
    /// Train a model from photos with poses, by the published rules of 3DGS
    #[command(after_help = train::EXAMPLES)]
    Train(Box<train::TrainArgs>),
    /// Minimise power at a given quality: prune and fine-tune a trained model
    #[command(after_help = optimize::EXAMPLES)]
    Optimize(Box<optimize::OptimizeArgs>),
    /// Search a model and a machine together: the fewest watts at a given quality
    #[command(after_help = codesign::EXAMPLES)]
    Codesign(Box<codesign::CodesignArgs>),
    /// Fit power curves to samples that reach a quality and find their minimum
    #[command(after_help = fit::EXAMPLES)]
    Fit(fit::FitArgs),
    /// Apply the foveated colour filter D22 to a picture
    #[command(after_help = filter::EXAMPLES)]
    Filter(filter::FilterArgs),
    /// Compare two pictures: PSNR, SSIM, FLIP, HVSQ
    #[command(after_help = quality::EXAMPLES)]
    Quality(quality::PictureQualityArgs),
    /// Report the power that a picture takes on a display
    #[command(after_help = display::EXAMPLES)]
    Display(display::DisplayArgs),
    /// List, show and check machine files, energy tables, displays and DRAM devices
    #[command(after_help = arch::EXAMPLES)]
    Arch(arch::ArchArgs),
    /// Say what numbers of a machine rest on: files, prices, assumptions, published numbers
    #[command(after_help = certificate::EXAMPLES)]
    Certificate(certificate::CertificateArgs),
    /// Run a trace of addresses on a memory device alone
    #[command(after_help = dram::EXAMPLES)]
    Dram(dram::DramArgs),
    /// Run the command that made a folder once more, and compare the results
    #[command(after_help = again::EXAMPLES)]
    Again(again::AgainArgs),
    /// Pack a finished folder with the files that its command reads into one archive
    #[command(after_help = pack::EXAMPLES)]
    Pack(pack::PackArgs),
    /// Define a statistic, key, column, assumption, source or term
    #[command(after_help = explain::EXAMPLES)]
    Explain(explain::ExplainArgs),
    /// Print a completion script for a shell
    #[command(after_help = completions::EXAMPLES)]
    Completions(completions::CompletionsArgs),
}

impl Command {
    /// How the command draws.
    pub fn drawing(&self) -> powergs_report::Drawing {
        self.charts().map_or_else(Default::default, |charts| charts.drawing())
    }

    /// Its flags of drawing; `None` if it draws nothing.
    fn charts(&self) -> Option<&chart_args::ChartArgs> {
        match self {
            Command::Replay(args) => Some(&args.charts),
            Command::Compare(args) => Some(&args.charts),
            Command::Fit(args) => Some(&args.charts),
            Command::Optimize(args) => Some(&args.charts),
            Command::Codesign(args) => Some(&args.charts),
            Command::Sensitivity(args) => Some(&args.charts),
            Command::Sweep(args) => Some(args.charts()),
            Command::Pareto(args) => Some(&args.charts),
            _ => None,
        }
    }
}

/// What a command needs besides its arguments.
#[derive(Debug, Clone)]
pub struct Context {
    /// Flags that every command takes.
    pub global: Global,
    /// How charts are drawn.
    pub drawing: powergs_report::Drawing,
    /// Set by Ctrl-C; long work polls it, finishes the item in flight and returns
    /// [`Exit::Interrupted`].
    pub cancelled: Arc<AtomicBool>,
}

impl Context {
    /// Whether the user pressed Ctrl-C.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// The program: answers shells that complete, parses the command line, dispatches, and turns the
/// outcome into an exit code.
pub fn main() -> std::process::ExitCode {
    completions::answer();
    std::process::ExitCode::from(command())
}

/// The program in a process of another one, for which `words` were typed: a path under which the
/// program is started again, and its arguments. Once a process; it may end it, as after `--help`.
pub fn main_of(words: Vec<std::ffi::OsString>) -> u8 {
    invocation::typed(words);
    command()
}

fn command() -> u8 {
    let cli: Cli = usage::parse();
    startup::start(&cli.global, cli.command.drawing(), |context| run(&cli, context)) as u8
}

/// Runs one command.
pub fn run(cli: &Cli, context: &Context) -> Result<Exit, Failure> {
    match &cli.command {
        Command::Replay(args) => replay::run(args, context),
        Command::Extract(args) => extract::run(args, context),
        Command::Render(args) => render::run(args, context),
        Command::Again(args) => again::run(args, context),
        Command::Arch(args) => arch::run(args, context),
        Command::Camera(args) => camera::run(args, context),
        Command::Certificate(args) => certificate::run(args, context),
        Command::Codesign(args) => codesign::run(args, context),
        Command::Compare(args) => compare::run(args, context),
        Command::Completions(args) => completions::run(args, context),
        Command::Display(args) => display::run(args, context),
        Command::Dram(args) => dram::run(args, context),
        Command::Explain(args) => explain::run(args, context),
        Command::Filter(args) => filter::run(args, context),
        Command::Fit(args) => fit::run(args, context),
        Command::Quality(args) => quality::run(args, context),
        Command::Pack(args) => pack::run(args, context),
        Command::Pareto(args) => pareto::run(args, context),
        Command::Optimize(args) => optimize::run(args, context),
        Command::Scene(args) => scene::run(args, context),
        Command::Sensitivity(args) => sensitivity::run(args, context),
        Command::Sweep(args) => sweep::run(args, context),
        Command::Synth(args) => synth::run(args, context),
        Command::Trace(args) => trace::run(args, context),
        Command::Train(args) => train::run(args, context),
        Command::Validate(args) => validate::run(args, context),
    }
}
