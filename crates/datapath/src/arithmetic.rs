//! Sums, products and comparisons, rounded to nearest even.

use std::cmp::Ordering;

use super::format::{Number, NumberFormat, Parts, Rounding};

/// Distance of exponents beyond which only the presence of the smaller summand counts: more than
/// the bits of a significand, of its guard and of its rounding bit.
const FAR: u32 = 30;

impl NumberFormat {
    /// a + b.
    pub fn add(self, a: u16, b: u16) -> u16 {
        let (x, y) = match (self.unpack(a), self.unpack(b)) {
            (Number::Finite(x), Number::Finite(y)) => (x, y),
            (Number::Nan, _) | (_, Number::Nan) => return self.nan(),
            (Number::Infinity(x), Number::Infinity(y)) if x != y => return self.nan(),
            (Number::Infinity(_), _) => return a,
            (_, Number::Infinity(_)) => return b,
        };
        // A zero has the least exponent, and never is the summand that is shifted.
        let (high, low) = if x.exponent >= y.exponent { (x, y) } else { (y, x) };
        let distance = high.exponent.abs_diff(low.exponent);
        let (shift, near) = match distance > FAR {
            false => (distance, low.significand),
            true => (FAR, u64::from(low.significand != 0)),
        };
        let signed = |sign: bool, significand: u64| match sign {
            true => -(significand as i64),
            false => significand as i64,
        };
        let sum = signed(high.sign, high.significand << shift) + signed(low.sign, near);
        let sign = if sum == 0 { x.sign && y.sign } else { sum < 0 };
        let parts =
            Parts { sign, exponent: high.exponent - shift as i32, significand: sum.unsigned_abs() };
        self.round(parts, Rounding::NearestEven)
    }

    /// -a; NaN stays what it is.
    pub fn negate(self, a: u16) -> u16 {
        if self.is_nan(a) { self.nan() } else { a ^ self.sign() }
    }

    /// a - b.
    pub fn subtract(self, a: u16, b: u16) -> u16 {
        self.add(a, self.negate(b))
    }

    /// a b.
    pub fn multiply(self, a: u16, b: u16) -> u16 {
        let sign = (a ^ b) & self.sign() != 0;
        let (x, y) = match (self.unpack(a), self.unpack(b)) {
            (Number::Finite(x), Number::Finite(y)) => (x, y),
            (Number::Nan, _) | (_, Number::Nan) => return self.nan(),
            (Number::Finite(x), _) | (_, Number::Finite(x)) if x.significand == 0 => {
                return self.nan();
            }
            _ => return self.infinity() | if sign { self.sign() } else { 0 },
        };
        let parts = Parts {
            sign,
            exponent: x.exponent + y.exponent,
            significand: x.significand * y.significand,
        };
        self.round(parts, Rounding::NearestEven)
    }

    /// Which of two numbers is the larger; `None` with NaN. Zeros of both signs are equal.
    pub fn compare(self, a: u16, b: u16) -> Option<Ordering> {
        if self.is_nan(a) || self.is_nan(b) {
            return None;
        }
        let rank = |number: u16| {
            let magnitude = i32::from(self.magnitude(number));
            if number & self.sign() == 0 { magnitude } else { -magnitude }
        };
        Some(rank(a).cmp(&rank(b)))
    }
}
