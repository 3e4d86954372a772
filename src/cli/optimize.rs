//! `optimize`: the fewest watts at a given quality.

mod demo;
mod dry_run;
mod finish;
mod folder;
mod foveated;
pub(super) mod inputs;
mod photo_references;
pub(super) mod photos;
mod record;
mod reprice;
mod request;
mod training;
mod watch;

use std::path::{Path, PathBuf};

use super::chart_args::ChartArgs;
use super::invocation::Started;
use super::power_views::PowerViewArgs;
use super::setting_args::SearchSettings;
use super::store_folder::RunArgs;
use super::training_args::{DenseArgs, LikenessArgs, TrainingViewArgs};
use super::{Context, Exit, Failure, gaze, out};
use folder::{Folder, LAYOUT};
use powergs_frame::fovea::ScreenWidth;
use powergs_optimize::campaign::Campaign;
use powergs_optimize::foveated::missing_regions;
use powergs_optimize::judged::JudgedSize;
use powergs_optimize::request::LEAST_GATE;
use powergs_optimize::target::Level;
use powergs_optimize::views::PowerViews;
use powergs_report::format::wrapped;
use powergs_report::optimize::asked;
use watch::{PhotoGate, Watched};

pub use photos::camera_file as photo_cameras;

/// Shown under `optimize --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim optimize --demo
  powergs-sim optimize model.ply --images photos/ --quality 0.99 --out runs/snow
  powergs-sim optimize model.ply --cameras cameras.json --reference self \\
      --quality-db 35 --size 400x300 --out runs/bot
  powergs-sim optimize model.ply --images photos/ --baselines --out runs/all
  powergs-sim optimize model.ply --images photos/ --foveated --out runs/fr
  powergs-sim optimize ...the same arguments... --resume
  powergs-sim optimize model.ply --images photos/ --size 400x300 \\
      --power-size 1920x1080 --out runs/hd
  powergs-sim optimize --reprice runs/snow --display oled-d22 --fps 72
  powergs-sim optimize --reprice runs/snow --power-size 2064x2208

The result is runs/snow/final.ply, and its trace for the simulator:
  powergs-sim replay runs/snow/final.bin
  powergs-sim render runs/snow/final.ply --cameras cameras.json -o pictures";

/// The arguments of `optimize`.
#[derive(Debug, clap::Args)]
pub struct OptimizeArgs {
    /// A generated scene, end to end in a minute or so
    #[arg(long, conflicts_with_all = ["model", "images", "cameras", "orbit", "detail"])]
    pub demo: bool,
    /// The model.
    #[command(flatten)]
    pub dense: DenseArgs,
    /// Where the run is.
    #[command(flatten)]
    pub run: RunArgs,
    /// Price the models of a finished run anew, for the machine, panel, display rate, size or views
    /// that are given beside it: nothing is trained
    #[arg(long, value_name = "RUN", conflicts_with_all = [
        "model", "demo", "detail", "dry_run", "lpips_weights",
        "OptimizeViewArgs", "TrainingViewArgs", "OptimizeQualityArgs", "LikenessArgs",
        "OptimizeSearchArgs", "CompareArgs",
        "FoveaArgs", "SettingArgs",
    ])]
    pub reprice: Option<PathBuf>,
    /// Also train: up to two samples around the new minimum, and the model of the new optimum
    #[arg(hide_short_help = true, long, requires = "reprice")]
    pub realise: bool,
    /// Only estimate time, memory and disk, from a few iterations; nothing is written
    #[arg(long, conflicts_with_all = ["resume", "force"])]
    pub dry_run: bool,
    /// Models that stay in the folder: those that --reprice takes, or all with their moments
    #[arg(hide_short_help = true, long, value_enum, default_value = "needed")]
    pub keep: KeepArg,
    /// Which views there are, and what they should look like.
    #[command(flatten)]
    pub views: OptimizeViewArgs,
    /// Their cameras.
    #[command(flatten)]
    pub seen: TrainingViewArgs,
    /// Image size that models train at, pixels [default: that of the cameras, or of smaller
    /// photos]; photos are averaged down to it, and must have its aspect. Quality is measured at
    /// the size that power is counted at (--gate-size). With --reprice, as --power-size
    #[arg(long, value_name = "WxH", value_parser = super::camera_file::image_size)]
    #[arg(help_heading = "Views", display_order = BEHIND_SETTINGS + 1)]
    pub size: Option<(u32, u32)>,
    /// How good the result must be.
    #[command(flatten)]
    pub quality: OptimizeQualityArgs,
    /// The same in numbers.
    #[command(flatten)]
    pub likeness: LikenessArgs,
    /// What power is.
    #[command(flatten)]
    pub power: PowerArgs,
    /// How it is searched.
    #[command(flatten)]
    pub search: OptimizeSearchArgs,
    /// Also LPIPS of every model, mean over the test views, with the weights in this safetensors
    /// file; docs/metrics.md says how to make it
    #[arg(hide_short_help = true, long, value_name = "FILE", display_order = BEHIND_SETTINGS)]
    pub lpips_weights: Option<PathBuf>,
    /// What is made for comparison.
    #[command(flatten)]
    pub compare: CompareArgs,
    /// What is made for the periphery of sight.
    #[command(flatten)]
    pub fovea: FoveaArgs,
    /// The numbers of a run.
    #[command(flatten)]
    pub settings: SearchSettings,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
}

/// Where help lists what comes after the settings of its heading.
const BEHIND_SETTINGS: usize = 1000;

/// Models that stay in the run folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum KeepArg {
    /// Samples, the optimum and what reports show, without moments
    Needed,
    /// All, with their moments: three times the room
    All,
}

/// What is made for the periphery of sight.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Foveation")]
pub struct FoveaArgs {
    /// Then levels 2 to 4 for the periphery: pruned further, with their own colours and opacities,
    /// at the HVSQ that level 1 has in the fovea; one model.fov of all
    #[arg(long)]
    pub foveated: bool,
    /// The virtual screen: camera, as wide as the camera of each view sees; its width in degrees;
    /// or powergs (90, as published), wide-100, wide-110 [default: camera, with --demo powergs]
    #[arg(
        hide_short_help = true,
        long,
        value_name = "DEGREES|NAME",
        requires = "foveated",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = ScreenWidth::parse)]
    pub screen: Option<ScreenWidth>,
    /// Pooling angle per squared eccentricity, 1/rad: larger, and small images have all levels
    /// [default: 0.05, with --demo what gives its small images all four]
    #[arg(
        hide_short_help = true,
        long,
        value_name = "RATE",
        requires = "foveated",
        allow_hyphen_values = true
    )]
    pub pooling_rate: Option<f64>,
    /// Operations of the D22 colour filter for a pixel outside of the fovea (A99)
    #[arg(hide_short_help = true, long, value_name = "N", default_value_t = 215.0)]
    #[arg(display_order = BEHIND_SETTINGS)]
    pub filter_flops: f64,
}

/// Which views there are, and what they should look like.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Views")]
pub struct OptimizeViewArgs {
    /// Photos; their poses are in --cameras, or in a cameras.json, transforms.json or COLMAP's
    /// sparse/0 beside them
    #[arg(long, value_name = "DIR", conflicts_with = "reference")]
    pub images: Option<PathBuf>,
    /// PSNR that the model must have on the photos before anything is done, decibels: with less
    /// they show something else; 0 goes on all the same
    #[arg(hide_short_help = true)]
    #[arg(long, value_name = "DB", default_value_t = 15.0, value_parser = decibels)]
    pub least_likeness: f64,
    /// What the model is compared with [default: self without --images]
    #[arg(hide_short_help = true, long, value_enum)]
    pub reference: Option<ReferenceArg>,
    /// With photos: validation views train too. The gate then sees what it trains on, and test
    /// views may fall far below the target
    #[arg(hide_short_help = true, long, requires = "images")]
    pub train_on_validation: bool,
    /// Without photos: at least so many gate views; those that the file does not have are made
    /// between the others, because few views say little of all. 0 makes none
    #[arg(hide_short_help = true, long, value_name = "N", default_value_t = LEAST_GATE)]
    #[arg(conflicts_with = "images", display_order = BEHIND_SETTINGS)]
    pub least_gate: usize,
}

/// What the model is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ReferenceArg {
    /// The dense model's own renders
    #[value(name = "self")]
    Own,
}

/// Views that power is a mean over.
fn power_views(text: &str) -> Result<PowerViews, String> {
    match text {
        "all" => Ok(PowerViews::All),
        "test" => Ok(PowerViews::Test),
        n => n.parse().map(PowerViews::Spread).map_err(|_| "all, test, or how many: 16".into()),
    }
}

/// How good the result must be.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Quality")]
pub struct OptimizeQualityArgs {
    /// H, M or L: 99, 98 or 97 % of the PSNR and SSIM of the dense model with photos; 40, 37 or
    /// 34 dB (and an SSIM of 0.98, 0.965 or 0.945) against its own renders. Several make a model
    /// each, the lower ones from the higher: H,M,L. With photos also a share, 0 to 1 [default: M]
    #[arg(long, value_name = "H,M,L|SHARE", group = "goal", value_parser = quality)]
    pub quality: Option<Quality>,
}

/// How good the result must be.
#[derive(Debug, Clone, PartialEq)]
pub enum Quality {
    /// Named steps.
    Named(Vec<Level>),
    /// A share of what the dense model has.
    Share(f64),
}

fn quality(text: &str) -> Result<Quality, String> {
    let level = |name: &str| {
        let is = |l: &Level| l.name().eq_ignore_ascii_case(name.trim());
        Level::ALL.into_iter().find(is)
    };
    let named = text.split(',').map(level).collect::<Option<Vec<Level>>>().map(Quality::Named);
    let share = || text.parse().ok().map(Quality::Share);
    named.or_else(share).ok_or_else(|| "H, M, L, several as H,M,L, or a share such as 0.985".into())
}

/// What power is.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Power")]
pub struct PowerArgs {
    /// Machine: a name or a TOML file [default: gscore]
    #[arg(long, value_name = "MACHINE")]
    pub arch: Option<String>,
    /// Change a key of the machine: vru.cores=8
    #[arg(hide_short_help = true, long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// Energy table in place of the machine's
    #[arg(hide_short_help = true, long, value_name = "TABLE")]
    pub energy: Option<String>,
    /// What counts: the simulated machine with its standby, or as published the closed form, which
    /// has none [default: cycle, with --demo paper]
    #[arg(hide_short_help = true, long, value_enum)]
    pub oracle: Option<super::replay::ModelArg>,
    /// Display preset: a name or a TOML file [default: oled-powergs]
    #[arg(long, value_name = "PRESET")]
    pub display: Option<String>,
    /// Scale the panel so that the dense model's display power is R times that of the accelerator
    /// [default: the panel as it is, with --demo 2]
    #[arg(long, value_name = "R")]
    pub display_ratio: Option<f64>,
    /// Frames shown per second: power is that at this rate, never at the rate that is possible
    /// [default: 60]
    #[arg(long, value_name = "RATE", value_parser = super::replay::display_rate)]
    pub fps: Option<f64>,
    /// Also say what the training of the run would take on this machine: a GPU, or one that trains
    /// (`vorion-train`, `gsarch`)
    #[arg(hide_short_help = true, long, value_name = "MACHINE")]
    pub train_on: Option<String>,
    /// Where it is counted.
    #[command(flatten)]
    pub shown: PowerViewArgs,
    /// Views that power is a mean over: all, test, or so many, evenly spaced [default: all; at most
    /// 16 where they are larger than --size]
    #[arg(hide_short_help = true, long, value_name = "all|test|N", value_parser = power_views)]
    pub power_views: Option<PowerViews>,
    /// Mean power over a smooth path of N frames through the views instead
    #[arg(hide_short_help = true, long, value_name = "N", conflicts_with = "power_views")]
    pub path_frames: Option<usize>,
}

/// How it is searched.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Search")]
pub struct OptimizeSearchArgs {
    /// Ratios of pruned Gaussians to sample, ascending: 0,0.2,0.4 [default: five, both ends of the
    /// curve and then around its minimum]
    #[arg(hide_short_help = true)]
    #[arg(long, value_name = "LIST", value_delimiter = ',', conflicts_with = "schedule")]
    pub rhos: Vec<f64>,
    /// How samples are chosen
    #[arg(hide_short_help = true, long, value_enum, default_value = "five")]
    pub schedule: ScheduleArg,
}

/// How samples are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ScheduleArg {
    /// Five: both ends of the curve and then around its minimum
    Five,
    /// Seven coarse and five fine ones, as the published code; --iterations is what it gives 1500
    Published,
}

/// What is made for comparison.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Comparison")]
pub struct CompareArgs {
    /// Render-only and display-only with all the iterations of the search; two-stage, and
    /// LightGaussian-style at 66, 76 and 86 %, with those of the final model
    #[arg(long)]
    pub baselines: bool,
    /// A further trained model of the same scene: NAME=FILE
    #[arg(hide_short_help = true)]
    #[arg(long = "baseline", value_name = "NAME=FILE", value_parser = named_file)]
    pub others: Vec<(String, PathBuf)>,
    /// Studies: ratio (display against rendering power), lambda (a sweep without pruning)
    #[arg(hide_short_help = true, long, value_enum, value_delimiter = ',')]
    pub study: Vec<StudyArg>,
}

/// A study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum StudyArg {
    /// Display-to-render ratios from 0.38 to 2.66
    Ratio,
    /// Fixed values of lambda without pruning
    Lambda,
}

fn decibels(text: &str) -> Result<f64, String> {
    let db: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.0..=120.0).contains(&db) { Ok(db) } else { Err("must be 0 to 120".into()) }
}

fn named_file(text: &str) -> Result<(String, PathBuf), String> {
    let plain = |name: &str| {
        !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "-_.".contains(c))
    };
    match text.split_once('=') {
        Some((name, file)) if plain(name) && !file.is_empty() => Ok((name.into(), file.into())),
        _ => Err("write it as NAME=FILE; the name has letters, digits, - _ .".into()),
    }
}

/// Runs `optimize`.
pub fn run(args: &OptimizeArgs, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    if let Some(from) = &args.reprice {
        return reprice::run(from, args, started, context);
    }
    // What is wrong with the arguments is said before anything is loaded.
    if args.dense.model.is_none() && !args.demo {
        let what = "optimize: no model; name a trained one, or try --demo, which generates a scene";
        return Err(Failure::new(Exit::Usage, what));
    }
    if args.demo && !context.global.quiet {
        out::complain(wrapped(demo::NOTE, 80));
    }
    let trainer = args.power.train_on.as_deref().map(training::trainer).transpose()?;
    // Without photos a model is compared with itself.
    let gate = args.views.images.is_some().then(|| PhotoGate {
        least_db: args.views.least_likeness,
        background: args.seen.background(args.dense.model.as_deref()).colour,
    });
    let watched = Watched::new(context, gate);
    let campaign = opened(args, context, &watched)?;
    if args.dry_run {
        return dry_run::run(&campaign, &watched, context);
    }
    let record = record::run_toml(&campaign)?;
    let path = args.run.out.clone().unwrap_or_else(|| place(args, &campaign.name));
    let folder = Folder::new(&path, &LAYOUT);
    let _lock = folder.open(args.run.existing())?;
    let run = match args.run.resume {
        true => campaign.resume(folder.store())?,
        false => campaign.begin(folder.store())?,
    };
    folder.write("run.toml", record)?;
    say_target(&campaign, context);
    watched.record(&path, &campaign.cameras)?;
    let finished = run.work(&watched)?;
    watched.finish()?;
    folder.write("invocation.toml", started.invocation_toml())?;
    let Some(finished) = finished else { return Ok(interrupted(&path, context)) };
    finish::finish(&campaign, &finished, &folder, trainer.as_ref(), context)
}

/// What `args` ask for, checked and opened.
fn opened(
    args: &OptimizeArgs,
    context: &Context,
    watched: &Watched<'_>,
) -> Result<Campaign, Failure> {
    let settings = request::settings(args)?;
    let goals = request::goals(args, &settings)?;
    let request = inputs::request(args, context, settings, goals)?;
    let campaign = Campaign::open(request, watched)?;
    note_screens(&campaign, context);
    Ok(campaign)
}

fn interrupted(path: &Path, context: &Context) -> Exit {
    if !context.global.quiet {
        let again = "the same command with --resume goes on";
        out::complain(format!("interrupted, {}: {again}", path.display()));
    }
    Exit::Interrupted
}

/// Where a run is without --out. The demonstration starts anew beside its last run.
fn place(args: &OptimizeArgs, name: &str) -> PathBuf {
    let first = Path::new("runs").join(name);
    if args.demo && !args.run.resume { free(first) } else { first }
}

/// The path, or if something is there, with a number behind it.
fn free(path: PathBuf) -> PathBuf {
    let again = |n: u32| PathBuf::from(format!("{}-{n}", path.display()));
    match path.exists() {
        true => (2..1000).map(again).find(|path| !path.exists()).unwrap_or(path),
        false => path,
    }
}

/// Says what is to be reached, and which views decide.
fn say_target(campaign: &Campaign, context: &Context) {
    if context.global.quiet {
        return;
    }
    let goal = asked(campaign);
    let (gate, test) = (campaign.gate_views(), campaign.split.test.len());
    let made = match campaign.split.made {
        0 => String::new(),
        n => format!(" ({n} of them made between those of the file)"),
    };
    let what = format!(
        "target: {goal}, over {gate} gate views{made}, which decide; {test} test views are only \
         reported"
    );
    out::complain(wrapped(&what, 80));
    if let Some(sizes) = sizes(&campaign.judged) {
        out::complain(wrapped(&sizes, 80));
    }
    let by = campaign.counted.by_what(&campaign.oracle.name());
    let panel = campaign.counted.panel(&campaign.display.name);
    let what = format!("power: over {}, by {by}; {panel}", campaign.priced);
    out::complain(wrapped(&what, 80));
}

/// The sizes of what trains and of what is judged, where they are not all that of the power.
fn sizes(judged: &JudgedSize) -> Option<String> {
    let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let JudgedSize { trained, judged, is_priced } = *judged;
    match (is_priced, trained == judged) {
        (true, true) => None,
        (true, false) => Some(format!(
            "sizes: models train at {}; gate and test views are of {}, as power is (--gate-size)",
            size(trained),
            size(judged)
        )),
        (false, _) => Some(format!(
            "sizes: quality is that at {}, power is counted at another size: what is shown there \
             may be worse",
            size(judged)
        )),
    }
}

/// Says how the screens differ from what the cameras see, and which regions no view has.
fn note_screens(campaign: &Campaign, context: &Context) {
    if let Some(foveation) = &campaign.foveation {
        let views = &campaign.power_views;
        gaze::note_width(context, foveation.screens, views);
        gaze::note_missing(context, &missing_regions(foveation.screens, views));
    }
}
