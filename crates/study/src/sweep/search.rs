//! Adaptive search for a Pareto front: NSGA-II (Deb et al. 2002) on the points of a lattice, as
//! ask and tell.
//!
//! [`Search::ask`] gives the points of the next generation that are not simulated yet,
//! [`Search::tell`] takes what came of them. Parents are taken by rank and crowding from the best
//! points so far; children mix their values, and values move to neighbours on axes of numbers or to
//! any other value on axes of names. A point is asked for once; a generation without enough new
//! children is filled up with random points. Points that miss a bound lose against those that keep
//! it, points that failed or are left out against every other. The same seed and the same results
//! give the same points.

use std::collections::{BTreeMap, BTreeSet};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::file::Sampling;
use super::lattice::Lattice;
use super::sample::{self, sobol};
use front::{FrontTrial, Ranked};

pub mod front;

/// Chance that two parents mix.
const CROSSOVER: f64 = 0.9;

/// Random points that are tried for every one that is wanted.
const TRIES: u64 = 64;

/// A search on its way.
#[derive(Debug, Clone)]
pub struct Search {
    lattice: Lattice,
    population: usize,
    generations: u32,
    budget: u64,
    random: Pcg64,
    /// Generations that were asked for.
    asked: u32,
    /// Points that were asked for.
    known: BTreeSet<u64>,
    /// Results by point; `None` for a point that failed.
    results: BTreeMap<u64, Option<FrontTrial>>,
    /// Points that parents are taken from.
    parents: Vec<u64>,
}

impl Search {
    /// A search on the points of a lattice; `sampling` has the size of a generation, their number,
    /// the largest number of points and the seed.
    pub fn new(lattice: &Lattice, sampling: &Sampling) -> Search {
        Search {
            lattice: lattice.clone(),
            population: sampling.generation() as usize,
            generations: sampling.generations,
            budget: sampling.points.unwrap_or(u64::MAX),
            random: Pcg64::seed_from_u64(sampling.seed),
            asked: 0,
            known: BTreeSet::new(),
            results: BTreeMap::new(),
            parents: Vec::new(),
        }
    }

    /// The points to simulate next, at most one population; none when the search is over. `allowed`
    /// is asked for the point that stands for a proposed one (`None` where it is left out by a
    /// constraint): what is left out costs nothing.
    pub fn ask(&mut self, allowed: &dyn Fn(u64) -> Option<u64>) -> Vec<u64> {
        if self.asked >= self.generations {
            return Vec::new();
        }
        let left = self.budget.saturating_sub(self.known.len() as u64);
        let wanted = (self.population as u64).min(left) as usize;
        let mut asked = Vec::new();
        if self.asked == 0 {
            self.first(wanted, &mut asked, allowed);
        } else {
            self.children(wanted, &mut asked, allowed);
        }
        self.anywhere(wanted, &mut asked, allowed);
        self.asked += 1;
        asked
    }

    /// Takes results, with as many costs for each point; `None` for a point that failed. Order does
    /// not matter.
    pub fn tell(&mut self, results: &[(u64, Option<FrontTrial>)]) {
        for (index, values) in results {
            // What is not finite cannot be ranked: it is as good as failed.
            let is_finite =
                |t: &FrontTrial| t.miss.is_finite() && t.costs.iter().all(|x| x.is_finite());
            let usable = values.clone().filter(is_finite);
            self.results.insert(*index, usable);
        }
        // Elitist, as NSGA-II is: parents compete with their children.
        let mut candidates: BTreeSet<u64> = results.iter().map(|(index, _)| *index).collect();
        candidates.extend(&self.parents);
        let alive = |i: &u64| Some((*i, self.results.get(i)?.clone()?));
        let alive: Vec<(u64, FrontTrial)> = candidates.iter().filter_map(alive).collect();
        self.parents = front::best(&alive, self.population);
    }

    /// Generations that were asked for, and how many there are.
    pub fn progress(&self) -> (u32, u32) {
        (self.asked, self.generations)
    }

    /// The points that no other one beats in everything, ascending.
    pub fn front(&self) -> Vec<u64> {
        let alive = self.results.iter().filter_map(|(i, r)| Some((*i, r.clone()?)));
        let alive: Vec<(u64, FrontTrial)> = alive.collect();
        let ranked = Ranked::new(&alive);
        let first = alive.iter().zip(&ranked.rank).filter(|(_, rank)| **rank == 0);
        first.map(|((index, _), _)| *index).collect()
    }

    /// Adds a point if it is new and allowed.
    fn add(&mut self, index: u64, asked: &mut Vec<u64>, allowed: &dyn Fn(u64) -> Option<u64>) {
        if self.known.contains(&index) {
            return;
        }
        // Several points may be one design, which must not be asked for twice.
        if let Some(index) = allowed(index)
            && self.known.insert(index)
        {
            asked.push(index);
        }
    }

    /// Evenly spread, where the sequence knows that many axes.
    fn first(&mut self, wanted: usize, asked: &mut Vec<u64>, allowed: &dyn Fn(u64) -> Option<u64>) {
        let moving = self.lattice.sides().iter().filter(|s| s.len > 1).count();
        if moving > sobol::DIMENSIONS_MAX {
            return;
        }
        let mut sequence = sobol::Sobol::new(moving, self.random.random());
        // Bounded, because a narrow space may have no further point.
        for _ in 0..wanted as u64 * TRIES {
            if asked.len() >= wanted {
                break;
            }
            let index = sample::on_lattice(&self.lattice, &sequence.next_point());
            self.add(index, asked, allowed);
        }
    }

    fn children(
        &mut self,
        wanted: usize,
        asked: &mut Vec<u64>,
        allowed: &dyn Fn(u64) -> Option<u64>,
    ) {
        if self.parents.is_empty() {
            return;
        }
        let result = |i: &u64| (*i, self.results[i].clone().unwrap_or_default());
        let pool: Vec<(u64, FrontTrial)> = self.parents.iter().map(result).collect();
        let ranked = Ranked::new(&pool);
        for _ in 0..wanted as u64 * TRIES {
            if asked.len() >= wanted {
                break;
            }
            let (a, b) = (self.winner(&ranked), self.winner(&ranked));
            let child = self.child(pool[a].0, pool[b].0);
            self.add(child, asked, allowed);
        }
    }

    /// The better of two at random.
    fn winner(&mut self, ranked: &Ranked) -> usize {
        let n = ranked.rank.len();
        let (a, b) = (self.random.random_range(0..n), self.random.random_range(0..n));
        if ranked.better(b, a) { b } else { a }
    }

    fn child(&mut self, a: u64, b: u64) -> u64 {
        let (mut child, other) = (self.lattice.digits(a), self.lattice.digits(b));
        let sides = self.lattice.sides().to_vec();
        if self.random.random_bool(CROSSOVER) {
            // Uniform crossover: that two axes are neighbours in the file means nothing.
            for (digit, other) in child.iter_mut().zip(other) {
                if self.random.random_bool(0.5) {
                    *digit = other;
                }
            }
        }
        let moving = sides.iter().filter(|s| s.len > 1).count().max(1);
        // One axis changes on average, the rate that is usual for NSGA-II.
        let chance = 1.0 / moving as f64;
        for (digit, side) in child.iter_mut().zip(&sides) {
            if side.len < 2 || !self.random.random_bool(chance) {
                continue;
            }
            // Always another value: the same one would often give a parent back, which is known.
            *digit = if side.ordered {
                self.neighbour(*digit, side.len)
            } else {
                (*digit + self.random.random_range(1..side.len)) % side.len
            };
        }
        self.lattice.index(&child)
    }

    /// Another value of an ordered axis: mostly a step or two away, rarely far.
    fn neighbour(&mut self, digit: u32, len: u32) -> u32 {
        let reach = f64::from(len - 1);
        // Uniform in its logarithm, so that short steps prevail on long axes, too.
        let far = reach.powf(self.random.random::<f64>()).round().max(1.0) as u32;
        let far = self.random.random_range(1..=far);
        let up = self.random.random_bool(0.5);
        match (up, digit.checked_sub(far), digit.checked_add(far).filter(|d| *d < len)) {
            (true, _, Some(above)) | (false, None, Some(above)) => above,
            (_, Some(below), _) => below,
            (_, None, None) if digit > 0 => 0,
            (_, None, None) => len - 1,
        }
    }

    /// Random points until there are enough.
    fn anywhere(
        &mut self,
        wanted: usize,
        asked: &mut Vec<u64>,
        allowed: &dyn Fn(u64) -> Option<u64>,
    ) {
        let points = self.lattice.points();
        if points <= self.known.len() as u64 {
            return;
        }
        for _ in 0..wanted as u64 * TRIES {
            if asked.len() >= wanted {
                break;
            }
            let index = self.random.random_range(0..points);
            self.add(index, asked, allowed);
        }
    }
}
