//! `--datapath`: what the arithmetic of rendering hardware makes of a picture.

use std::fmt;
use std::str::FromStr;

use serde_json::{Map, Value, json};

use powergs_base::picture::Picture;
use powergs_datapath::{Form, NumberFormat, Vrc};
use powergs_quality::{Likeness, flip, likeness};
use powergs_raster::{Options, render_datapath, render_hardware};
use powergs_scene::{Camera, Gaussians};

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
