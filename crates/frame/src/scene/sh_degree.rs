//! The degree of a scene's spherical harmonics (SH).

use std::fmt;

/// Degree of the spherical harmonics of a scene, 0 to 3.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShDegree(u8);

impl ShDegree {
    /// Colours that do not depend on the direction.
    pub const ZERO: ShDegree = ShDegree(0);
    /// The highest degree that is used: that of published models, and what a trace that does not
    /// say its degree counts as.
    pub const MAX: ShDegree = ShDegree(3);
    /// All degrees, ascending.
    pub const ALL: [ShDegree; 4] = [ShDegree(0), ShDegree(1), ShDegree(2), ShDegree(3)];

    /// A degree of 0 to 3; `None` above.
    pub const fn new(degree: u8) -> Option<ShDegree> {
        if degree <= Self::MAX.0 { Some(ShDegree(degree)) } else { None }
    }

    /// The degree as a number, 0 to 3.
    pub const fn get(self) -> u8 {
        self.0
    }

    /// Coefficients per colour channel: `(degree + 1)²`.
    pub const fn coefficients(self) -> u64 {
        let n = self.0 as u64 + 1;
        n * n
    }
}

impl fmt::Display for ShDegree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
