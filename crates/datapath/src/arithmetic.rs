//! Sums, products and comparisons, rounded to nearest even: those of [`WideFormat`](super::wide).

use std::cmp::Ordering;

use super::format::NumberFormat;

impl NumberFormat {
    /// a + b.
    pub fn add(self, a: u16, b: u16) -> u16 {
        self.wide().add(u32::from(a), u32::from(b)) as u16
    }

    /// -a; NaN stays what it is.
    pub fn negate(self, a: u16) -> u16 {
        self.wide().negate(u32::from(a)) as u16
    }

    /// a - b.
    pub fn subtract(self, a: u16, b: u16) -> u16 {
        self.wide().subtract(u32::from(a), u32::from(b)) as u16
    }

    /// a b.
    pub fn multiply(self, a: u16, b: u16) -> u16 {
        self.wide().multiply(u32::from(a), u32::from(b)) as u16
    }

    /// Which of two numbers is the larger; `None` with NaN. Zeros of both signs are equal.
    pub fn compare(self, a: u16, b: u16) -> Option<Ordering> {
        self.wide().compare(u32::from(a), u32::from(b))
    }
}
