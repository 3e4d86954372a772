//! Elementary effects: which of many factors matter, and which of them act alone (Morris,
//! *Technometrics* 33, 1991; μ* after Campolongo, Cariboni and Saltelli, 2007).
//!
//! Every factor has a finite number of levels, spread evenly over 0 to 1. A *trajectory* starts at
//! a random point and moves every factor once, in random order, up or down by half of its levels.
//! The elementary effect of a step is `(after - before) / Δ` with `Δ` signed. Over the
//! trajectories, μ* is the mean of its size, μ the mean and σ the standard deviation: σ near 0 is a
//! factor whose effect is the same everywhere, σ near or above μ* one that bends or interacts.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Trajectories that are tried for each one that is asked for, before it is given up.
const TRIES: usize = 200;

/// One trajectory: a point more than there are factors, each point the levels of all factors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trajectory {
    /// The points, in order.
    pub points: Vec<Vec<usize>>,
    /// Which factor the step from point `i` to `i + 1` moves.
    pub moved: Vec<usize>,
}

/// The points of the experiment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Design {
    /// Levels of each factor, at least 2.
    levels: Vec<usize>,
    /// The trajectories.
    pub trajectories: Vec<Trajectory>,
    /// Trajectories that were thrown away because a point of them is not valid.
    pub redrawn: usize,
}

/// What one factor does. Effects are in the unit of the output, for the whole range of the factor.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effect {
    /// Mean of the elementary effects.
    pub mu: f64,
    /// Mean of their size.
    pub mu_star: f64,
    /// Their standard deviation (of the sample: divided by n - 1); 0 for one effect.
    pub sigma: f64,
}

impl Design {
    /// `count` trajectories through factors of `levels` levels (fewer than 2 count as 2), all
    /// points of which are `valid`: others are drawn again, and after many tries there are fewer
    /// trajectories.
    pub fn new(
        levels: &[usize],
        count: usize,
        seed: u64,
        mut valid: impl FnMut(&[usize]) -> bool,
    ) -> Design {
        let levels: Vec<usize> = levels.iter().map(|&n| n.max(2)).collect();
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut design = Design { levels, trajectories: Vec::new(), redrawn: 0 };
        let mut tries = count.saturating_mul(TRIES);
        while design.trajectories.len() < count && tries > 0 {
            tries -= 1;
            let drawn = trajectory(&design.levels, &mut rng);
            match drawn.points.iter().all(|p| valid(p)) {
                true => design.trajectories.push(drawn),
                false => design.redrawn += 1,
            }
        }
        design
    }

    /// All points, trajectory by trajectory.
    pub fn points(&self) -> impl Iterator<Item = &[usize]> {
        self.trajectories.iter().flat_map(|t| t.points.iter().map(Vec::as_slice))
    }

    /// The place of a level between 0 and 1.
    pub fn unit(&self, factor: usize, level: usize) -> f64 {
        level as f64 / (self.levels[factor] - 1) as f64
    }

    /// The effect of each factor on an output with these values, one for each of
    /// [`Design::points`].
    ///
    /// # Panics
    /// If there are fewer values than points.
    pub fn effects(&self, values: &[f64]) -> Vec<Effect> {
        let mut found: Vec<Vec<f64>> = vec![Vec::new(); self.levels.len()];
        let mut start = 0;
        for t in &self.trajectories {
            for (i, &factor) in t.moved.iter().enumerate() {
                let unit = |point: usize| self.unit(factor, t.points[point][factor]);
                let difference = values[start + i + 1] - values[start + i];
                found[factor].push(difference / (unit(i + 1) - unit(i)));
            }
            start += t.points.len();
        }
        found.iter().map(|effects| summary(effects)).collect()
    }
}

fn trajectory(levels: &[usize], rng: &mut Pcg64Mcg) -> Trajectory {
    // Each factor moves between a level and the one half of the levels above it.
    let mut pair = |&n: &usize| {
        let low = rng.random_range(0..n - n / 2);
        if rng.random_bool(0.5) { [low, low + n / 2] } else { [low + n / 2, low] }
    };
    let pairs: Vec<[usize; 2]> = levels.iter().map(&mut pair).collect();
    let mut moved: Vec<usize> = (0..levels.len()).collect();
    for i in (1..moved.len()).rev() {
        moved.swap(i, rng.random_range(0..i + 1));
    }
    let mut point: Vec<usize> = pairs.iter().map(|p| p[0]).collect();
    let mut points = vec![point.clone()];
    for &factor in &moved {
        point[factor] = pairs[factor][1];
        points.push(point.clone());
    }
    Trajectory { points, moved }
}

fn summary(effects: &[f64]) -> Effect {
    let n = effects.len() as f64;
    if effects.is_empty() {
        return Effect::default();
    }
    let mu = effects.iter().sum::<f64>() / n;
    let mu_star = effects.iter().map(|e| e.abs()).sum::<f64>() / n;
    let squares: f64 = effects.iter().map(|e| (e - mu).powi(2)).sum();
    let sigma = if effects.len() > 1 { (squares / (n - 1.0)).sqrt() } else { 0.0 };
    Effect { mu, mu_star, sigma }
}
