//! Measures with their unit in the type: bytes, hertz, bytes per second, picojoules, watts, volts.
//!
//! In configuration files a quantity is a string with its unit (`"51.2 GB/s"`, `"64 KiB"`,
//! `"1 GHz"`, `"0.53 pJ"`); a bare number is refused. Decimal prefixes are powers of 1000 and
//! `Ki`, `Mi`, `Gi` powers of 1024: `GB/s` is never `GiB/s`.

mod serial;
mod text;

use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul, Sub};

pub use text::{Quantity, QuantityError};

/// Bytes, exact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bytes(pub u64);

/// Energy in picojoules.
#[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd)]
pub struct Picojoules(pub f64);

/// Power in watts.
#[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd)]
pub struct Watts(pub f64);

/// A clock frequency in hertz, positive and finite.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Hertz(pub f64);

/// A transfer rate in bytes per second, positive and finite.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct BytesPerSecond(pub f64);

/// A time in nanoseconds, finite and not negative.
#[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd)]
pub struct Nanoseconds(pub f64);

/// Energy per byte moved, in picojoules per byte, finite and not negative.
#[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd)]
pub struct PicojoulesPerByte(pub f64);

/// Silicon area in mm², finite and not negative.
#[derive(Debug, Clone, Copy, Default, PartialEq, PartialOrd)]
pub struct SquareMillimetres(pub f64);

/// A technology node in nanometres, positive and finite.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Nanometres(pub f64);

/// A supply voltage in volts, positive and finite.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Volts(pub f64);

macro_rules! additive {
    ($($t:ident),*) => {$(
        impl Add for $t { type Output = $t; fn add(self, o: $t) -> $t { $t(self.0 + o.0) } }
        impl Sub for $t { type Output = $t; fn sub(self, o: $t) -> $t { $t(self.0 - o.0) } }
        impl AddAssign for $t { fn add_assign(&mut self, o: $t) { self.0 += o.0 } }
        impl Sum for $t {
            fn sum<I: Iterator<Item = $t>>(i: I) -> $t { i.fold($t::default(), |a, b| a + b) }
        }
    )*};
}
additive!(Bytes, Picojoules, Watts, Nanoseconds, SquareMillimetres);

impl Mul<f64> for Picojoules {
    type Output = Picojoules;
    fn mul(self, k: f64) -> Picojoules {
        Picojoules(self.0 * k)
    }
}
