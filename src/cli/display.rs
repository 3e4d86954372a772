//! `display`: what a picture costs to show.

use powergs_report::document::Document;
use powergs_report::format::engineering;

use serde_json::json;

use super::picture_file::PictureArgs;
use super::{Context, Exit, Failure, inputs, out};

/// Shown under `display --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim display frame.png
  powergs-sim display frame.png --preset oled-d22 --json
  powergs-sim display frame.png --preset my-panel.toml

powergs-sim arch list names the presets; `explain` defines the keys of a panel.";

/// The arguments of `display`.
#[derive(Debug, clap::Args)]
pub struct DisplayArgs {
    /// The picture and the panel.
    #[command(flatten)]
    pub shown: PictureArgs,
}

/// Runs `display`.
pub fn run(args: &DisplayArgs, context: &Context) -> Result<Exit, Failure> {
    let display = inputs::display(&args.shown.preset)?;
    let picture = args.shown.read(0, context)?;
    let mean = picture.mean_linear_rgb();
    let power = display.power(mean);
    let parts: Vec<f64> = display.coefficients().iter().zip(mean).map(|(k, m)| k * m).collect();
    if context.global.json {
        out::json(&json!({
            "image": args.shown.image.display().to_string(),
            "width_px": picture.width,
            "height_px": picture.height,
            "preset": display.name,
            "power_w": power.0,
            "red_w": parts[0],
            "green_w": parts[1],
            "blue_w": parts[2],
            "static_w": display.static_power.0,
            "mean_linear_rgb": mean,
        }))?;
        return Ok(Exit::Done);
    }
    let [r, g, b] = mean;
    let watts = |w: f64| engineering(w, "W");
    let power = format!(
        "{} on {} (red {}, green {}, blue {}, static {})",
        watts(power.0),
        display.name,
        watts(parts[0]),
        watts(parts[1]),
        watts(parts[2]),
        watts(display.static_power.0)
    );
    let mut page = Document::new();
    page.facts([
        ("power", power),
        ("linear mean", format!("red {r:.4}, green {g:.4}, blue {b:.4} of full")),
    ]);
    out::document(&page)?;
    Ok(Exit::Done)
}
