//! `extract`: a scene and its views become a trace.

use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use serde_json::json;
use tempfile::NamedTempFile;

use super::output_file::OutputArgs;
use super::progress::{ProgressCounts, WatchedProgress};
use super::scene_file::{OrderArgs, Shown, ShownArgs};
use super::{Context, Exit, Failure, OrExit, gaze, out};
use powergs_base::format::counted;
use powergs_core::run::store::atomic::{persist, temporary};
use powergs_core::run::{Frames, RunError};
use powergs_frame::trace::TraceHeader;
use powergs_study::extract::{Extracted, extract};
use powergs_views::RenderedViews;

/// Shown under `extract --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim extract scene.ply --cameras cameras.json -o scene.bin
  powergs-sim extract scene.ply --cameras cameras.json --size 1920x1080 \\
      --every 8 -o hd.bin
  powergs-sim extract scene.spz --orbit 90 --size 800x800 -o orbit.bin
  powergs-sim extract scene.ply --cameras cameras.json --path-frames 1350 \\
      -o path.bin
  powergs-sim extract scene.ply --cameras cameras.json --order hilbert \\
      -o sorted.bin
  powergs-sim extract model.fov --cameras cameras.json --gaze-cycle 9 -o fr.bin

Then: powergs-sim replay scene.bin";

/// The arguments of `extract`.
#[derive(Debug, clap::Args)]
pub struct ExtractArgs {
    /// The trace.
    #[command(flatten)]
    pub to: OutputArgs,
    /// What is shown.
    #[command(flatten)]
    pub shown: ShownArgs,
    /// In which order Gaussians lie in memory.
    #[command(flatten)]
    pub order: OrderArgs,
}

/// Runs `extract`.
pub fn run(args: &ExtractArgs, context: &Context) -> Result<Exit, Failure> {
    let output = args.to.file()?;
    let (mut scene, cameras) = args.shown.open(context)?;
    args.order.sort_shown(&mut scene);
    let gazes = args.shown.gaze.of_views(&cameras)?;
    if matches!(scene, Shown::Foveated(_)) {
        gaze::note(context, &args.shown.gaze, &cameras, &gazes);
    }
    let header = TraceHeader {
        generator: concat!("powergs-sim ", env!("CARGO_PKG_VERSION")).to_owned(),
        scene: stem(&args.shown.scene),
        points: scene.base().len() as u64,
        order: args.order.order,
    };
    let wanted = cameras.len();
    let frames = match scene {
        Shown::Plain(scene) => {
            RenderedViews::new(&header.scene, Arc::new(scene.gaussians), cameras)
        }
        Shown::Foveated(model) => {
            let views = cameras.into_iter().zip(gazes);
            RenderedViews::foveated(&header.scene, Arc::new(*model), views)
        }
    };
    let mut frames = frames.on_background(args.shown.background(context));
    frames.allow(context.global.memory);
    let file = temporary(output)
        .or_exit(Exit::Usage, format_args!("{}: cannot be written", output.display()))?;
    let watch = WatchedProgress::new(context, ProgressCounts::Frames);
    let trace = extract(&mut frames, &header, BufWriter::new(file), &watch);
    let trace = trace.map_err(|error| match error {
        RunError::Output { message, .. } => {
            let path = output.display();
            Failure::new(Exit::Usage, format!("{path}: cannot be written: {message}"))
        }
        other => other.into(),
    })?;
    drop(watch);
    finish(output, context, trace, wanted)
}

/// The name of a scene: its file or folder without extension.
fn stem(path: &Path) -> String {
    let name = path.file_stem().or(path.file_name()).unwrap_or(path.as_os_str());
    let name = name.to_string_lossy().into_owned();
    // The index file of a folder says nothing; the folder does.
    let folder = path.parent().and_then(Path::file_name);
    match folder.filter(|_| matches!(name.as_str(), "meta" | "lod-meta")) {
        Some(folder) => folder.to_string_lossy().into_owned(),
        None => name,
    }
}

/// Puts the finished file in its place. One that was interrupted is a valid trace of the frames
/// that were done, under a name that says so.
fn finish(
    output: &Path,
    context: &Context,
    trace: Extracted<BufWriter<NamedTempFile>>,
    wanted: usize,
) -> Result<Exit, Failure> {
    let done = trace.frames;
    let complete = done == wanted as u64;
    if done == 0 {
        out::complain("interrupted before the first frame was done: nothing written");
        return Ok(Exit::Interrupted);
    }
    let path = if complete { output.to_owned() } else { output.with_extension("INCOMPLETE.bin") };
    let place = || format!("{}: cannot be written", path.display());
    let file = trace.out.into_inner().map_err(|e| e.into_error()).or_exit(Exit::Usage, place())?;
    let bytes = file.as_file().metadata().or_exit(Exit::Usage, place())?.len();
    persist(file, &path).or_exit(Exit::Usage, place())?;
    let per = |bytes: u64, n: u64| bytes as f64 / n.max(1) as f64;
    let (splat, pixel) =
        (per(trace.splat_bytes, trace.splats), per(trace.pixel_bytes, trace.pixels));
    if context.global.json {
        out::json(&json!({
            "file": path.display().to_string(),
            "incomplete": !complete,
            "frames": done,
            "bytes": bytes,
            "visible_splats": trace.splats,
            "bytes_per_visible_splat": splat,
            "bytes_per_pixel": pixel,
        }))?;
    } else if !context.global.quiet {
        let note = if complete {
            String::new()
        } else {
            format!("INCOMPLETE: {done} of {wanted} frames\n")
        };
        out::text(&format!(
            "{note}{}: {}, {:.1} MB\n\
             {splat:.1} bytes a visible splat, {pixel:.2} bytes a pixel\n",
            path.display(),
            counted(done, "frame"),
            bytes as f64 * 1e-6
        ))?;
    }
    Ok(if complete { Exit::Done } else { Exit::Interrupted })
}
