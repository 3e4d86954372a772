//! `extract`: a scene and its views become a trace.
//!
//! Frames are rendered one after another, each on all threads, and written as they come: memory
//! does not grow with the length of the trace. While one frame is compressed the next is rendered.

use std::io::BufWriter;
use std::path::{Path, PathBuf};

use serde_json::json;
use tempfile::NamedTempFile;

use super::background::Background;
use super::camera_file::CameraArgs;
use super::gaze::{GazeArgs, note_default, note_missing};
use super::progress::Progress;
use super::scene_file::Shown;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_core::run::store::atomic::temporary;
use powergs_frame::fovea::ScreenGaze;
use powergs_frame::trace::{ColumnGroup, EncodedFrame, Frame, FrameFault, TraceHeader, Writer};
use powergs_raster::{Detail, Options, render, render_foveated};
use powergs_scene::Camera;
use powergs_scene::camera::orbit::SceneBounds;

/// Shown under `extract --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim extract scene.ply --cameras cameras.json -o scene.bin
  powergs-sim extract scene.ply --cameras cameras.json --size 1920x1080 --every 8 -o hd.bin
  powergs-sim extract scene.spz --orbit 90 --size 800x800 -o orbit.bin
  powergs-sim extract scene.ply --cameras cameras.json --path-frames 1350 -o path.bin
  powergs-sim extract model.fov --cameras cameras.json --gaze-cycle 9 -o fr.bin

Then: powergs-sim replay scene.bin";

/// The arguments of `extract`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The model: PLY, compressed PLY, .splat, .spz, .sog, .fov, or a folder with a meta.json
    pub scene: PathBuf,
    /// Level of detail of a streamed scene (lod-meta.json)
    #[arg(long, value_name = "N")]
    pub lod: Option<u32>,
    /// The views.
    #[command(flatten)]
    pub cameras: CameraArgs,
    /// Background: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    pub background: Background,
    /// Where somebody looks.
    #[command(flatten)]
    pub gaze: GazeArgs,
    /// The trace file
    #[arg(long, short, value_name = "FILE")]
    pub output: PathBuf,
}

/// Runs `extract`.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let scene = Shown::open(&args.scene, args.lod, &args.gaze, context)?;
    let views = args.cameras.cameras(|| SceneBounds::of(scene.base()))?;
    views.warn(context);
    let gazes = args.gaze.of_views(&views.cameras)?;
    if matches!(scene, Shown::Foveated(_)) {
        note_default(context, &args.gaze);
        note_missing(context, &views.cameras, &gazes);
    }
    let name = stem(&args.scene);
    let mut job = Job::new(args, &name, scene.base().len() as u64)?;
    let options = Options { background: args.background.0, ..Options::reference(Detail::Counters) };
    let progress = Progress::new(context, views.cameras.len() as u64, "frames");
    let mut pending: Option<Frame> = None;
    for (camera, gaze) in views.cameras.iter().zip(&gazes) {
        if context.is_cancelled() {
            break;
        }
        let (encoded, frame) = rayon::join(
            || pending.as_ref().map(EncodedFrame::encode),
            || frame_of(&scene, camera, gaze, &options),
        );
        job.write(encoded)?;
        pending = Some(frame?);
        progress.advance(1);
    }
    job.write(pending.as_ref().map(EncodedFrame::encode))?;
    drop((progress, pending));
    job.finish(args, context, views.cameras.len())
}

fn frame_of(
    scene: &Shown,
    camera: &Camera,
    gaze: &ScreenGaze,
    options: &Options,
) -> Result<Frame, Failure> {
    match scene {
        Shown::Plain(scene) => {
            let rendered = render(&scene.gaussians, camera, options);
            Ok(rendered.into_frame(camera, options.background))
        }
        Shown::Foveated(model) => {
            let frame = render_foveated(model, camera, gaze, options);
            Ok(frame.or_exit(Exit::Usage, "--gaze")?.into_frame(camera, options.background))
        }
    }
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

/// A trace being written beside its final place.
struct Job {
    writer: Writer<BufWriter<NamedTempFile>>,
    splats: u64,
    splat_bytes: u64,
    pixels: u64,
    pixel_bytes: u64,
}

impl Job {
    fn new(args: &Args, name: &str, points: u64) -> Result<Job, Failure> {
        let file = temporary(&args.output)
            .or_exit(Exit::Usage, format_args!("{}: cannot be written", args.output.display()))?;
        let header = TraceHeader {
            generator: concat!("powergs-sim ", env!("CARGO_PKG_VERSION")).to_owned(),
            scene: name.to_owned(),
            points,
        };
        let writer = Writer::new(BufWriter::new(file), &header)
            .or_exit(Exit::Usage, args.output.display())?;
        Ok(Job { writer, splats: 0, splat_bytes: 0, pixels: 0, pixel_bytes: 0 })
    }

    fn write(&mut self, frame: Option<Result<EncodedFrame, FrameFault>>) -> Result<(), Failure> {
        let Some(frame) = frame else { return Ok(()) };
        let frame = frame.or_exit(Exit::Internal, "a rendered frame is not a valid trace frame")?;
        let camera = &frame.facts().camera;
        self.pixels += u64::from(camera.width) * u64::from(camera.height);
        let info = self.writer.write_encoded(frame).or_exit(Exit::Usage, "writing the trace")?;
        self.splats += u64::from(info.head.splats);
        self.splat_bytes += info.stored_bytes(ColumnGroup::Splat);
        self.pixel_bytes += info.stored_bytes(ColumnGroup::Pixel);
        Ok(())
    }

    /// Puts the finished file in its place. One that was interrupted is a valid trace of the frames
    /// that were done, under a name that says so.
    fn finish(self, args: &Args, context: &Context, wanted: usize) -> Result<Exit, Failure> {
        let done = self.writer.len();
        let complete = done == wanted as u64;
        if done == 0 {
            out::complain("interrupted before the first frame was done: nothing written");
            return Ok(Exit::Interrupted);
        }
        let path = if complete {
            args.output.clone()
        } else {
            args.output.with_extension("INCOMPLETE.bin")
        };
        let place = || format!("{}: cannot be written", path.display());
        let buffer = self.writer.finish().or_exit(Exit::Usage, place())?;
        let file = buffer.into_inner().map_err(|e| e.into_error()).or_exit(Exit::Usage, place())?;
        let bytes = file.as_file().metadata().or_exit(Exit::Usage, place())?.len();
        file.persist(&path).or_exit(Exit::Usage, place())?;
        let per = |bytes: u64, n: u64| bytes as f64 / n.max(1) as f64;
        let (splat, pixel) =
            (per(self.splat_bytes, self.splats), per(self.pixel_bytes, self.pixels));
        if context.global.json {
            out::json(&json!({
                "file": path.display().to_string(),
                "incomplete": !complete,
                "frames": done,
                "bytes": bytes,
                "visible_splats": self.splats,
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
                "{note}{}: {done} frames, {:.1} MB\n\
                 {splat:.1} bytes a visible splat, {pixel:.2} bytes a pixel\n",
                path.display(),
                bytes as f64 * 1e-6
            ))?;
        }
        Ok(if complete { Exit::Done } else { Exit::Interrupted })
    }
}
