//! `render`: images of a scene as PNG.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::aside::write_aside;
use super::background::Background;
use super::camera_file::CameraArgs;
use super::progress::Progress;
use super::{Context, Exit, Failure, OrExit, out, scene_file};
use crate::picture::Picture;
use crate::raster::{Detail, Options, render};
use crate::scene::Camera;
use crate::scene::camera::orbit::SceneBounds;

/// Shown under `render --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim render scene.ply --cameras cameras.json --frame 3 -o frame3.png
  powergs-sim render scene.spz --orbit 8 --size 800x600 -o views/
  powergs-sim render city/lod-meta.json --lod 1 --cameras cameras.json -o views/";

/// The arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The model: PLY, compressed PLY, .splat, .spz, .sog, or a folder with a meta.json
    pub scene: PathBuf,
    /// Level of detail of a streamed scene (lod-meta.json)
    #[arg(long, value_name = "N")]
    pub lod: Option<u32>,
    /// The views.
    #[command(flatten)]
    pub cameras: CameraArgs,
    /// Only this view, counted from 0 after all other selections
    #[arg(long, value_name = "K")]
    pub frame: Option<usize>,
    /// Background: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    pub background: Background,
    /// A PNG file, or a folder that gets one PNG per view
    #[arg(long, short, value_name = "PATH")]
    pub output: PathBuf,
}

/// Runs `render`.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let scene = scene_file::load(&args.scene, args.lod)?;
    scene.warn(context);
    let views = args.cameras.cameras(|| SceneBounds::of(&scene.gaussians))?;
    views.warn(context);
    let cameras = chosen(args, views.cameras)?;
    let targets = targets(&args.output, &cameras)?;
    let options = Options { background: args.background.0, ..Options::reference(Detail::Image) };
    let progress = Progress::new(context, cameras.len() as u64, "views");
    for (camera, target) in cameras.iter().zip(&targets) {
        if context.is_cancelled() {
            return Ok(Exit::Interrupted);
        }
        let rendered = render(&scene.gaussians, camera, &options);
        write_png(target, &rendered.picture)?;
        progress.advance(1);
    }
    drop(progress);
    report(context, &cameras, &targets)
}

fn chosen(args: &Args, mut cameras: Vec<Camera>) -> Result<Vec<Camera>, Failure> {
    let Some(frame) = args.frame else { return Ok(cameras) };
    if frame >= cameras.len() {
        let what = format!("--frame {frame}: there are only {} views, from 0", cameras.len());
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok(vec![cameras.swap_remove(frame)])
}

/// The files to write: `output` itself for one view, else one per view in the folder `output`.
fn targets(output: &Path, cameras: &[Camera]) -> Result<Vec<PathBuf>, Failure> {
    let is_png = output.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if is_png && cameras.len() == 1 {
        return Ok(vec![output.to_path_buf()]);
    }
    if is_png {
        let what = format!(
            "{}: one file for {} views; choose one with --frame, or give a folder",
            output.display(),
            cameras.len()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    std::fs::create_dir_all(output).or_exit(Exit::Usage, output.display())?;
    let digits = (cameras.len() - 1).to_string().len().max(3);
    Ok((0..cameras.len()).map(|i| output.join(format!("{i:0digits$}.png"))).collect())
}

/// Writes `picture` as an 8-bit PNG.
pub fn write_png(path: &Path, picture: &Picture) -> Result<(), Failure> {
    let bytes = picture.to_rgb8();
    write_aside(path, |writer| {
        let encoder = image::codecs::png::PngEncoder::new(writer);
        image::ImageEncoder::write_image(
            encoder,
            &bytes,
            picture.width,
            picture.height,
            image::ExtendedColorType::Rgb8,
        )
        .map_err(std::io::Error::other)
    })
}

fn report(context: &Context, cameras: &[Camera], files: &[PathBuf]) -> Result<Exit, Failure> {
    let rows: Vec<_> = cameras
        .iter()
        .zip(files)
        .map(|(c, file)| {
            json!({
                "name": c.name,
                "width_px": c.width,
                "height_px": c.height,
                "file": file.display().to_string(),
            })
        })
        .collect();
    if context.global.json {
        out::json(&json!({ "images": rows }))?;
        return Ok(Exit::Done);
    }
    if !context.global.quiet {
        let last = files.last().map(|f| f.display().to_string()).unwrap_or_default();
        out::text(&match files.len() {
            1 => format!("{last}\n"),
            n => format!("{n} images, the last one {last}\n"),
        })?;
    }
    Ok(Exit::Done)
}
