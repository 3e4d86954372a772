//! Number formats: binary floating point of 8 to 16 bits in all.
//!
//! As in IEEE 754 there are a sign, a biased exponent and a mantissa without its leading one;
//! exponent field 0 holds zeros and subnormals, the largest one infinities and NaN. There is one
//! NaN, positive with the first bit of the mantissa, whatever it was made of. `e5m10` is binary16.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

mod wide;

pub use wide::{Number, Parts, Rounding, WideFormat};

/// A floating-point format. Its numbers are `u16` of which only the lowest [`bits`](Self::bits)
/// are used. In files it is text: `e5m10`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(try_from = "String", into = "String")]
pub struct NumberFormat(WideFormat);

/// Why a number format cannot be had.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FormatError {
    /// It is not written `e5m10`.
    Spelling(String),
    /// Its bits are out of range: exponent and mantissa.
    Range(u32, u32),
    /// Bits of a wide format that are out of range: exponent and mantissa.
    WideRange(u32, u32),
}

impl fmt::Display for FormatError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            FormatError::Spelling(text) => write!(
                f,
                "`{text}` is not a number format: write the bits of exponent and mantissa, \
                 such as `e5m10` (FP16) or `e4m3`"
            ),
            FormatError::Range(exponent, mantissa) => write!(
                f,
                "e{exponent}m{mantissa} is not a number format of this hardware: with the sign \
                 it may have 8 to 16 bits, 2 to 8 of them exponent and at least one mantissa"
            ),
            FormatError::WideRange(exponent, mantissa) => write!(
                f,
                "e{exponent}m{mantissa} is not a wide number format: with the sign it may have \
                 8 to 32 bits, 2 to 8 of them exponent and at least one mantissa"
            ),
        }
    }
}

impl std::error::Error for FormatError {}

impl TryFrom<String> for NumberFormat {
    type Error = FormatError;

    fn try_from(text: String) -> Result<NumberFormat, FormatError> {
        text.parse()
    }
}

impl From<NumberFormat> for String {
    fn from(format: NumberFormat) -> String {
        format.to_string()
    }
}

impl JsonSchema for NumberFormat {
    fn schema_name() -> Cow<'static, str> {
        "NumberFormat".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "pattern": "^e[2-8]m([1-9]|1[0-3])$",
            "examples": ["e5m10", "e4m3"],
            "x-unit": "number format",
        })
    }
}

impl NumberFormat {
    /// IEEE binary16.
    pub const FP16: NumberFormat = NumberFormat(WideFormat::FP16);

    /// A format of so many bits of exponent and mantissa.
    ///
    /// # Errors
    ///
    /// When it does not have 8 to 16 bits with its sign, 2 to 8 of them exponent.
    pub fn new(exponent: u32, mantissa: u32) -> Result<NumberFormat, FormatError> {
        let wide = WideFormat::new(exponent, mantissa).ok();
        let fits = wide.filter(|wide| wide.bits() <= 16);
        fits.map(NumberFormat).ok_or(FormatError::Range(exponent, mantissa))
    }

    /// The same format as one of those of up to 32 bits.
    pub fn wide(self) -> WideFormat {
        self.0
    }

    /// Bits of the exponent.
    pub fn exponent_bits(self) -> u32 {
        self.0.exponent_bits()
    }

    /// Bits of the mantissa, without the leading one.
    pub fn mantissa_bits(self) -> u32 {
        self.0.mantissa_bits()
    }

    /// Bits of a number.
    pub fn bits(self) -> u32 {
        self.0.bits()
    }

    /// What is added to an exponent.
    pub fn bias(self) -> i32 {
        self.0.bias()
    }

    /// Exponent of the least bit of subnormals.
    pub fn least(self) -> i32 {
        self.0.least()
    }

    /// The sign bit.
    pub fn sign(self) -> u16 {
        self.0.sign() as u16
    }

    /// Positive infinity.
    pub fn infinity(self) -> u16 {
        self.0.infinity() as u16
    }

    /// The one NaN.
    pub fn nan(self) -> u16 {
        self.0.nan() as u16
    }

    /// 1.
    pub fn one(self) -> u16 {
        self.0.one() as u16
    }

    /// The largest finite number.
    pub fn largest(self) -> u16 {
        self.0.largest() as u16
    }

    /// All numbers of the format.
    pub fn all(self) -> impl Iterator<Item = u16> {
        let mask = u16::MAX >> (16 - self.bits());
        0..=mask
    }

    /// Whether a number is NaN.
    pub fn is_nan(self, number: u16) -> bool {
        self.0.is_nan(u32::from(number))
    }

    /// Takes a number apart.
    pub fn unpack(self, number: u16) -> Number {
        self.0.unpack(u32::from(number))
    }

    /// The number of these parts, rounded.
    pub fn round(self, parts: Parts, rounding: Rounding) -> u16 {
        self.0.round(parts, rounding) as u16
    }

    /// The nearest number, even of two that are equally near.
    pub fn from_f64(self, value: f64) -> u16 {
        self.0.from_f64(value) as u16
    }

    /// The nearest number, even of two that are equally near.
    pub fn from_f32(self, value: f32) -> u16 {
        self.0.from_f32(value) as u16
    }

    /// The smallest number that is not less than a positive value.
    pub fn at_least(self, value: f64) -> u16 {
        self.0.at_least(value) as u16
    }

    /// The largest finite number that is not more than a positive value.
    pub fn at_most(self, value: f64) -> u16 {
        self.0.at_most(value) as u16
    }

    /// Its value, exact.
    pub fn to_f64(self, number: u16) -> f64 {
        self.0.to_f64(u32::from(number))
    }

    /// Its value, exact.
    pub fn to_f32(self, number: u16) -> f32 {
        self.0.to_f32(u32::from(number))
    }
}

impl fmt::Display for NumberFormat {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for NumberFormat {
    type Err = FormatError;

    fn from_str(text: &str) -> Result<NumberFormat, FormatError> {
        let bits = |digits: &str| -> Option<u32> {
            let plain = digits.bytes().all(|b| b.is_ascii_digit());
            if plain { digits.parse().ok() } else { None }
        };
        let parts = text.strip_prefix('e').and_then(|rest| rest.split_once('m'));
        let (exponent, mantissa) = parts
            .and_then(|(exponent, mantissa)| Some((bits(exponent)?, bits(mantissa)?)))
            .ok_or_else(|| FormatError::Spelling(text.to_owned()))?;
        NumberFormat::new(exponent, mantissa)
    }
}
