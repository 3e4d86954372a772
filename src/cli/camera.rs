//! `camera info` and `camera convert`: what a camera file holds, and views written as INRIA
//! `cameras.json`.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::camera_file::{self, CameraArgs};
use super::output_file::{self, Overwrite};
use super::{Context, Exit, Failure, out};
use powergs_base::format::counted;
use powergs_core::run::store::atomic::write_atomically;
use powergs_report::document::Document;
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::camera::{CameraFile, inria};
use powergs_scene::files::open_cameras;
use powergs_scene::{Camera, Split};

/// Examples at the end of the help.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim camera info cameras.json
  powergs-sim camera convert --cameras transforms.json --path-frames 120 \\
      -o path.json
  powergs-sim camera convert --cameras sparse/0 --stereo 0.064 -o eyes.json";

/// Inspect camera files, convert them, make paths
#[derive(Debug, clap::Args)]
pub struct CameraCommandArgs {
    #[command(subcommand)]
    command: CameraCommand,
}

#[derive(Debug, clap::Subcommand)]
enum CameraCommand {
    /// Print how many views a file has, their sizes and fields of view, and warnings
    Info {
        /// cameras.json, transforms.json, a camera path, or a folder with one or COLMAP's files
        file: PathBuf,
        /// Image size where the file does not say it, pixels
        #[arg(long, value_name = "WxH", value_parser = camera_file::image_size)]
        size: Option<(u32, u32)>,
    },
    /// Write the views that the camera flags ask for as an INRIA cameras.json
    Convert {
        /// File to write
        #[arg(long, short)]
        output: PathBuf,
        #[command(flatten)]
        overwrite: Overwrite,
        #[command(flatten)]
        cameras: Box<CameraArgs>,
    },
}

/// Runs the command.
pub fn run(args: &CameraCommandArgs, context: &Context) -> Result<Exit, Failure> {
    match &args.command {
        CameraCommand::Info { file, size } => {
            let facts = facts(&open_cameras(file, *size, None)?);
            if context.global.json { out::json(&facts)? } else { out::document(&document(&facts))? }
        }
        CameraCommand::Convert { cameras, output, overwrite } => {
            overwrite.check(output)?;
            // Without a scene an orbit goes around the origin.
            let views =
                cameras.cameras(None, || SceneBounds { centre: glam::DVec3::ZERO, extent: 1.0 })?;
            views.warn(context);
            let text = inria::write(&views.cameras);
            write_atomically(output, |w| w.write_all(text.as_bytes()))?;
            let count = views.cameras.len();
            if context.global.json {
                out::json(&json!({ "views": count, "format": views.format }))?;
            } else {
                output_file::say(output, format_args!("{}", counted(count, "view")), context)?;
            }
        }
    }
    Ok(Exit::Done)
}

/// The facts, with the names of the JSON output.
fn facts(views: &CameraFile) -> Value {
    let cameras = &views.cameras;
    let range = |value: &dyn Fn(&Camera) -> f64| {
        let values = cameras.iter().map(value);
        let (min, max) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        json!({ "min": min, "max": max })
    };
    let in_split = |split| cameras.iter().filter(|c| c.split == Some(split)).count();
    json!({
        "format": views.format,
        "views": cameras.len(),
        "train_views": in_split(Split::Train),
        "test_views": in_split(Split::Test),
        "width_px": range(&|c| f64::from(c.width)),
        "height_px": range(&|c| f64::from(c.height)),
        "vertical_fov_deg": range(&|c| c.vertical_fov().to_degrees()),
        "x": range(&|c| c.centre.x),
        "y": range(&|c| c.centre.y),
        "z": range(&|c| c.centre.z),
        "warnings": views.warnings.iter().chain(&views.doubts).collect::<Vec<_>>(),
    })
}

/// The facts for people.
fn document(facts: &Value) -> Document {
    let fact = |(name, value): (&String, &Value)| {
        let value = match value {
            Value::Object(range) => {
                let end = |key: &str| range.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN);
                let (min, max) = (end("min"), end("max"));
                let digits = if name.ends_with("_px") { 0 } else { 4 };
                let low = format!("{min:.digits$}");
                if min == max { low } else { format!("{low} to {max:.digits$}") }
            }
            Value::Array(warnings) if warnings.is_empty() => "none".to_string(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        (name.clone(), value)
    };
    let mut page = Document::new();
    page.facts(facts.as_object().into_iter().flatten().map(fact));
    page
}
