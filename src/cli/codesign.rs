//! `codesign`: the model and the machine that need the fewest watts together.

mod demo;
mod dry_run;
mod finish;
mod folder;
mod inputs;
mod slurm;
mod watch;

use std::path::PathBuf;

use super::chart_args::ChartArgs;
use super::invocation::Started;
use super::power_views::PowerViewArgs;
use super::setting_args::FitSettings;
use super::shard_arg::ShardArg;
use super::slurm::Asked;
use super::store_folder::RunArgs;
use super::training_args::{DenseArgs, LikenessArgs, TrainingViewArgs};
use super::{Context, Exit, Failure, out};
use folder::{Existing, Folder, LAYOUT};
use powergs_codesign::{Codesign, CodesignError};
use powergs_study::sweep::run::Shard;
use slurm::CodesignParts;
use watch::Watched;

/// Shown under `codesign --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim codesign --demo
  powergs-sim codesign model.ply --cameras cameras.json --space space.toml \\
      --quality M --out runs/both
  powergs-sim codesign model.ply --orbit 24 --size 400x300 --space space.toml \\
      --quality-db 36 --iterations 300
  powergs-sim codesign ...the same arguments... --dry-run
  powergs-sim codesign ...the same arguments... --resume
  powergs-sim codesign ...the same arguments... --slurm sbatch.toml

A space file (docs/codesign.md):
  [model]
  rho = [0.0, 0.3, 0.6]
  sh-degree = [3, 1]
  [[model.formats]]
  name = \"fp16\"
  colour-dc = \"e5m10\"
  colour-rest = \"e4m3\"
  [machine]
  base = \"gscore\"
  [[machine.axes]]
  key = \"vru.cores\"
  values = [1, 2, 4]

A file for Slurm (docs/cluster.md):
  shards = 10
  [sbatch]
  time = \"02:00:00\"
  cpus-per-task = 4

The result is runs/both/summary.md, with joint.ply and joint.toml:
  powergs-sim replay runs/both/joint.bin --arch runs/both/joint.toml";

/// The arguments of `codesign`.
#[derive(Debug, clap::Args)]
#[command(mut_arg("out", |out| out.help("Folder of the run [default: runs/NAME-codesign]")))]
pub struct CodesignArgs {
    /// A generated scene with a small space, in a few minutes
    #[arg(long, conflicts_with_all = ["model", "cameras", "orbit", "detail", "every"])]
    pub demo: bool,
    /// The model.
    #[command(flatten)]
    pub dense: DenseArgs,
    /// The space: axes of the model, axes of the machine, the budget. --resume takes another one
    /// too, and makes what is new
    #[arg(long, value_name = "FILE")]
    pub space: Option<PathBuf>,
    /// Where the run is.
    #[command(flatten)]
    pub run: RunArgs,
    /// Make and price only part I of N of the models; with all parts there, the same command
    /// with --resume in its place compares them
    #[arg(long, value_name = "I/N", env = "POWERGS_SHARD")]
    #[arg(conflicts_with_all = ["force", "resume"])]
    pub shard: Option<ShardArg>,
    /// Submit the parts to Slurm as an array job, follow it and compare
    #[arg(long, value_name = "SBATCH.TOML", conflicts_with_all = ["shard", "force"])]
    pub slurm: Option<PathBuf>,
    /// Check everything and count what it would take; write nothing
    #[arg(long, conflicts_with_all = ["resume", "force", "shard", "slurm"])]
    pub dry_run: bool,
    /// With --slurm: only print the script
    #[arg(long, requires = "slurm")]
    pub print: bool,
    /// Which views there are.
    #[command(flatten)]
    pub views: ViewArgs,
    /// Where power is counted.
    #[command(flatten, next_help_heading = "Power")]
    pub power: PowerViewArgs,
    /// How good models must be.
    #[command(flatten)]
    pub quality: QualityArgs,
    /// How models are fine-tuned.
    #[command(flatten)]
    pub search: SearchArgs,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
}

/// Which views there are.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Views")]
pub struct ViewArgs {
    /// The cameras.
    #[command(flatten)]
    pub seen: TrainingViewArgs,
    /// Image size, pixels [default: that of the cameras]
    #[arg(long, value_name = "WxH", value_parser = super::camera_file::image_size)]
    pub size: Option<(u32, u32)>,
}

/// How good models must be.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Quality")]
pub struct QualityArgs {
    /// 40, 37 or 34 dB (and an SSIM of 0.98, 0.965 or 0.945) against the renders of the dense model
    /// [default: `budget.psnr` of the space, or M]
    #[arg(long, value_enum, ignore_case = true, value_name = "H|M|L", group = "goal")]
    pub quality: Option<LevelArg>,
    /// The same in numbers.
    #[command(flatten)]
    pub likeness: LikenessArgs,
}

/// How models are fine-tuned.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Search")]
pub struct SearchArgs {
    /// Iterations of a fine-tune at most [default: 1000, with --demo 400]
    #[arg(long, value_name = "N")]
    pub iterations: Option<u32>,
    /// Fine-tune all models for an eighth of the iterations first, the better half for a quarter,
    /// and only the better half of these in full
    #[arg(hide_short_help = true, long, conflicts_with_all = ["shard", "slurm"])]
    pub halving: bool,
    /// Rounds at most in which the machine that was found gives another ratio to try; 0 for none
    #[arg(hide_short_help = true)]
    #[arg(long, value_name = "N", default_value_t = powergs_codesign::run::ROUNDS)]
    pub rounds: u32,
    /// The numbers of a fine-tune.
    #[command(flatten)]
    pub settings: FitSettings,
}

/// Runs `codesign`.
pub fn run(args: &CodesignArgs, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    let space = inputs::space(args)?;
    let watched = Watched::new(context);
    let codesign = inputs::codesign(args, &space, context, &watched)?;
    if args.dry_run {
        watched.clear();
        return dry_run::run(&codesign, context);
    }
    let folder = Folder::new(&inputs::place(args, &codesign), &LAYOUT);
    let run = Run {
        codesign: &codesign,
        space: &space,
        folder: &folder,
        watched: &watched,
        context,
        started,
    };
    if let Some(file) = &args.slurm {
        watched.clear();
        let asked = Asked { settings: file, print: args.print };
        return super::slurm::run(asked, CodesignParts { args, run }, folder.path(), context);
    }
    match args.shard {
        Some(ShardArg(part)) => run.part(part),
        None => run.whole(args.run.existing()),
    }
}

/// A co-design that is about to be worked on.
struct Run<'a> {
    codesign: &'a Codesign,
    space: &'a inputs::Space,
    folder: &'a Folder,
    watched: &'a Watched<'a>,
    context: &'a Context,
    started: Started,
}

impl Run<'_> {
    /// The files that say what a run is; the marker of the folder comes last.
    fn about(&self) -> Result<[(&'static str, String); 2], Failure> {
        let run = finish::run_toml(self.codesign, self.space)?;
        Ok([("space.toml", self.space.text.clone()), (LAYOUT.marker, run)])
    }

    /// Makes and prices everything that is not there, and compares it.
    fn whole(self, existing: Existing) -> Result<Exit, Failure> {
        let Run { codesign, folder, watched, context, .. } = self;
        let _lock = folder.open(existing)?;
        // The marker first: a folder that has it can be gone on with.
        for (name, text) in self.about()?.iter().rev() {
            folder.write(name, text)?;
        }
        watched.begin(codesign);
        let finished = codesign.run(folder.store(), watched);
        watched.clear();
        folder.write("invocation.toml", self.started.invocation_toml())?;
        match finished? {
            Some(finished) => finish::finish(codesign, &finished, folder, context),
            None => {
                if !context.global.quiet {
                    let path = folder.path().display();
                    out::complain(format!(
                        "interrupted, {path}: the same command with --resume goes on"
                    ));
                }
                Ok(Exit::Interrupted)
            }
        }
    }

    /// Makes and prices one part of the models.
    fn part(self, part: Shard) -> Result<Exit, Failure> {
        let Run { codesign, folder, watched, .. } = self;
        let _lock = folder.open_part(&self.about()?)?;
        watched.begin(codesign);
        let done = codesign.run_part(part, folder.store(), watched);
        watched.clear();
        let (Shard { number, of }, path) = (part, folder.path().display());
        let (exit, what) = match done? {
            Some(()) => {
                (Exit::Done, "is done; when all are: the same command, with --resume for --shard")
            }
            None => (Exit::Interrupted, "was interrupted; the same command goes on"),
        };
        if !self.context.global.quiet {
            out::complain(format!("{path}: part {number} of {of} {what}"));
        }
        Ok(exit)
    }
}

impl From<CodesignError> for Failure {
    fn from(error: CodesignError) -> Failure {
        let exit = match error {
            CodesignError::Run(error) => return error.into(),
            CodesignError::Space { .. } | CodesignError::TooFewViews { .. } => Exit::Usage,
            CodesignError::OutOfReach(_) | CodesignError::Infeasible(_) => Exit::GoalMissed,
            CodesignError::Tune { .. } => Exit::BadInput,
        };
        Failure { exit, error: error.into() }
    }
}

/// A named step of quality.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum LevelArg {
    /// High
    H,
    /// Medium
    M,
    /// Low
    L,
}
