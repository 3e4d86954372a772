//! Display power of an image: channel means of linear RGB times a panel's coefficients.
//!
//! `P = scale (R red + G green + B blue) + static`, where R, G, B are the means over all pixels of
//! the linearised sRGB channels. Values above 1 count (renders are not clamped); values below 0
//! count as 0. Source: `powergs`, `d22`.

pub mod d22;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::config::embedded::DISPLAYS;
use powergs_base::config::{self, ConfigError, layer};
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
    /// Where the numbers are from: a key of `references.toml`, an assumption number, or words.
    pub source: String,
}

impl Display {
    /// Reads and checks a display preset.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line.
    pub fn parse(text: &str) -> Result<Display, ConfigError> {
        let text = &layer::on_embedded(text, DISPLAYS)?;
        let config = config::parse::<Display>(text, &[])?;
        let display = &config.value;
        let mut problems = Vec::new();
        if display.source.trim().is_empty() {
            let message =
                "`source` is empty: say where the numbers are from, e.g. \"own measurement\"";
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

    /// Watts of full R, G, B above black.
    pub fn coefficients(&self) -> [f64; 3] {
        [self.red, self.green, self.blue].map(|k| self.scale * k.0)
    }
}
