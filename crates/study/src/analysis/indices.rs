//! Sobol indices: which share of the variance of an output each factor explains, alone and with the
//! others.
//!
//! Two samples `A` and `B` of the unit cube, and for each factor `i` the sample `AB_i`, which is
//! `A` with column `i` of `B`. With the output `f` centred:
//!
//! - first order (Saltelli and others, *Comput. Phys. Commun.* 181, 2010):
//!   `S_i = mean(f_B (f_ABi - f_A)) / V`, the share that factor `i` explains alone;
//! - total (Jansen, *Comput. Phys. Commun.* 117, 1999): `T_i = mean((f_A - f_ABi)²) / 2V`, that
//!   share and the one of all interactions of `i`.
//!
//! `V` is the variance over `A` and `B`. They are one Latin hypercube in twice the dimensions: each
//! column falls once into each of `n` equal parts. Intervals are percentiles of estimates over rows
//! that are drawn again with replacement (bootstrap).

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Bootstrap samples.
const RESAMPLES: usize = 1000;
/// The interval leaves out this share at each end.
const TAIL: f64 = 0.025;
/// Rows that are drawn in place of one that is not valid, before it is given up.
const TRIES: usize = 200;

/// The points of the experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    factors: usize,
    /// Rows of `A` and `B` beside each other: twice as many numbers as there are factors.
    rows: Vec<Vec<f64>>,
    /// Rows that were thrown away because a point of them is not valid.
    pub redrawn: usize,
    /// Rows that were asked for.
    pub asked: usize,
}

/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// From all rows.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// The indices of one factor, shares of the variance.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Index {
    /// First order: what the factor explains alone.
    pub first: Estimate,
    /// Total: with all its interactions.
    pub total: Estimate,
}

/// The indices of all factors.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Indices {
    /// One for each factor.
    pub each: Vec<Index>,
    /// Sum of the first orders: what factors explain alone. The rest is interaction.
    pub alone: Estimate,
}

impl Design {
    /// `count` rows for so many factors, each of `factors + 2` points. A row with a point that is
    /// not `valid` is drawn again, uniformly; after many tries there are fewer rows. Where rows
    /// were drawn again, factors are no longer independent of each other.
    pub fn new(
        factors: usize,
        count: usize,
        seed: u64,
        mut valid: impl FnMut(&[f64]) -> bool,
    ) -> Design {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let columns: Vec<Vec<f64>> = (0..2 * factors).map(|_| column(count, &mut rng)).collect();
        let mut design = Design { factors, rows: Vec::new(), redrawn: 0, asked: count };
        for k in 0..count {
            let mut row: Vec<f64> = columns.iter().map(|c| c[k]).collect();
            for _ in 0..TRIES {
                if points(&row, factors).all(|p| valid(&p)) {
                    design.rows.push(row);
                    break;
                }
                design.redrawn += 1;
                row = (0..2 * factors).map(|_| rng.random::<f64>()).collect();
            }
        }
        design
    }

    /// Rows that came out.
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// All points, row by row: that of `A`, that of `B`, and `AB_i` for each factor.
    pub fn points(&self) -> impl Iterator<Item = Vec<f64>> {
        self.rows.iter().flat_map(|row| points(row, self.factors))
    }

    /// The indices of all factors for an output with these values, one for each of
    /// [`Design::points`]. All are 0 for an output that does not vary.
    ///
    /// # Panics
    /// If there are fewer values than points.
    pub fn indices(&self, values: &[f64], seed: u64) -> Indices {
        let (width, n) = (self.factors + 2, self.rows.len());
        let values = &values[..n * width];
        let ends = values.chunks_exact(width).flat_map(|row| [row[0], row[1]]);
        let mean = ends.sum::<f64>() / (2 * n).max(1) as f64;
        let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
        let rows: Vec<&[f64]> = centred.chunks_exact(width).collect();
        let all: Vec<usize> = (0..n).collect();
        let exact = estimates(&rows, &all, self.factors);
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut drawn = vec![[Vec::new(), Vec::new()]; self.factors];
        let mut sums = Vec::new();
        let sum = |found: &[[f64; 2]]| found.iter().map(|[first, _]| first).sum::<f64>();
        for _ in 0..if n > 1 { RESAMPLES } else { 0 } {
            let picked: Vec<usize> = (0..n).map(|_| rng.random_range(0..n)).collect();
            let again = estimates(&rows, &picked, self.factors);
            sums.push(sum(&again));
            for (drawn, [first, total]) in drawn.iter_mut().zip(again) {
                drawn[0].push(first);
                drawn[1].push(total);
            }
        }
        let index = |([first, total], [firsts, totals]): ([f64; 2], [Vec<f64>; 2])| Index {
            first: estimate(first, firsts),
            total: estimate(total, totals),
        };
        let alone = estimate(sum(&exact), sums);
        Indices { each: exact.into_iter().zip(drawn).map(index).collect(), alone }
    }
}

/// A value with the interval that most of the `drawn` ones are in.
fn estimate(value: f64, mut drawn: Vec<f64>) -> Estimate {
    drawn.sort_by(f64::total_cmp);
    let last = drawn.len().saturating_sub(1);
    let at = |share: f64| {
        let place = (share * last as f64).round() as usize;
        drawn.get(place).copied().unwrap_or(value)
    };
    Estimate { value, low: at(TAIL), high: at(1.0 - TAIL) }
}

/// One column of a Latin hypercube.
fn column(count: usize, rng: &mut Pcg64Mcg) -> Vec<f64> {
    let mut parts: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        parts.swap(i, rng.random_range(0..i + 1));
    }
    parts.into_iter().map(|part| (part as f64 + rng.random::<f64>()) / count as f64).collect()
}

fn points(row: &[f64], factors: usize) -> impl Iterator<Item = Vec<f64>> {
    let (a, b) = row.split_at(factors);
    let mixed = move |i: usize| {
        let mut point = a.to_vec();
        point[i] = b[i];
        point
    };
    [a.to_vec(), b.to_vec()].into_iter().chain((0..factors).map(mixed))
}

/// First and total index of each factor over some rows of centred values.
fn estimates(rows: &[&[f64]], picked: &[usize], factors: usize) -> Vec<[f64; 2]> {
    let n = picked.len().max(1) as f64;
    let ends = || picked.iter().flat_map(|&k| [rows[k][0], rows[k][1]]);
    let mean = ends().sum::<f64>() / (2.0 * n);
    let variance = ends().map(|v| (v - mean).powi(2)).sum::<f64>() / (2.0 * n);
    if variance <= f64::MIN_POSITIVE {
        return vec![[0.0; 2]; factors];
    }
    let one = |i: usize| {
        let (mut first, mut total) = (0.0, 0.0);
        for &k in picked {
            let row = rows[k];
            first += row[1] * (row[2 + i] - row[0]);
            total += (row[0] - row[2 + i]).powi(2);
        }
        [first / n / variance, total / (2.0 * n) / variance]
    };
    (0..factors).map(one).collect()
}
