//! Sums, products and comparisons of numbers of any format, rounded to nearest even.

use std::cmp::Ordering;

use crate::exponential;
use powergs_base::number::{Number, NumberFormat, Parts, Rounding, WideFormat};

/// Distance of exponents beyond which only the presence of the smaller summand counts: more than
/// the bits of a significand, of its guard and of its rounding bit.
const FAR: u32 = 30;

/// What the operators of `rtl/` make of the numbers of a format; `N` holds one.
pub trait Arithmetic<N> {
    /// a + b.
    fn add(self, a: N, b: N) -> N;
    /// -a; NaN stays what it is.
    fn negate(self, a: N) -> N;
    /// a - b.
    fn subtract(self, a: N, b: N) -> N;
    /// a b.
    fn multiply(self, a: N, b: N) -> N;
    /// Which of two numbers is the larger; `None` with NaN. Zeros of both signs are equal.
    fn compare(self, a: N, b: N) -> Option<Ordering>;
}

impl Arithmetic<u32> for WideFormat {
    fn add(self, a: u32, b: u32) -> u32 {
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

    fn negate(self, a: u32) -> u32 {
        if self.is_nan(a) { self.nan() } else { a ^ self.sign() }
    }

    fn subtract(self, a: u32, b: u32) -> u32 {
        self.add(a, self.negate(b))
    }

    fn multiply(self, a: u32, b: u32) -> u32 {
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

    fn compare(self, a: u32, b: u32) -> Option<Ordering> {
        if self.is_nan(a) || self.is_nan(b) {
            return None;
        }
        let rank = |number: u32| {
            let magnitude = i64::from(self.magnitude(number));
            if number & self.sign() == 0 { magnitude } else { -magnitude }
        };
        Some(rank(a).cmp(&rank(b)))
    }
}

impl Arithmetic<u16> for NumberFormat {
    fn add(self, a: u16, b: u16) -> u16 {
        self.wide().add(u32::from(a), u32::from(b)) as u16
    }

    fn negate(self, a: u16) -> u16 {
        self.wide().negate(u32::from(a)) as u16
    }

    fn subtract(self, a: u16, b: u16) -> u16 {
        self.wide().subtract(u32::from(a), u32::from(b)) as u16
    }

    fn multiply(self, a: u16, b: u16) -> u16 {
        self.wide().multiply(u32::from(a), u32::from(b)) as u16
    }

    fn compare(self, a: u16, b: u16) -> Option<Ordering> {
        self.wide().compare(u32::from(a), u32::from(b))
    }
}

/// The power of the rendering core.
pub trait Exponential {
    /// 2^-|x|: 1 of both zeros, 0 of both infinities.
    fn exp2_negative(self, x: u16) -> u16;
}

impl Exponential for NumberFormat {
    fn exp2_negative(self, x: u16) -> u16 {
        exponential::exp2_negative(self, x)
    }
}
