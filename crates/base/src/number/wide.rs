//! Floating point of 8 to 32 bits, and the one place where a number of any format is rounded.
//!
//! As in IEEE 754 there are a sign, a biased exponent and a mantissa without its leading one;
//! exponent field 0 holds zeros and subnormals, the largest one infinities and NaN. There is one
//! NaN, positive with the first bit of the mantissa, whatever it was made of. `e8m23` is binary32.

use std::fmt;

use super::FormatError;

/// A floating-point format of up to 32 bits. Its numbers are `u32` of which only the lowest
/// [`bits`](Self::bits) are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct WideFormat {
    exponent: u32,
    mantissa: u32,
}

/// A number taken apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Number {
    /// Not a number.
    Nan,
    /// With its sign.
    Infinity(bool),
    /// Any other.
    Finite(Parts),
}

/// A finite number: `significand` · 2^`exponent`, negative where `sign`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts {
    /// Whether it is negative.
    pub sign: bool,
    /// Power of two that the significand counts in.
    pub exponent: i32,
    /// All bits, with the leading one.
    pub significand: u64,
}

/// Which of the two neighbours a number becomes that lies between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rounding {
    /// The nearer one; the even one of two that are equally near.
    NearestEven,
    /// The one nearer to 0.
    TowardsZero,
    /// The one farther from 0.
    AwayFromZero,
}

impl WideFormat {
    /// A format of so many bits of exponent and mantissa.
    ///
    /// # Errors
    ///
    /// When it does not have 8 to 32 bits with its sign, 2 to 8 of them exponent.
    pub fn new(exponent: u32, mantissa: u32) -> Result<WideFormat, FormatError> {
        let total = exponent.saturating_add(mantissa).saturating_add(1);
        let fits = (2..=8).contains(&exponent) && mantissa >= 1 && (8..=32).contains(&total);
        fits.then_some(WideFormat { exponent, mantissa })
            .ok_or(FormatError::WideRange(exponent, mantissa))
    }

    /// IEEE binary16.
    pub const FP16: WideFormat = WideFormat { exponent: 5, mantissa: 10 };

    /// IEEE binary32.
    pub const FP32: WideFormat = WideFormat { exponent: 8, mantissa: 23 };

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
    pub fn least(self) -> i32 {
        1 - self.bias() - self.mantissa as i32
    }

    /// The sign bit.
    pub fn sign(self) -> u32 {
        1 << (self.bits() - 1)
    }

    /// Positive infinity.
    pub fn infinity(self) -> u32 {
        ((1 << self.exponent) - 1) << self.mantissa
    }

    /// The one NaN.
    pub fn nan(self) -> u32 {
        self.infinity() | 1 << (self.mantissa - 1)
    }

    /// 1.
    pub fn one(self) -> u32 {
        (self.bias() as u32) << self.mantissa
    }

    /// The largest finite number.
    pub fn largest(self) -> u32 {
        self.infinity() - 1
    }

    /// Whether a number is NaN.
    pub fn is_nan(self, number: u32) -> bool {
        self.magnitude(number) > self.infinity()
    }

    /// Without its sign.
    pub fn magnitude(self, number: u32) -> u32 {
        number & (self.sign() - 1)
    }

    /// Takes a number apart.
    pub fn unpack(self, number: u32) -> Number {
        let sign = number & self.sign() != 0;
        let magnitude = self.magnitude(number);
        if magnitude >= self.infinity() {
            let is_infinity = magnitude == self.infinity();
            return if is_infinity { Number::Infinity(sign) } else { Number::Nan };
        }
        let field = (magnitude >> self.mantissa) as i32;
        let leading = u64::from(field > 0) << self.mantissa;
        Number::Finite(Parts {
            sign,
            exponent: self.least() + (field - 1).max(0),
            significand: u64::from(magnitude & ((1 << self.mantissa) - 1)) | leading,
        })
    }

    /// The number of these parts, rounded.
    pub fn round(self, parts: Parts, rounding: Rounding) -> u32 {
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
        sign | magnitude.min(u64::from(most)) as u32
    }

    /// The nearest number, even of two that are equally near.
    pub fn from_f64(self, value: f64) -> u32 {
        self.of_f64(value, Rounding::NearestEven)
    }

    /// The nearest number, even of two that are equally near.
    pub fn from_f32(self, value: f32) -> u32 {
        self.from_f64(f64::from(value))
    }

    /// The smallest number that is not less than a positive value.
    pub fn at_least(self, value: f64) -> u32 {
        self.of_f64(value, Rounding::AwayFromZero)
    }

    /// The largest finite number that is not more than a positive value.
    pub fn at_most(self, value: f64) -> u32 {
        self.of_f64(value, Rounding::TowardsZero)
    }

    fn of_f64(self, value: f64, rounding: Rounding) -> u32 {
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
    pub fn to_f64(self, number: u32) -> f64 {
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
    pub fn to_f32(self, number: u32) -> f32 {
        self.to_f64(number) as f32
    }
}

impl fmt::Display for WideFormat {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "e{}m{}", self.exponent, self.mantissa)
    }
}
