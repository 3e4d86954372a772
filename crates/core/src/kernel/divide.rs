//! Division by a number that a machine fixes: a shift for powers of two, which most of them are.

/// A divisor above zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Divisor {
    by: u64,
    /// The logarithm of a power of two.
    shift: Option<u32>,
}

impl Divisor {
    /// Divides by `by`.
    ///
    /// # Panics
    /// When `by` is zero.
    pub fn new(by: u64) -> Self {
        assert!(by > 0, "nothing is divided by zero");
        Self { by, shift: by.is_power_of_two().then(|| by.ilog2()) }
    }

    /// The divisor.
    pub fn get(self) -> u64 {
        self.by
    }

    /// `n / by`, rounded up.
    #[inline]
    pub fn div_ceil(self, n: u64) -> u64 {
        match self.shift {
            Some(shift) => (n >> shift) + u64::from(n & (self.by - 1) != 0),
            None => n.div_ceil(self.by),
        }
    }
}
