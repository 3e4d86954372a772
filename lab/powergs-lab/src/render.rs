//! `render`: what the arithmetic of the hardware makes of pictures.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use serde_json::{Map, Value, json};

use crate::{render_datapath, render_hardware};
use powergs_base::picture::Picture;
use powergs_datapath::{Form, NumberFormat, Vrc};
use powergs_quality::{Likeness, flip, likeness};
use powergs_raster::{Detail, Options, render};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::files::{is_foveated, open_model};
use powergs_scene::{Camera, Gaussians};
use powergs_sim::cli::background::Background;
use powergs_sim::cli::camera_file::CameraArgs;
use powergs_sim::cli::output_file::Overwrite;
use powergs_sim::cli::progress::Progress;
use powergs_sim::cli::render::{check_output, check_sizes, targets, write_png};
use powergs_sim::cli::scene_file::warn;
use powergs_sim::cli::{Context, Exit, Failure, out};

/// Shown under `render --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-lab render scene.ply --orbit 8 --datapath gscore-fp16 -o hardware/
  powergs-lab render scene.ply --cameras cams.json --frames 0..4 \\
      --datapath e4m3 -o e4m3/";

/// The arguments of `render`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The model: PLY, compressed PLY, .splat, .spz, .glb, .sog, or a folder with one
    scene: PathBuf,
    /// Detail of a streamed scene (lod-meta.json), 0 is the finest
    #[arg(long, value_name = "N")]
    detail: Option<u32>,
    #[command(flatten)]
    cameras: CameraArgs,
    /// Background: black, white, or r,g,b from 0 to 1
    #[arg(long, default_value = "black")]
    background: Background,
    /// What draws: gscore-fp16 for all units of rtl/; or the numbers of its rendering cores alone,
    /// such as e5m10, e6m9 or e4m3, with -conic or -mean behind it for another form of splats
    /// (rtl/README.md)
    #[arg(long, value_name = "FORMAT", default_value = GSCORE)]
    datapath: Datapath,
    /// A PNG file for one view, or a folder that gets one PNG per view
    #[arg(long, short, value_name = "PATH")]
    output: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Memory for a pixel of a picture and of the one that it is compared with, bytes.
const PIXEL: u64 = 160;

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    check_output(&args.output)?;
    if is_foveated(&args.scene) {
        let what = format!(
            "{}: the rendering hardware blends one level, and this model has several",
            args.scene.display()
        );
        return Err(Failure::new(Exit::Usage, what));
    }
    let model = open_model(&args.scene, args.detail)?;
    warn(&model, context);
    let scene = &model.gaussians;
    let views = args.cameras.cameras(Some(&args.scene), || SceneBounds::of(scene))?;
    views.warn(context);
    let cameras = views.cameras;
    let files = targets(&args.output, &cameras)?;
    if files.len() < cameras.len() {
        let what = format!("one file, and {} views: name a folder", cameras.len());
        return Err(Failure::new(Exit::Usage, what));
    }
    files.iter().try_for_each(|file| args.overwrite.check(file))?;
    check_sizes(&cameras, PIXEL, context)?;
    let options = Options { background: args.background.0, ..Options::reference(Detail::Image) };
    let progress = Progress::new(context, cameras.len() as u64, "views");
    let mut compared = Vec::new();
    for (camera, file) in cameras.iter().zip(&files) {
        if context.is_cancelled() {
            return Ok(Exit::Interrupted);
        }
        let drawn = args.datapath.render(scene, camera, &options);
        compared.push(Compared::new(&drawn, &render(scene, camera, &options).picture));
        write_png(file, &drawn)?;
        progress.advance(1);
    }
    drop(progress);
    for ((camera, file), compared) in cameras.iter().zip(&files).zip(&compared) {
        if !context.global.json && !context.global.quiet {
            let file = file.display();
            out::text(&format!("{}: {compared} against f32: {file}\n", camera.name))?;
        }
    }
    if context.global.json {
        let row = |((camera, file), compared): ((&Camera, &PathBuf), &Compared)| {
            let mut row = compared.json();
            row.insert("name".into(), json!(camera.name));
            row.insert("file".into(), json!(file.display().to_string()));
            row
        };
        let rows: Vec<_> = cameras.iter().zip(&files).zip(&compared).map(row).collect();
        out::json(&json!({ "images": rows }))?;
    }
    Ok(Exit::Done)
}

/// The name of the hardware of `rtl/` in FP16, from the Gaussian to the pixel.
const GSCORE: &str = "gscore-fp16";
/// Behind a name: the form of the records and of the sum, if not that of `rtl/`.
const FORMS: [(&str, Form); 2] = [("-conic", Form::Conic), ("-mean", Form::Root)];

/// What draws a picture.
#[derive(Debug, Clone)]
pub enum Datapath {
    /// All units, the culling and conversion unit among them.
    Hardware(Vrc),
    /// Rendering cores of a number format behind an exact projection.
    Cores(Vrc),
}

impl FromStr for Datapath {
    type Err = String;

    fn from_str(text: &str) -> Result<Datapath, String> {
        if text == GSCORE {
            let core = Vrc::new(NumberFormat::FP16).expect("FP16 has enough exponent");
            return Ok(Datapath::Hardware(core));
        }
        let other = |(ending, form)| Some((text.strip_suffix(ending)?, form));
        let (name, form) = FORMS.into_iter().find_map(other).unwrap_or((text, Form::Local));
        let format: NumberFormat =
            name.parse().map_err(|error| format!("{error}; or write {GSCORE}"))?;
        let few = || {
            format!("{format}: pixels of a tile need four bits of exponent, as in e5m10 or e4m3")
        };
        Ok(Datapath::Cores(Vrc::new(format).ok_or_else(few)?.with_form(form)))
    }
}

impl Datapath {
    /// The picture that it draws, sorted by depths in FP16 whatever its numbers are.
    pub fn render(&self, scene: &Gaussians, camera: &Camera, options: &Options) -> Picture {
        match self {
            Datapath::Hardware(core) => render_hardware(scene, camera, options, core)
                .expect("a core has enough exponent for the unit before it"),
            Datapath::Cores(core) => {
                render_datapath(scene, camera, options, core, Some(NumberFormat::FP16))
            }
        }
    }
}

/// How like a picture is to that of f32.
pub struct Compared {
    likeness: Likeness,
    flip: f64,
}

impl Compared {
    /// Compares a picture with that of f32.
    pub fn new(drawn: &Picture, reference: &Picture) -> Compared {
        Compared {
            likeness: likeness(drawn, reference),
            flip: flip::flip(reference, drawn, flip::PIXELS_PER_DEGREE),
        }
    }

    /// For scripts.
    pub fn json(&self) -> Map<String, Value> {
        let psnr = self.likeness.psnr_db;
        let names = ["psnr_db", "ssim", "flip"];
        let values =
            [json!(psnr.is_finite().then_some(psnr)), json!(self.likeness.ssim), json!(self.flip)];
        names.map(String::from).into_iter().zip(values).collect()
    }
}

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.likeness.psnr_db {
            db if db.is_finite() => write!(f, "PSNR {db:.2} dB")?,
            _ => f.write_str("equal pictures")?,
        }
        write!(f, ", SSIM {:.6}, FLIP {:.6}", self.likeness.ssim, self.flip)
    }
}
