//! The Sobol sequence: points of the unit cube whose every power-of-two first part fills it evenly.
//!
//! Direction numbers after S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better
//! two-dimensional projections" (2008), table `new-joe-kuo-6`; order of the points after Gray. A
//! seed shifts all points by a random exclusive-or, which keeps how evenly they lie.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Bits of a coordinate.
const BITS: usize = 32;

/// Dimensions with direction numbers.
pub const DIMENSIONS_MAX: usize = 32;

/// Of each dimension from the second on: the degree of its primitive polynomial, the polynomial's
/// inner coefficients as bits, and its first direction numbers.
const JOE_KUO: [(u32, u32, &[u32]); DIMENSIONS_MAX - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
    (7, 4, &[1, 3, 7, 13, 13, 15, 69]),
    (7, 7, &[1, 1, 3, 13, 7, 35, 63]),
    (7, 8, &[1, 3, 5, 9, 1, 25, 53]),
    (7, 14, &[1, 3, 1, 13, 9, 35, 107]),
    (7, 19, &[1, 3, 1, 5, 27, 61, 31]),
    (7, 21, &[1, 1, 5, 11, 19, 41, 61]),
    (7, 28, &[1, 3, 5, 3, 3, 13, 69]),
    (7, 31, &[1, 1, 7, 13, 1, 19, 1]),
    (7, 32, &[1, 3, 7, 5, 13, 19, 59]),
    (7, 37, &[1, 1, 3, 9, 25, 29, 41]),
    (7, 41, &[1, 3, 5, 13, 23, 1, 55]),
    (7, 42, &[1, 3, 7, 3, 13, 59, 17]),
];

/// The sequence in some dimensions.
#[derive(Debug, Clone)]
pub struct Sobol {
    directions: Vec<[u32; BITS]>,
    shift: Vec<u32>,
    state: Vec<u32>,
    count: u32,
}

fn directions(dimension: usize) -> [u32; BITS] {
    let Some(&(degree, inner, first)) = dimension.checked_sub(1).map(|d| &JOE_KUO[d]) else {
        return std::array::from_fn(|i| 1 << (BITS - 1 - i));
    };
    let degree = degree as usize;
    let mut v = [0u32; BITS];
    for i in 0..BITS {
        v[i] = if i < degree {
            first[i] << (BITS - 1 - i)
        } else {
            // The recurrence of the primitive polynomial: its inner coefficients, highest first,
            // choose the terms.
            let mut value = v[i - degree] ^ (v[i - degree] >> degree);
            for k in 1..degree {
                if (inner >> (degree - 1 - k)) & 1 == 1 {
                    value ^= v[i - k];
                }
            }
            value
        };
    }
    v
}

impl Sobol {
    /// The sequence in at most [`DIMENSIONS_MAX`] dimensions, shifted by a seed.
    ///
    /// # Panics
    /// With more dimensions.
    pub fn new(dimensions: usize, seed: u64) -> Self {
        let mut random = Pcg64::seed_from_u64(seed);
        let shift = (0..dimensions).map(|_| random.random()).collect();
        Sobol { shift, ..Sobol::plain(dimensions) }
    }

    /// The sequence as published, from the point 0 on.
    ///
    /// # Panics
    /// With more than [`DIMENSIONS_MAX`] dimensions.
    pub fn plain(dimensions: usize) -> Self {
        assert!(
            dimensions <= DIMENSIONS_MAX,
            "{dimensions} dimensions, {DIMENSIONS_MAX} are known"
        );
        let directions = (0..dimensions).map(directions).collect();
        let zero = vec![0; dimensions];
        Sobol { directions, shift: zero.clone(), state: zero, count: 0 }
    }

    /// The next point, each coordinate at least 0 and below 1. After 2^32 points they repeat.
    pub fn next_point(&mut self) -> Vec<f64> {
        let unit = |(state, shift): (&u32, &u32)| f64::from(state ^ shift) / (1u64 << BITS) as f64;
        let point = self.state.iter().zip(&self.shift).map(unit).collect();
        // In Gray code one bit changes from a count to the next: that of its lowest zero.
        let bit = self.count.trailing_ones() as usize;
        self.count = self.count.wrapping_add(1);
        for (state, directions) in self.state.iter_mut().zip(&self.directions) {
            *state = directions.get(bit).map_or(0, |v| *state ^ v);
        }
        point
    }
}
