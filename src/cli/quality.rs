//! `quality`: how like two pictures are.

use std::path::PathBuf;

use serde_json::{Map, Value, json};

use super::background::Background;
use super::gaze::of_picture;
use super::{Context, Exit, Failure, OrExit, lpips_file, out, picture_file};
use powergs_base::picture::Picture;
use powergs_frame::fovea::{EccentricityMap, POOLINGS};
use powergs_quality::{Hvsq, flip, likeness};
use powergs_report::document::Document;

/// Shown under `quality --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim quality render.png photo.png
  powergs-sim quality render.png photo.png --hvsq 1,3,7,12 --json
  powergs-sim quality render.png photo.png --gaze 0.5,0.5 --fov 90
  powergs-sim quality render.png photo.png --lpips-weights alex.safetensors

docs/metrics.md defines every number.";

/// The arguments of `quality`.
#[derive(Debug, clap::Args)]
pub struct PictureQualityArgs {
    /// A picture: PNG, JPEG or WebP
    pub picture: PathBuf,
    /// What it should look like, of the same size
    pub reference: PathBuf,
    /// Also HVSQ, the difference in the periphery, at these pooling sizes in pixels
    #[arg(long, value_name = "P,P,...", value_delimiter = ',', num_args = 1)]
    pub hvsq: Vec<f64>,
    /// Also HVSQ of the regions R1 to R4 around a gaze: shares of width and height, from the upper
    /// left corner
    #[arg(long, value_name = "X,Y", value_parser = super::filter::pair, allow_hyphen_values = true)]
    pub gaze: Option<(f64, f64)>,
    /// Horizontal field of view of the pictures for --gaze, degrees, or powergs (90), wide-100,
    /// wide-110 [default: powergs]
    #[arg(long, value_name = "DEGREES|NAME", allow_hyphen_values = true)]
    #[arg(value_parser = super::gaze::field_of_view)]
    pub fov: Option<f64>,
    /// Pixels per degree of sight for FLIP: 67.02 is a 0.7 m wide 3840-pixel display at 0.7 m
    #[arg(long, value_name = "N", default_value_t = flip::PIXELS_PER_DEGREE)]
    #[arg(value_parser = density)]
    pub pixels_per_degree: f64,
    /// Also LPIPS, with the weights in this safetensors file; docs/metrics.md says how to make it
    #[arg(long, value_name = "FILE")]
    pub lpips_weights: Option<PathBuf>,
    /// What transparent pixels show: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    pub background: Background,
}

fn density(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v| (1.0..=1000.0).contains(v));
    value.ok_or_else(|| "write a number from 1 to 1000".into())
}

/// A measure of the picture.
struct PictureMeasured {
    /// Its name in JSON.
    name: String,
    value: Value,
    /// Its name and value for people.
    shown: (&'static str, String),
}

fn measured(
    name: impl Into<String>,
    value: Value,
    shown: (&'static str, String),
) -> PictureMeasured {
    PictureMeasured { name: name.into(), value, shown }
}

/// Memory for a pixel of the maps that measures make, bytes.
const PIXEL: u64 = 100;

/// Runs `quality`.
pub fn run(args: &PictureQualityArgs, context: &Context) -> Result<Exit, Failure> {
    let (picture, reference) =
        picture_file::read_pair(&args.picture, &args.reference, args.background, PIXEL, context)?;
    let like = likeness(&picture, &reference);
    let flip = flip::flip(&reference, &picture, args.pixels_per_degree);
    let psnr = like.psnr_db.is_finite().then_some(like.psnr_db);
    let shown = psnr.map_or("infinite: equal pictures".into(), |db| format!("{db:.4} dB"));
    let mut rows = vec![
        measured("psnr_db", json!(psnr), ("PSNR", shown)),
        measured("ssim", json!(like.ssim), ("SSIM", format!("{:.6}", like.ssim))),
        measured("flip", json!(flip), ("FLIP", format!("{flip:.6}"))),
        measured("l1", json!(like.l1), ("L1", format!("{:.6}", like.l1))),
        measured("mse", json!(like.mse), ("MSE", error(like.mse))),
    ];
    rows.extend(lpips(args, &picture, &reference)?);
    rows.extend(hvsq(args, &picture, &reference)?);
    rows.extend(regional(args, &picture, &reference, context)?);
    print(args, context, &picture, rows)
}

/// A small number; nothing is just that.
fn error(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.4e}") }
}

/// LPIPS, if there are weights for it.
fn lpips(
    args: &PictureQualityArgs,
    picture: &Picture,
    reference: &Picture,
) -> Result<Option<PictureMeasured>, Failure> {
    let Some(path) = &args.lpips_weights else { return Ok(None) };
    let (lpips, _) = lpips_file::read(path)?;
    let value = lpips.distance(picture, reference);
    let value = value.or_exit(Exit::BadInput, args.picture.display())?;
    let line = ("LPIPS", format!("{value:.6} ({})", lpips.network()));
    Ok(Some(measured("lpips", json!(value), line)))
}

fn hvsq(
    args: &PictureQualityArgs,
    picture: &Picture,
    reference: &Picture,
) -> Result<Vec<PictureMeasured>, Failure> {
    if args.hvsq.is_empty() {
        return Ok(Vec::new());
    }
    let hvsq = Hvsq::new(picture.width, picture.height, &args.hvsq);
    let mut hvsq = hvsq.or_exit(Exit::Usage, "--hvsq")?;
    let reference = hvsq.reference(reference);
    let values = hvsq.values(picture, &reference);
    let row = |(p, value): (&f64, f64)| {
        let line = ("HVSQ", format!("{} at pooling {p}", error(value)));
        measured(format!("hvsq_p{p}"), json!(value), line)
    };
    Ok(args.hvsq.iter().zip(values).map(row).collect())
}

/// HVSQ of the regions around a gaze, each at its pooling size.
fn regional(
    args: &PictureQualityArgs,
    picture: &Picture,
    reference: &Picture,
    context: &Context,
) -> Result<Vec<PictureMeasured>, Failure> {
    let Some((x, y)) = args.gaze else { return Ok(Vec::new()) };
    let size = [picture.width, picture.height];
    let fov_deg = of_picture(args.fov, context);
    let map = EccentricityMap::new([x, y], fov_deg, size).or_exit(Exit::Usage, "--gaze")?;
    let hvsq = Hvsq::new(size[0], size[1], &POOLINGS);
    let mut hvsq = hvsq.or_exit(Exit::BadInput, args.picture.display())?;
    let reference = hvsq.reference(reference);
    let values = hvsq.regional(picture, &reference, &map.regions());
    let row = |(i, value): (usize, Option<f64>)| {
        let shown = value.map_or("no pixels".into(), error);
        let line = ("HVSQ", format!("{shown} in R{}, pooling {}", i + 1, POOLINGS[i]));
        measured(format!("hvsq_r{}", i + 1), json!(value), line)
    };
    Ok(values.into_iter().enumerate().map(row).collect())
}

fn print(
    args: &PictureQualityArgs,
    context: &Context,
    picture: &Picture,
    rows: Vec<PictureMeasured>,
) -> Result<Exit, Failure> {
    if !context.global.json {
        let mut page = Document::new();
        page.facts(rows.into_iter().map(|row| row.shown));
        out::document(&page)?;
        return Ok(Exit::Done);
    }
    let mut object = Map::new();
    object.insert("picture".into(), json!(args.picture.display().to_string()));
    object.insert("reference".into(), json!(args.reference.display().to_string()));
    object.insert("width_px".into(), json!(picture.width));
    object.insert("height_px".into(), json!(picture.height));
    object.extend(rows.into_iter().map(|row| (row.name, row.value)));
    out::json(&Value::Object(object))?;
    Ok(Exit::Done)
}
