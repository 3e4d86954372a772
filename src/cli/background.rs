//! The `--background` flag, and what the folder of a training run says in its place.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::{Context, out};
use powergs_scene::files::{RunBackground, background_of};

/// A background colour, sRGB 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Background(pub [f32; 3]);

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "black" => return Ok(Background([0.0; 3])),
            "white" => return Ok(Background([1.0; 3])),
            _ => {}
        }
        let parts: Result<Vec<f32>, _> = text.split(',').map(|p| p.trim().parse()).collect();
        match parts.as_deref() {
            Ok(&[r, g, b]) if [r, g, b].iter().all(|v| (0.0..=1.0).contains(v)) => {
                Ok(Background([r, g, b]))
            }
            _ => Err("write black, white, or three numbers from 0 to 1: 0.5,0.5,0.5".into()),
        }
    }
}

impl fmt::Display for Background {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Background([0.0, 0.0, 0.0]) => f.write_str("black"),
            Background([1.0, 1.0, 1.0]) => f.write_str("white"),
            Background([r, g, b]) => write!(f, "{r},{g},{b}"),
        }
    }
}

/// The background that a model is shown over, and which file says so, if no flag does.
#[derive(Debug, Clone, PartialEq)]
pub struct ShownBackground {
    /// The colour.
    pub colour: Background,
    file: Option<PathBuf>,
}

impl ShownBackground {
    /// What a flag says, or else the training run that the first of these paths with one belongs
    /// to: a model, its cameras. Otherwise black.
    pub fn of(flag: Option<Background>, places: &[Option<&Path>]) -> ShownBackground {
        if let Some(colour) = flag {
            return ShownBackground { colour, file: None };
        }
        match places.iter().copied().flatten().find_map(background_of) {
            Some(RunBackground { colour, file }) => {
                ShownBackground { colour: Background(colour), file: Some(file) }
            }
            None => ShownBackground { colour: Background([0.0; 3]), file: None },
        }
    }

    /// The colour, sRGB; says so where it is another than without a run.
    pub fn said(self, context: &Context) -> [f32; 3] {
        let Background(colour) = self.colour;
        if let Some(file) = self.file.filter(|_| colour != [0.0; 3] && !context.global.quiet) {
            out::complain(format_args!(
                "note: the background is {}, over which the model was trained ({}); --background \
                 has another",
                self.colour,
                file.display()
            ));
        }
        colour
    }
}
