//! The `--background` flag.

use std::fmt;
use std::str::FromStr;

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
        let Background([r, g, b]) = self;
        write!(f, "{r},{g},{b}")
    }
}
