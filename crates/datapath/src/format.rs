//! Number formats: binary floating point of 8 to 16 bits in all.
//!
//! As in IEEE 754 there are a sign, a biased exponent and a mantissa without its leading one;
//! exponent field 0 holds zeros and subnormals, the largest one infinities and NaN. There is one
//! NaN, positive with the first bit of the mantissa, whatever it was made of. `e5m10` is binary16.

use std::fmt;
use std::str::FromStr;

/// A floating-point format. Its numbers are `u16` of which only the lowest [`bits`](Self::bits)
/// are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NumberFormat {
    exponent: u32,
    mantissa: u32,
}

/// Why a number format cannot be had.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FormatError {
    /// It is not written `e5m10`.
    Spelling(String),
    /// Its bits are out of range: exponent and mantissa.
    Range(u32, u32),
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
        }
    }
}

impl std::error::Error for FormatError {}

/// A number taken apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    Nan,
    /// With its sign.
    Infinity(bool),
    Finite(Parts),
}

/// A finite number: `significand` · 2^`exponent`, negative where `sign`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Parts {
    pub sign: bool,
    pub exponent: i32,
    pub significand: u64,
}

/// Which of the two neighbours a number becomes that lies between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Rounding {
    NearestEven,
    TowardsZero,
    AwayFromZero,
}

impl NumberFormat {
    /// IEEE binary16.
    pub const FP16: NumberFormat = NumberFormat { exponent: 5, mantissa: 10 };

    /// A format of so many bits of exponent and mantissa.
    ///
    /// # Errors
    ///
    /// When it does not have 8 to 16 bits with its sign, 2 to 8 of them exponent.
    pub fn new(exponent: u32, mantissa: u32) -> Result<NumberFormat, FormatError> {
        let total = exponent.saturating_add(mantissa).saturating_add(1);
        let fits = (2..=8).contains(&exponent) && mantissa >= 1 && (8..=16).contains(&total);
        fits.then_some(NumberFormat { exponent, mantissa })
            .ok_or(FormatError::Range(exponent, mantissa))
    }

    /// Bits of the exponent.
    pub fn exponent_bits(self) -> u32 {
        self.exponent
    }

    /// Bits of the mantissa, without the leading one.
    pub fn mantissa_bits(self) -> u32 {
        self.mantissa
    }

    /// Bits of a number.
    pub fn bits(self) -> u32 {
        1 + self.exponent + self.mantissa
    }

    /// What is added to an exponent.
    pub fn bias(self) -> i32 {
        (1 << (self.exponent - 1)) - 1
    }

    /// Exponent of the least bit of subnormals.
    pub(crate) fn least(self) -> i32 {
        1 - self.bias() - self.mantissa as i32
    }

    /// The sign bit.
    pub fn sign(self) -> u16 {
        1 << (self.bits() - 1)
    }

    /// Positive infinity.
    pub fn infinity(self) -> u16 {
        ((1 << self.exponent) - 1) << self.mantissa
    }

    /// The one NaN.
    pub fn nan(self) -> u16 {
        self.infinity() | 1 << (self.mantissa - 1)
    }

    /// 1.
    pub fn one(self) -> u16 {
        (self.bias() as u16) << self.mantissa
    }

    /// The largest finite number.
    pub fn largest(self) -> u16 {
        self.infinity() - 1
    }

    /// All numbers of the format.
    pub fn all(self) -> impl Iterator<Item = u16> {
        let mask = u16::MAX >> (16 - self.bits());
        0..=mask
    }

    /// Whether a number is NaN.
    pub fn is_nan(self, number: u16) -> bool {
        self.magnitude(number) > self.infinity()
    }

    /// Without its sign.
    pub(crate) fn magnitude(self, number: u16) -> u16 {
        number & (self.sign() - 1)
    }

    pub(crate) fn unpack(self, number: u16) -> Number {
        let sign = number & self.sign() != 0;
        let magnitude = self.magnitude(number);
        if magnitude >= self.infinity() {
            let is_infinity = magnitude == self.infinity();
            return if is_infinity { Number::Infinity(sign) } else { Number::Nan };
        }
        let field = i32::from(magnitude >> self.mantissa);
        let leading = u64::from(field > 0) << self.mantissa;
        Number::Finite(Parts {
            sign,
            exponent: self.least() + (field - 1).max(0),
            significand: u64::from(magnitude & ((1 << self.mantissa) - 1)) | leading,
        })
    }

    /// The number of these parts, rounded.
    pub(crate) fn round(self, parts: Parts, rounding: Rounding) -> u16 {
        let Parts { sign, exponent, significand } = parts;
        let sign = if sign { self.sign() } else { 0 };
        if significand == 0 {
            return sign;
        }
        // The exponent of the least bit that is kept.
        let top = exponent + significand.ilog2() as i32;
        let kept = (top - self.mantissa as i32).max(self.least());
        let whole = match u32::try_from(kept - exponent) {
            // Nothing is lost.
            Err(_) | Ok(0) => significand << (exponent - kept),
            Ok(dropped) => {
                let whole = significand.checked_shr(dropped).unwrap_or(0);
                // Twice the remainder against the least bit; beyond 64 bits it is below one half.
                let rest = significand - whole.checked_shl(dropped).unwrap_or(0);
                let half = 1u64.checked_shl(dropped - 1).unwrap_or(u64::MAX);
                let up = match rounding {
                    Rounding::NearestEven => rest > half || (rest == half && whole & 1 == 1),
                    Rounding::TowardsZero => false,
                    Rounding::AwayFromZero => rest > 0,
                };
                whole + u64::from(up)
            }
        };
        // A carry out of the mantissa arrives in the exponent by itself.
        let magnitude = (((kept - self.least()) as u64) << self.mantissa) + whole;
        let most = match rounding {
            Rounding::TowardsZero => self.largest(),
            Rounding::NearestEven | Rounding::AwayFromZero => self.infinity(),
        };
        sign | magnitude.min(u64::from(most)) as u16
    }

    /// The nearest number, even of two that are equally near.
    pub fn from_f64(self, value: f64) -> u16 {
        self.of_f64(value, Rounding::NearestEven)
    }

    /// The nearest number, even of two that are equally near.
    pub fn from_f32(self, value: f32) -> u16 {
        self.from_f64(f64::from(value))
    }

    /// The smallest number that is not less than a positive value.
    pub fn at_least(self, value: f64) -> u16 {
        self.of_f64(value, Rounding::AwayFromZero)
    }

    /// The largest finite number that is not more than a positive value.
    pub fn at_most(self, value: f64) -> u16 {
        self.of_f64(value, Rounding::TowardsZero)
    }

    fn of_f64(self, value: f64, rounding: Rounding) -> u16 {
        if value.is_nan() {
            return self.nan();
        }
        let sign = value.is_sign_negative();
        if value.is_infinite() {
            return self.infinity() | if sign { self.sign() } else { 0 };
        }
        let field = (value.to_bits() >> 52 & 0x7ff) as i32;
        let leading = u64::from(field > 0) << 52;
        let significand = value.to_bits() & ((1 << 52) - 1) | leading;
        self.round(Parts { sign, exponent: field.max(1) - 1075, significand }, rounding)
    }

    /// Its value, exact.
    pub fn to_f64(self, number: u16) -> f64 {
        match self.unpack(number) {
            Number::Nan => f64::NAN,
            Number::Infinity(false) => f64::INFINITY,
            Number::Infinity(true) => f64::NEG_INFINITY,
            Number::Finite(Parts { sign, exponent, significand }) => {
                let unit = f64::from_bits(((exponent + 1023) as u64) << 52);
                let value = significand as f64 * unit;
                if sign { -value } else { value }
            }
        }
    }

    /// Its value, exact.
    pub fn to_f32(self, number: u16) -> f32 {
        self.to_f64(number) as f32
    }
}

impl fmt::Display for NumberFormat {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "e{}m{}", self.exponent, self.mantissa)
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
