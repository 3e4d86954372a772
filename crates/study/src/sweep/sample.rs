//! Which points of a space are taken, chosen beforehand.
//!
//! `grid` and `random` never hold more than they must: a grid is counted, random points are a
//! permutation of the numbers that is computed point by point.

use rand::RngExt;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

use super::file::{Method, Sampling};
use super::lattice::Lattice;
use permutation::Permutation;

mod permutation;
pub mod sobol;

/// Points of a Latin hypercube are drawn together; more than this many are refused to be held.
pub(crate) const HELD_MAX: u64 = 10_000_000;

/// The numbers of the points that are taken, one at a time, none twice.
#[derive(Debug, Clone)]
pub struct Selection {
    lattice: Lattice,
    /// Points still to give.
    left: u64,
    next: u64,
    way: SampleWay,
}

#[derive(Debug, Clone)]
enum SampleWay {
    /// The points `next * points / total`.
    Grid {
        total: u64,
    },
    Random(Permutation),
    List(std::vec::IntoIter<u64>),
    Sobol {
        sequence: sobol::Sobol,
        seen: std::collections::HashSet<u64>,
        tries: u64,
    },
    Nothing,
}

/// The points that `sampling` takes of a lattice.
pub fn select(lattice: &Lattice, sampling: &Sampling) -> Selection {
    let points = lattice.points();
    let wanted = sampling.points.unwrap_or(points).min(points);
    let lattice = lattice.clone();
    let (left, way) = match sampling.method {
        Method::Grid => (wanted, SampleWay::Grid { total: wanted }),
        Method::Random => (wanted, SampleWay::Random(Permutation::new(points, sampling.seed))),
        Method::Lhs => {
            let wanted = wanted.min(HELD_MAX);
            let list = latin(&lattice, wanted, sampling.seed);
            (list.len() as u64, SampleWay::List(list.into_iter()))
        }
        Method::Sobol => {
            let wanted = wanted.min(HELD_MAX);
            let moving = lattice.sides().iter().filter(|s| s.len > 1).count();
            let sequence = sobol::Sobol::new(moving.min(sobol::DIMENSIONS_MAX), sampling.seed);
            let seen = std::collections::HashSet::new();
            // A small space is exhausted long before the sequence hits its last point.
            (wanted, SampleWay::Sobol { sequence, seen, tries: wanted.saturating_mul(64) })
        }
        Method::Nsga2 => (0, SampleWay::Nothing),
    };
    Selection { lattice, left, next: 0, way }
}

impl Iterator for Selection {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        if self.left == 0 {
            return None;
        }
        self.left -= 1;
        let number = self.next;
        self.next += 1;
        let points = self.lattice.points();
        match &mut self.way {
            SampleWay::Grid { total } => {
                // A product of two 64-bit numbers needs more bits than one has.
                let place = u128::from(number) * u128::from(points) / u128::from(*total);
                Some(place as u64)
            }
            SampleWay::Random(permutation) => Some(permutation.at(number)),
            SampleWay::List(list) => list.next(),
            SampleWay::Sobol { sequence, seen, tries } => {
                while *tries > 0 {
                    *tries -= 1;
                    let index = on_lattice(&self.lattice, &sequence.next_point());
                    if seen.insert(index) {
                        return Some(index);
                    }
                }
                self.left = 0;
                None
            }
            SampleWay::Nothing => None,
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        // Points of Sobol sequences and lists may run out earlier.
        (0, usize::try_from(self.left).ok())
    }
}

/// The point of a lattice in whose cell a point of the unit cube lies; axes with one value have no
/// coordinate.
pub(super) fn on_lattice(lattice: &Lattice, unit: &[f64]) -> u64 {
    let mut unit = unit.iter();
    let digit = |len: u32| match len {
        1 => 0,
        _ => ((unit.next().copied().unwrap_or(0.0) * f64::from(len)) as u32).min(len - 1),
    };
    let digits: Vec<u32> = lattice.sides().iter().map(|s| s.len).map(digit).collect();
    lattice.index(&digits)
}

/// `n` points such that every axis shows each of its values equally often, give or take one. A
/// point that comes twice is there once.
fn latin(lattice: &Lattice, n: u64, seed: u64) -> Vec<u64> {
    let mut random = Pcg64::seed_from_u64(seed);
    let n = n as usize;
    let mut indices = vec![0u64; n];
    for side in lattice.sides() {
        let len = u64::from(side.len);
        // Each of `n` strata of the axis once, at a random place of the stratum.
        let mut column: Vec<u32> = (0..n)
            .map(|i| {
                let unit = (i as f64 + random.random::<f64>()) / n as f64;
                ((unit * len as f64) as u32).min(side.len - 1)
            })
            .collect();
        column.shuffle(&mut random);
        // As `Lattice::index` counts: the last axis fastest.
        for (index, digit) in indices.iter_mut().zip(column) {
            *index = *index * len + u64::from(digit);
        }
    }
    let mut seen = std::collections::HashSet::with_capacity(n);
    indices.retain(|index| seen.insert(*index));
    indices
}
