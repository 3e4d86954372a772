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

    /// Factors of the basis functions up to degree 3, in the order of the coefficients, where each
    /// function is written as such a factor times a polynomial of the direction.
    pub const FACTORS: [f32; 16] = [
        0.282_094_8,
        -0.488_602_5,
        0.488_602_5,
        -0.488_602_5,
        1.092_548_4,
        -1.092_548_4,
        0.315_391_57,
        -1.092_548_4,
        0.546_274_2,
        -0.590_043_6,
        2.890_611_4,
        -0.457_045_8,
        0.373_176_34,
        -0.457_045_8,
        1.445_305_7,
        -0.590_043_6,
    ];

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
