//! Display power of an image: channel means of linear RGB times a panel's coefficients.
//!
//! `P = scale (R red + G green + B blue) + static`, where R, G, B are the means over all pixels of
//! the linearised sRGB channels. Values above 1 count (renders are not clamped); values below 0
//! count as 0. Source: `powergs`, `d22`.

pub mod d22;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::config::{self, ConfigError};
use powergs_base::picture::linear;
use powergs_base::quantity::Watts;

/// A panel as in `arch-configs/display/*.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Display {
    /// Name in reports.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Factor on the coefficients, not on the static power: the luminance boost.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000, "x-unit" = "factor"))]
    pub scale: f64,
    /// Power of full red, before `scale`.
    pub red: Watts,
    /// Power of full green, before `scale`.
    pub green: Watts,
    /// Power of full blue, before `scale`.
    pub blue: Watts,
    /// Power of a black image.
    #[serde(rename = "static")]
    pub static_power: Watts,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

impl Display {
    /// Reads and checks a display preset.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line.
    pub fn parse(text: &str) -> Result<Display, ConfigError> {
        let config = config::parse::<Display>(text, &[])?;
        let display = &config.value;
        let mut problems = Vec::new();
        if !config::references::is_source(&display.source) {
            let message = "`source` is neither a key of references.toml nor an assumption number";
            problems.push(config.problem("source", message.to_owned()));
        }
        if display.coefficients() == [0.0; 3] {
            let message = "`red`, `green` and `blue` are all zero: no image would cost anything";
            problems.push(config.problem("red", message.to_owned()));
        }
        config.checked(problems)
    }

    /// Watts of an image with these means of linear R, G, B.
    pub fn power(&self, mean_linear: [f64; 3]) -> Watts {
        let sum: f64 = self.coefficients().iter().zip(mean_linear).map(|(k, m)| k * m).sum();
        Watts(sum + self.static_power.0)
    }

    /// Watts per unit of the sRGB value of one channel (0 red, 1 green, 2 blue) of one pixel, in
    /// an image of `n_pixels`: the gradient of [`Display::power`].
    pub fn slope(&self, channel: usize, srgb: f64, n_pixels: usize) -> f64 {
        self.coefficients()[channel] * linear_slope(srgb) / n_pixels as f64
    }

    /// Watts of full R, G, B above black.
    pub fn coefficients(&self) -> [f64; 3] {
        [self.red, self.green, self.blue].map(|k| self.scale * k.0)
    }
}

/// Where the sRGB curve changes from a line to a power.
const KNEE: f64 = 0.04045;

/// The derivative of [`linear`]; 0 at and below black.
pub fn linear_slope(srgb: f64) -> f64 {
    match srgb {
        s if s <= 0.0 => 0.0,
        s if s <= KNEE => 1.0 / 12.92,
        s => 2.4 / 1.055 * ((s + 0.055) / 1.055).powf(1.4),
    }
}

/// Means of linear R, G, B of sRGB pixels as rendered, not clamped above 1; black without pixels.
/// The displayed image has `Picture::mean_linear_rgb`.
pub fn mean_linear(pixels: &[[f32; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for pixel in pixels {
        for (total, &value) in sum.iter_mut().zip(pixel) {
            *total += linear(f64::from(value));
        }
    }
    sum.map(|s| s / pixels.len().max(1) as f64)
}
