//! `quality`: how like two pictures are.

use std::path::PathBuf;

use serde_json::{Map, Value, json};

use super::background::Background;
use super::{Context, Exit, Failure, out, picture_file};
use crate::quality::{flip, likeness};

/// Shown under `quality --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim quality render.png photo.png
  powergs-sim quality render.png photo.png --json

docs/metrics.md defines every number.";

/// The arguments of `quality`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A picture: PNG, JPEG or WebP
    pub picture: PathBuf,
    /// What it should look like, of the same size
    pub reference: PathBuf,
    /// Pixels per degree of sight for FLIP: 67.02 is a 0.7 m wide 3840-pixel display at 0.7 m
    #[arg(long, value_name = "N", default_value_t = flip::PIXELS_PER_DEGREE, value_parser = density)]
    pub pixels_per_degree: f64,
    /// What transparent pixels show: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    pub background: Background,
}

fn density(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v| (1.0..=1000.0).contains(v));
    value.ok_or_else(|| "write a number from 1 to 1000".into())
}

/// A measure: its name in JSON, its value, and its line for people.
type Row = (String, Value, String);

/// Runs `quality`.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let (picture, reference) =
        picture_file::read_pair(&args.picture, &args.reference, args.background)?;
    let like = likeness(&picture, &reference);
    let flip = flip::flip(&reference, &picture, args.pixels_per_degree);
    let psnr = like.psnr_db.is_finite().then_some(like.psnr_db);
    let shown = psnr.map_or("infinite: equal pictures".into(), |db| format!("{db:.4} dB"));
    let rows: Vec<Row> = vec![
        ("psnr_db".into(), json!(psnr), format!("PSNR  {shown}")),
        ("ssim".into(), json!(like.ssim), format!("SSIM  {:.6}", like.ssim)),
        ("flip".into(), json!(flip), format!("FLIP  {flip:.6}")),
        ("l1".into(), json!(like.l1), format!("L1    {:.6}", like.l1)),
        ("mse".into(), json!(like.mse), format!("MSE   {:.4e}", like.mse)),
    ];
    print(args, context, (picture.width, picture.height), rows)
}

fn print(
    args: &Args,
    context: &Context,
    (width, height): (u32, u32),
    rows: Vec<Row>,
) -> Result<Exit, Failure> {
    if !context.global.json {
        let lines: String = rows.iter().map(|row| format!("{}\n", row.2)).collect();
        out::text(&lines)?;
        return Ok(Exit::Done);
    }
    let mut object = Map::new();
    object.insert("picture".into(), json!(args.picture.display().to_string()));
    object.insert("reference".into(), json!(args.reference.display().to_string()));
    object.insert("width_px".into(), json!(width));
    object.insert("height_px".into(), json!(height));
    object.extend(rows.into_iter().map(|(name, value, _)| (name, value)));
    out::json(&Value::Object(object))?;
    Ok(Exit::Done)
}
