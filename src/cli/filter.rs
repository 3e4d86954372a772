//! `filter`: cheaper colours in the periphery of sight.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::gaze::of_picture;
use super::output_file::Overwrite;
use super::picture_file::PictureArgs;
use super::render::write_png;
use super::{Context, Exit, Failure, OrExit, inputs, out};
use powergs_frame::display::d22::{Filter, Gaze};
use powergs_report::format::engineering;

/// Shown under `filter --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim filter frame.png --gaze 0.5,0.5 --fov 90
  powergs-sim filter frame.png --gaze 0.2,0.7 --preset oled-d22 -o out.png

This is the colour filter of Duinkharjav et al. 2022; docs/metrics.md has it.";

/// The arguments of `filter`.
#[derive(Debug, clap::Args)]
pub struct FilterArgs {
    /// The picture and the panel.
    #[command(flatten)]
    pub shown: PictureArgs,
    /// Where somebody looks: shares of width and height, from the upper left corner
    #[arg(long, value_name = "X,Y", default_value = "0.5,0.5", value_parser = pair)]
    #[arg(allow_hyphen_values = true)]
    pub gaze: (f64, f64),
    /// Horizontal field of view of the picture, degrees, or powergs (90), wide-100, wide-110
    /// [default: powergs]
    #[arg(long, value_name = "DEGREES|NAME", allow_hyphen_values = true)]
    #[arg(value_parser = super::gaze::field_of_view)]
    pub fov: Option<f64>,
    /// The PNG file to write [default: IMAGE-d22.png beside the picture]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Whether a file is replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// Reads `x,y`.
pub fn pair(text: &str) -> Result<(f64, f64), String> {
    let parts = text.split_once(',').map(|(x, y)| (x.trim().parse(), y.trim().parse()));
    match parts {
        Some((Ok(x), Ok(y))) => Ok((x, y)),
        _ => Err("write two numbers from 0 to 1: 0.5,0.5".into()),
    }
}

/// `frame-d22.png` for `frame.png`.
fn beside(image: &Path) -> PathBuf {
    let stem = image.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    image.with_file_name(format!("{stem}-d22.png"))
}

/// Memory for a pixel of the filtered picture, bytes.
const PIXEL: u64 = 16;

/// Runs `filter`.
pub fn run(args: &FilterArgs, context: &Context) -> Result<Exit, Failure> {
    let output = args.output.clone().unwrap_or_else(|| beside(&args.shown.image));
    args.overwrite.check(&output)?;
    let fov_deg = of_picture(args.fov, context);
    let gaze = Gaze::new(args.gaze.0, args.gaze.1, fov_deg).or_exit(Exit::Usage, "filter")?;
    let display = inputs::display(&args.shown.preset)?;
    let picture = args.shown.read(PIXEL, context)?;
    let filtered = Filter::new(&display).apply(&picture, &gaze);
    write_png(&output, &filtered)?;
    let [before, after] = [&picture, &filtered].map(|p| display.power(p.mean_linear_rgb()).0);
    let saving = if before > 0.0 { 1.0 - after / before } else { 0.0 };
    if context.global.json {
        out::json(&json!({
            "image": args.shown.image.display().to_string(),
            "file": output.display().to_string(),
            "preset": display.name,
            "gaze": [args.gaze.0, args.gaze.1],
            "fov_deg": fov_deg,
            "power_before_w": before,
            "power_after_w": after,
            "saving": saving,
        }))?;
    } else if !context.global.quiet {
        out::text(&format!(
            "{}: {} before, {} after on {} ({:.1} % saved)\n",
            output.display(),
            engineering(before, "W"),
            engineering(after, "W"),
            display.name,
            100.0 * saving
        ))?;
    }
    Ok(Exit::Done)
}
