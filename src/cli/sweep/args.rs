//! The arguments of `sweep`.

use std::path::PathBuf;

use crate::cli::camera_file::FrameArgs;
use crate::cli::chart_args::ChartArgs;
use crate::cli::dram_model::DramModelArg;
use crate::cli::inputs::SetArgs;
use crate::cli::replay::display_rate;
use crate::cli::shard_arg::ShardArg;
use crate::cli::store_folder::RunArgs;
use powergs_study::sweep::run::confirm::CONFIRMED_MAX;
use powergs_study::sweep::run::{StandIn, SweepRequest};

/// Shown under `sweep --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim sweep gscore-units --traces 'traces/*.bin' --out reports/units
  powergs-sim sweep my.toml --traces room.bin --dry-run
  powergs-sim sweep my.toml --traces room.bin --out big --resume
  powergs-sim sweep my.toml --traces room.bin --out big --shard 3/16
  powergs-sim sweep my.toml --traces room.bin --out big --resume --confirm 5
  powergs-sim sweep merge big
  powergs-sim sweep status big
  powergs-sim sweep show 3f2a91 big --toml > best.toml
  powergs-sim pareto big --minimize power_w.mean,area_mm2 --maximize fps.mean

A sweep file says which keys of which machine are varied, and which question it
answers: docs/sweep-file.md. The table of results: docs/results.md. Many hosts:
docs/cluster.md.";

/// The arguments of `sweep`.
#[derive(Debug, Clone, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct SweepCommandArgs {
    /// What to do with a sweep that is there already
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The sweep
    #[command(flatten)]
    pub sweep: SweepArgs,
}

/// The sub-commands.
#[derive(Debug, Clone, clap::Subcommand)]
pub enum Command {
    /// Say how much of a sweep is done
    Status(StatusArgs),
    /// Put the parts of a sweep together (after --shard)
    Merge(MergeArgs),
    /// Show one design of a sweep: its values, its machine file
    Show(ShowArgs),
}

/// What a sweep is made of.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct Definition {
    /// Sweep file, or one that comes with the program: gscore-units, sram-bandwidth,
    /// tiles, node-energy, node-choice
    #[arg(value_name = "SWEEP", required = true)]
    pub file: Option<String>,
    /// Traces: files or patterns; in place of those in the sweep file
    #[arg(long, value_name = "PATTERN", num_args = 1..)]
    pub traces: Vec<String>,
    /// Only some frames
    #[command(flatten)]
    pub only: FrameArgs,
    /// What is otherwise in the base machine
    #[command(flatten)]
    pub changes: SetArgs,
    /// Display rate, frames per second, in place of that of the sweep file
    #[arg(long, value_name = "RATE", value_parser = display_rate)]
    pub fps: Option<f64>,
    /// Display, in place of that of the sweep file: a name of `arch list`, or a TOML file
    #[arg(long, value_name = "NAME|FILE")]
    pub display: Option<String>,
    /// At most this many designs, spread over the space
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub points: Option<u64>,
    /// DRAM model, in place of the machine's [default: of more than 20 designs, calibrated in
    /// place of banked]
    #[arg(long, value_enum, value_name = "MODEL")]
    pub dram_model: Option<DramModelArg>,
}

impl Definition {
    /// What the engine is asked for.
    pub fn request(&self) -> SweepRequest {
        SweepRequest {
            file: self.file.clone().unwrap_or_default(),
            traces: self.traces.clone(),
            frames: self.only.frames.map(|f| (f.start, f.end)),
            sets: self.changes.sets.clone(),
            points: self.points,
            dram_model: self.dram_model.map(|model| model.key().to_owned()),
            display_fps: self.fps,
            display: self.display.clone(),
            stand_in: StandIn::default(),
            folder: None,
        }
    }
}

/// `sweep FILE`.
#[derive(Debug, Clone, clap::Args)]
#[command(mut_arg("out", |out| out.help("Folder of the sweep [default: reports/NAME]")))]
pub struct SweepArgs {
    /// What the sweep is made of
    #[command(flatten)]
    pub definition: Definition,
    /// Where it is
    #[command(flatten)]
    pub run: RunArgs,
    /// Say how many designs there are, and how long it would take
    #[arg(long)]
    pub dry_run: bool,
    /// Do only part I of N; `sweep merge` puts the parts together
    #[arg(long, value_name = "I/N", env = "POWERGS_SHARD", conflicts_with = "force")]
    pub shard: Option<ShardArg>,
    /// Folder of results that sweeps share: what is there is not simulated again
    #[arg(long, value_name = "DIR")]
    pub store: Option<PathBuf>,
    /// Simulate N designs of the front again with `banked`, the knee and its neighbours
    /// first; 0 to 20 [default: 20 where designs have calibrated in place of banked]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=i64::from(CONFIRMED_MAX)))]
    pub confirm: Option<u16>,
    /// Submit the sweep to Slurm as an array job, follow it and merge
    #[arg(long, value_name = "SBATCH.TOML", conflicts_with_all = ["shard", "dry_run", "force"])]
    pub slurm: Option<PathBuf>,
    /// With --slurm: only print the script
    #[arg(long, requires = "slurm")]
    pub print: bool,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
}

/// `sweep status`.
#[derive(Debug, Clone, clap::Args)]
pub struct StatusArgs {
    /// Folder of the sweep
    pub folder: PathBuf,
}

/// `sweep merge`.
#[derive(Debug, Clone, clap::Args)]
pub struct MergeArgs {
    /// Folder of the sweep
    pub folder: PathBuf,
    /// Also take results from these folders of the same sweep
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub from: Vec<PathBuf>,
    /// Simulate N designs of the front again with `banked`, as `sweep --confirm`
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=i64::from(CONFIRMED_MAX)))]
    pub confirm: Option<u16>,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
}

impl SweepCommandArgs {
    /// How charts are drawn.
    pub fn charts(&self) -> &ChartArgs {
        match &self.command {
            Some(Command::Merge(args)) => &args.charts,
            Some(Command::Status(_) | Command::Show(_)) | None => &self.sweep.charts,
        }
    }
}

/// `sweep show`.
#[derive(Debug, Clone, clap::Args)]
pub struct ShowArgs {
    /// The design: its id or the beginning of it, its number, or `baseline`
    pub id: String,
    /// Folder of the sweep
    pub folder: PathBuf,
    /// Print its machine file
    #[arg(long)]
    pub toml: bool,
}
