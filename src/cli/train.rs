//! `train`: a model from photos with poses.

mod inputs;
mod rules;
mod traces;
mod work;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::background::{Background, ShownBackground};
use super::camera_file::image_size;
use super::output_file::Overwrite;
use super::progress::Progress;
use super::{Context, Exit, Failure, OrExit, out};
use inputs::TrainViews;
use powergs_core::run::store::atomic::write_atomically;
use powergs_optimize::train::{HeldOutSeen, TrainInputs, TrainState, Trainer};
use powergs_report::format::wrapped;
use powergs_scene::export::{self, Files, Target};
use powergs_scene::{Gaussians, write_ply};
use rules::RuleArgs;
use traces::{StepTraceArgs, StepTraces};
use work::{CheckpointFile, Worked};

/// Shown under `train --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim train photos/ --cameras sparse/0 -o model.ply
  powergs-sim train photos/ --cameras cameras.json --size 240x135 \\
      --iterations 3000 -o model.ply
  powergs-sim train photos/ --cameras transforms.json --cube 0.3 -o lego.ply
  powergs-sim train photos/ --checkpoint train.ckpt -o model.ply
  powergs-sim train ...the same arguments... --resume
  powergs-sim train photos/ --trace-every 500 --traces steps -o model.ply

Then: powergs-sim replay steps/step-000500.bin --arch gsarch
      powergs-sim optimize model.ply --images photos/ --quality 0.99";

/// Random points where nothing else is there to start from: the published number.
const POINTS: usize = 100_000;
/// Half the width of their cube, in extents of the cameras: that of gsplat.
const CUBE: f64 = 3.0;

/// The arguments of `train`.
#[derive(Debug, clap::Args)]
pub struct TrainArgs {
    /// Folder of the photos: PNG, JPEG or WebP, named as the views
    photos: PathBuf,
    /// The model to write: .ply as 3DGS writes it, .compressed.ply, .spz, .gltf, .glb or .sog
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
    #[command(flatten)]
    views: PhotoViewArgs,
    #[command(flatten)]
    start: StartArgs,
    #[command(flatten)]
    rules: RuleArgs,
    #[command(flatten)]
    traces: StepTraceArgs,
    #[command(flatten)]
    run: CheckpointArgs,
}

/// The views that train.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Views")]
struct PhotoViewArgs {
    /// Camera file or folder: COLMAP, transforms.json, cameras.json [default: that of the photos]
    #[arg(long, value_name = "PATH")]
    cameras: Option<PathBuf>,
    /// Size that photos are scaled down to [default: that of the photos]
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    size: Option<(u32, u32)>,
    /// Every K-th view by name is held out, 0 for none [default: as the file says, else 8]
    #[arg(long, value_name = "K")]
    hold_out: Option<usize>,
    /// Background: black, white, or r,g,b from 0 to 1; transparent pixels of photos show it
    #[arg(long, default_value = "black")]
    background: Background,
}

/// The points that it starts from.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Start")]
struct StartArgs {
    /// N random points [default: those of a COLMAP model, else 100000]
    #[arg(long, value_name = "N", conflicts_with = "init")]
    points: Option<NonZeroUsize>,
    /// The points of a PLY with x, y, z and colours
    #[arg(long, value_name = "FILE")]
    init: Option<PathBuf>,
    /// Half the width of the cube of random points around what the cameras look at, in extents of
    /// the cameras [default: 3]; 0.3 for objects that cameras surround
    #[arg(long, value_name = "R", conflicts_with = "init")]
    cube: Option<f64>,
}

/// The checkpoint.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Run")]
struct CheckpointArgs {
    /// File that keeps where the training is: written every minute and on Ctrl-C
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Go on from --checkpoint
    #[arg(long, requires = "checkpoint")]
    resume: bool,
    /// Iterations between reports of the held-out views [default: a tenth of all]
    #[arg(long, value_name = "N")]
    report_every: Option<std::num::NonZeroU32>,
}

/// Runs the command.
pub fn run(args: &TrainArgs, context: &Context) -> Result<Exit, Failure> {
    // What is wrong with the arguments is said before anything is loaded.
    let rules = args.rules.rules()?;
    if let Some(doubt) = args.rules.doubt(&rules) {
        out::complain(wrapped(&doubt, 80));
    }
    let target = target(&args.output)?;
    args.overwrite.check(&args.output)?;
    let is_replaced = args.overwrite.force || args.run.resume;
    if let Some(path) = &args.run.checkpoint {
        super::output_file::check(path, is_replaced)?;
    }
    let traces = args.traces.open(rules.iterations, is_replaced)?;
    let background = background(&args.views, context);
    let views = TrainViews::open(args, background, context)?;
    let start = start(args, &views, rules.max_points, rules.seed, context)?;
    let inputs = TrainInputs {
        cameras: &views.cameras,
        references: &views.images,
        train: &views.train,
        held_out: &views.held_out,
        background,
        rules: &rules,
    };
    let checkpoint =
        CheckpointFile::new(args.run.checkpoint.as_deref(), inputs.fingerprint(&start));
    let state = match args.run.resume {
        true => checkpoint.load()?,
        false => TrainState::begin(&start),
    };
    say_start(&views, &state, context);
    drop(start);
    let trainer = Trainer::new(inputs, state);
    let every = args.run.report_every.map_or((rules.iterations / 10).max(1), |n| n.get());
    let worked = Worked { trainer, checkpoint, views: &views, traces: &traces, every };
    match worked.work(context)? {
        Some(trainer) => finish(args, target, &trainer, &traces, context),
        None => Ok(Exit::Interrupted),
    }
}

/// What the name of the output says, which is a file.
fn target(output: &Path) -> Result<Target, Failure> {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    match Target::of_file_name(&name).filter(|target| *target != Target::SogFolder) {
        Some(target) => Ok(target),
        None => {
            let what = format!(
                "{}: the name says no format that is written; end it in .ply, .compressed.ply, \
                 .spz, .gltf, .glb or .sog",
                output.display()
            );
            Err(Failure::new(Exit::Usage, what))
        }
    }
}

fn background(args: &PhotoViewArgs, context: &Context) -> [f32; 3] {
    ShownBackground::of(Some(args.background), &[]).said(context)
}

/// The Gaussians that it starts from.
fn start(
    args: &TrainArgs,
    views: &TrainViews,
    most: u64,
    seed: u64,
    context: &Context,
) -> Result<Gaussians, Failure> {
    let points = inputs::points(&args.start, views, most, seed, context)?;
    if points.len() as u64 > most {
        let what = format!(
            "--max-points {most}: the training starts from {} points; give more, or fewer points",
            points.len()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(powergs_optimize::train::start::around(&points.positions, &points.colours))
}

fn say_start(views: &TrainViews, state: &TrainState, context: &Context) {
    if context.global.quiet {
        return;
    }
    let from = match state.iteration {
        0 => format!("from {} points", state.model.scene.len()),
        n => format!("on from iteration {n} with {} Gaussians", state.model.scene.len()),
    };
    let what = format!(
        "training {from}: {} views train, {} are held out",
        views.train.len(),
        views.held_out.len()
    );
    out::complain(wrapped(&what, 80));
}

/// Writes the model and says what it is.
fn finish(
    args: &TrainArgs,
    target: Target,
    trainer: &Trainer<'_>,
    traces: &StepTraces,
    context: &Context,
) -> Result<Exit, Failure> {
    let (path, scene) = (&args.output, trainer.scene());
    if target == Target::Ply {
        write_atomically(path, |mut w| write_ply(scene, &mut w))?;
    } else {
        let written = export::write(scene, target).or_exit(Exit::Usage, path.display())?;
        let Files::One(bytes) = written.files else {
            return Err(Failure::new(Exit::Internal, "a file became a folder"));
        };
        write_atomically(path, |w| w.write_all(&bytes))?;
    }
    let seen = trainer.held_out();
    let is_capped = trainer.state().is_capped;
    if context.global.json {
        out::json(&json!({
            "file": path.display().to_string(),
            "format": target.name(),
            "points": scene.len(),
            "sh_degree": scene.sh_degree,
            "iterations": trainer.state().iteration,
            "held_out": seen,
            "capped": is_capped,
            "traces": traces.files(),
        }))?;
    } else if !context.global.quiet {
        let quality = seen.map_or(String::new(), |seen| format!("; {}", quality(&seen)));
        out::text(&format!(
            "{}: {} Gaussians, SH degree {}{quality}\n",
            path.display(),
            scene.len(),
            scene.sh_degree
        ))?;
    }
    Ok(Exit::Done)
}

/// Quality in words.
fn quality(seen: &HeldOutSeen) -> String {
    let HeldOutSeen { psnr_db, ssim, views } = seen;
    format!("{psnr_db:.2} dB and SSIM {ssim:.4} over {views} held-out views")
}
