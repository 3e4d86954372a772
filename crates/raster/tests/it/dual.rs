//! Numbers that carry a derivative: forward-mode differentiation for the twin.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its derivative by one chosen parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    pub value: f64,
    pub slope: f64,
}

impl Dual {
    pub fn constant(value: f64) -> Dual {
        Dual { value, slope: 0.0 }
    }

    pub fn exp(self) -> Dual {
        let e = self.value.exp();
        Dual { value: e, slope: e * self.slope }
    }

    pub fn sqrt(self) -> Dual {
        let root = self.value.sqrt();
        Dual { value: root, slope: 0.5 * self.slope / root }
    }

    /// The smaller of the two values with its derivative.
    pub fn at_most(self, limit: f64) -> Dual {
        if self.value > limit { Dual::constant(limit) } else { self }
    }

    pub fn at_least(self, limit: f64) -> Dual {
        if self.value < limit { Dual::constant(limit) } else { self }
    }
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, o: Dual) -> Dual {
        Dual { value: self.value + o.value, slope: self.slope + o.slope }
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, o: Dual) -> Dual {
        Dual { value: self.value - o.value, slope: self.slope - o.slope }
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        Dual { value: -self.value, slope: -self.slope }
    }
}

impl Mul for Dual {
    type Output = Dual;
    fn mul(self, o: Dual) -> Dual {
        Dual { value: self.value * o.value, slope: self.slope * o.value + self.value * o.slope }
    }
}

impl Div for Dual {
    type Output = Dual;
    fn div(self, o: Dual) -> Dual {
        let value = self.value / o.value;
        Dual { value, slope: (self.slope - value * o.slope) / o.value }
    }
}

impl Add<f64> for Dual {
    type Output = Dual;
    fn add(self, o: f64) -> Dual {
        Dual { value: self.value + o, ..self }
    }
}

impl Sub<f64> for Dual {
    type Output = Dual;
    fn sub(self, o: f64) -> Dual {
        Dual { value: self.value - o, ..self }
    }
}

impl Mul<f64> for Dual {
    type Output = Dual;
    fn mul(self, o: f64) -> Dual {
        Dual { value: self.value * o, slope: self.slope * o }
    }
}
