//! The points of a space as numbers: a mixed-radix count, the last axis fastest.

/// What a point needs to know of an axis to be found, and a search to be a good neighbour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LatticeSide {
    /// How many values it has, at least 1.
    pub len: u32,
    /// Whether neighbouring values are alike: numbers, not names.
    pub ordered: bool,
}

/// All combinations of the values of some axes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lattice {
    sides: Vec<LatticeSide>,
    points: u64,
}

impl Lattice {
    /// The lattice of these axes; `None` if one has no value, or there are more than 2^63 points.
    pub fn new(sides: Vec<LatticeSide>) -> Option<Lattice> {
        let points = sides.iter().try_fold(1u64, |n, side| n.checked_mul(u64::from(side.len)))?;
        (points > 0 && points <= 1 << 63).then_some(Lattice { sides, points })
    }

    /// The axes.
    pub fn sides(&self) -> &[LatticeSide] {
        &self.sides
    }

    /// How many points there are.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// Which value of each axis the point of this number has.
    ///
    /// # Panics
    /// When there is no such point.
    pub fn digits(&self, index: u64) -> Vec<u32> {
        assert!(index < self.points, "point {index} of {}", self.points);
        let mut rest = index;
        let mut digits = vec![0; self.sides.len()];
        for (digit, side) in digits.iter_mut().zip(&self.sides).rev() {
            *digit = (rest % u64::from(side.len)) as u32;
            rest /= u64::from(side.len);
        }
        digits
    }

    /// The number of a point; the inverse of [`Lattice::digits`].
    ///
    /// # Panics
    /// When an axis has no such value.
    pub fn index(&self, digits: &[u32]) -> u64 {
        assert_eq!(digits.len(), self.sides.len(), "a digit per axis");
        digits.iter().zip(&self.sides).fold(0, |index, (&digit, side)| {
            assert!(digit < side.len, "value {digit} of {}", side.len);
            index * u64::from(side.len) + u64::from(digit)
        })
    }
}
