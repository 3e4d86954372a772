//! `render`: images of a scene as PNG.

mod machine;
mod pixels;

use std::path::{Path, PathBuf};

use serde_json::json;

use machine::MachineViewArgs;

use super::output_file::Overwrite;
use super::progress::Progress;
use super::scene_file::{Shown, ShownArgs};
use super::{Context, Exit, Failure, OrExit, gaze, out};
use powergs_base::format::counted;
use powergs_base::picture::Picture;
use powergs_core::run::store::atomic::write_atomically;
use powergs_frame::fovea::ScreenGaze;
use powergs_raster::{Detail, Options, regions, render, render_foveated};
use powergs_scene::Camera;

/// Shown under `render --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim render scene.ply --cameras cameras.json --frame 3 -o frame3.png
  powergs-sim render scene.spz --orbit 8 --size 800x600 -o views/
  powergs-sim render city/lod-meta.json --detail 1 --cameras cams.json -o views/
  powergs-sim render model.fov --cameras cameras.json --gaze 0.5,0.5 -o fr/
  powergs-sim render model.fov --cameras cameras.json --gaze 0.3,0.6 \\
      --levels -o map/
  powergs-sim render scene.ply --cameras path.json --order last -o stale/
  powergs-sim render scene.ply --cameras path.json --order update \\
      --arch neo -o neo/
  powergs-sim render scene.ply --cameras path.json --pixels warped \\
      --arch ls-gaussian -o warped/";

/// The arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct RenderArgs {
    /// A PNG file for one view, the first unless --frame says which; or a folder that gets one PNG
    /// per view
    #[arg(long, short, value_name = "PATH")]
    pub output: PathBuf,
    /// Whether files are replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
    /// What is shown.
    #[command(flatten)]
    pub shown: ShownArgs,
    /// Only this view, counted from 0 after all other selections
    #[arg(long, value_name = "K", help_heading = "Cameras")]
    pub frame: Option<usize>,
    /// Draw the regions R1 to R4 over the image, and a cross at the gaze
    #[arg(long)]
    pub levels: bool,
    /// What a machine makes of them.
    #[command(flatten)]
    pub machine: MachineViewArgs,
}

/// Memory for a pixel while a picture is rendered and written, bytes.
const PIXEL: u64 = 40;

/// Runs `render`.
pub fn run(args: &RenderArgs, context: &Context) -> Result<Exit, Failure> {
    if args.levels && !args.shown.gaze.is_given() {
        let what = "--levels: say where somebody looks, with --gaze, --gaze-cycle or --gaze-stream";
        return Err(Failure::new(Exit::Usage, what));
    }
    check_output(&args.output)?;
    if is_png(&args.output) {
        args.overwrite.check(&args.output)?;
    }
    let background = args.shown.background(context);
    let mut machine = args.machine.open(background)?;
    let (scene, cameras) = args.shown.open(context)?;
    let count = cameras.len();
    if machine.is_some() {
        let given = if args.machine.order.is_some() { "--order" } else { "--pixels" };
        if matches!(scene, Shown::Foveated(_)) {
            let what = format!("{given}: of plain models; leave the gaze out, or {given}");
            return Err(Failure::new(Exit::Usage, what));
        }
        if args.frame.is_some() || is_png(&args.output) {
            let what = format!(
                "{given}: views are frames one after the other, all of which are rendered; name a \
                 folder, and no --frame"
            );
            return Err(Failure::new(Exit::Usage, what));
        }
    }
    if args.frame.is_none() && is_png(&args.output) && count > 1 && !context.global.quiet {
        out::complain(format!(
            "note: one file, so the first of {count} views; --frame K has another, a folder all"
        ));
    }
    let (cameras, gazes) = chosen(args, cameras)?;
    let targets = targets(&args.output, &cameras)?;
    targets.iter().try_for_each(|target| args.overwrite.check(target))?;
    check_sizes(&cameras, PIXEL, context)?;
    let options = Options { background, ..Options::reference(Detail::Image) };
    let mut written = Vec::new();
    let progress = Progress::new(context, cameras.len() as u64, "views");
    if matches!(scene, Shown::Foveated(_)) {
        gaze::note(context, &args.shown.gaze, &cameras, &gazes);
    }
    for ((camera, gaze), target) in cameras.iter().zip(&gazes).zip(&targets) {
        if context.is_cancelled() {
            return Ok(Exit::Interrupted);
        }
        let picture = match (&scene, &mut machine) {
            (Shown::Plain(scene), Some(machine)) => {
                machine.next(&scene.gaussians, camera, args, context)?
            }
            (Shown::Plain(scene), None) => render(&scene.gaussians, camera, &options).picture,
            (Shown::Foveated(model), _) => {
                let frame = render_foveated(model, camera, gaze, &options);
                let picture = frame.or_exit(Exit::Usage, "--gaze")?.picture;
                match args.levels {
                    true => regions::draw(&picture, gaze).or_exit(Exit::Usage, "--gaze")?,
                    false => picture,
                }
            }
        };
        if let Err(failure) = write_png(target, &picture) {
            if !args.overwrite.force {
                // The same command shall find the folder as it was.
                written.iter().for_each(|path: &&PathBuf| {
                    let _ = std::fs::remove_file(path);
                });
            }
            return Err(failure);
        }
        written.push(target);
        progress.advance(1);
    }
    drop(progress);
    match machine {
        Some(machine) => machine.report(context, &targets),
        None => report(context, &cameras, &targets),
    }
}

/// The views, and where the viewer looks in each: the place in the sequence counts, also where only
/// one of them is rendered.
fn chosen(
    args: &RenderArgs,
    mut cameras: Vec<Camera>,
) -> Result<(Vec<Camera>, Vec<ScreenGaze>), Failure> {
    let mut gazes = args.shown.gaze.of_views(&cameras)?;
    let frame = match args.frame {
        Some(frame) => frame,
        // One file can hold one view.
        None if is_png(&args.output) => 0,
        None => return Ok((cameras, gazes)),
    };
    if frame >= cameras.len() {
        let what =
            format!("--frame {frame}: only {} there, from 0", counted(cameras.len(), "view"));
        return Err(Failure::new(Exit::Usage, what));
    }
    Ok((vec![cameras.swap_remove(frame)], vec![gazes.swap_remove(frame)]))
}

fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
}

/// Refuses a file of another kind than PNG. A name with a full stop may still be a folder that is
/// there, or that ends in a slash.
pub fn check_output(path: &Path) -> Result<(), Failure> {
    let is_folder = path.is_dir() || path.as_os_str().as_encoded_bytes().ends_with(b"/");
    match path.extension() {
        Some(ending) if !is_folder && !is_png(path) => {
            let (name, ending) = (path.display(), ending.to_string_lossy());
            let what = format!(
                "{name}: pictures are written as .png, not as .{ending}; name a .png file, or a \
                 folder ({name}/)"
            );
            Err(Failure::new(Exit::Usage, what))
        }
        _ => Ok(()),
    }
}

/// The files to write: `output` itself for one view, else one per view in the folder `output`.
pub fn targets(output: &Path, cameras: &[Camera]) -> Result<Vec<PathBuf>, Failure> {
    if is_png(output) {
        return Ok(vec![output.to_path_buf()]);
    }
    std::fs::create_dir_all(output).or_exit(Exit::Usage, output.display())?;
    let digits = (cameras.len() - 1).to_string().len().max(3);
    Ok((0..cameras.len()).map(|i| output.join(format!("{i:0digits$}.png"))).collect())
}

/// Writes `picture` as an 8-bit PNG.
pub fn write_png(path: &Path, picture: &Picture) -> Result<(), Failure> {
    let bytes = picture.to_rgb8();
    Ok(write_atomically(path, |writer| {
        powergs_pixels::write_png(writer, picture.width, picture.height, &bytes)
    })?)
}

/// What was written.
fn report(context: &Context, cameras: &[Camera], files: &[PathBuf]) -> Result<Exit, Failure> {
    if context.global.json {
        let row = |(c, file): (&Camera, &PathBuf)| {
            json!({
                "name": c.name,
                "width_px": c.width,
                "height_px": c.height,
                "file": file.display().to_string(),
            })
        };
        let rows: Vec<_> = cameras.iter().zip(files).map(row).collect();
        out::json(&json!({ "images": rows }))?;
    } else if !context.global.quiet {
        let last = files.last().map(|f| f.display().to_string()).unwrap_or_default();
        out::text(&match files.len() {
            1 => format!("{last}\n"),
            n => format!("{n} images, the last one {last}\n"),
        })?;
    }
    Ok(Exit::Done)
}

/// Refuses views whose pictures, of so many bytes a pixel, are beyond the budget.
pub fn check_sizes(cameras: &[Camera], pixel: u64, context: &Context) -> Result<(), Failure> {
    cameras.iter().try_for_each(|Camera { name, width, height, .. }| {
        let bytes = u64::from(*width) * u64::from(*height) * pixel;
        context.global.memory.check(bytes).map_err(|over| {
            let what = format!("view {name}: a picture of {width}x{height} pixels {over}");
            Failure::new(Exit::Usage, what)
        })
    })
}
