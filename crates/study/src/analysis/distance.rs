//! How far a design is from the front, and what the front offers instead.

use super::front::{Costs, beats};
use super::knee::KneeScaling;

/// A design that beats another.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Better {
    /// Which one of the costs.
    pub design: usize,
    /// How much smaller each cost is; negative by noise at most.
    pub gains: Vec<f64>,
    /// Euclidean distance of the scaled costs.
    pub distance: f64,
}

/// The distance of a design from the front.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Distance {
    /// The nearest design of the front that beats it by more than noise; `None` if none does: it
    /// is on the front, is alike to a design there, or would be on it.
    pub nearest: Option<Better>,
    /// For every objective the design of the front that gains most there and loses nothing
    /// elsewhere, but for noise; as many as objectives, or none.
    pub best: Vec<Better>,
}

/// The distance of a design with the costs `of` from the front `members`; differences up to the
/// share `epsilon` are noise.
pub fn distance(
    costs: &Costs,
    members: &[usize],
    scaling: &KneeScaling,
    of: &[f64],
    epsilon: f64,
) -> Distance {
    let here = scaling.scaled(of);
    let better = |design: usize| {
        let cost = costs.of(design);
        let there = scaling.scaled(cost);
        let square: f64 = here.iter().zip(&there).map(|(a, b)| (a - b) * (a - b)).sum();
        let gains = of.iter().zip(cost).map(|(a, b)| a - b).collect();
        Better { design, gains, distance: square.sqrt() }
    };
    let beating = members.iter().copied().filter(|&d| beats(costs.of(d), of, epsilon));
    let beating: Vec<Better> = beating.map(better).collect();
    let nearest = beating.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)).cloned();
    let most = |j: usize| {
        // Of equal gains the first: `max_by` would take the last.
        beating.iter().rev().max_by(|a, b| a.gains[j].total_cmp(&b.gains[j])).cloned()
    };
    Distance { nearest, best: (0..of.len()).filter_map(most).collect() }
}
