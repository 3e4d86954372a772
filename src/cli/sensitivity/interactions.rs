//! Machines with many keys turned at once, and what the methods make of them.

use std::collections::HashMap;

use rayon::prelude::*;

use super::levels::Levelled;
use super::measure::{self, Machines};
use crate::cli::{Context, Exit, Failure};
use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{Change, System, TraceFile};
use powergs_study::analysis::{indices, morris};
use powergs_study::findings::sensitivity::interactions::{Interactions, Point, Results};
use powergs_study::findings::sensitivity::{Measure, Outcome};

/// The most machines of one experiment: about a gigabyte of them.
const MOST: usize = 100_000;

/// How keys are turned together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// Elementary effects: cheap, says which keys matter and which act alone
    Morris,
    /// Shares of the variance, alone and with others, with intervals
    Sobol,
}

/// What was asked for.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// The method.
    pub method: Method,
    /// Trajectories or rows; the method's usual number if not given.
    pub samples: Option<usize>,
    /// Seed of the sample.
    pub seed: u64,
    /// Display rate of the powers, frames per second.
    pub display_fps: f64,
}

impl Asked {
    fn count(&self) -> usize {
        self.samples.unwrap_or(match self.method {
            Method::Morris => 20,
            Method::Sobol => 128,
        })
    }

    /// The most machines that it may take.
    fn machines(&self, factors: usize) -> usize {
        let each = match self.method {
            Method::Morris => factors + 1,
            Method::Sobol => factors + 2,
        };
        self.count().saturating_mul(each)
    }
}

/// The machines of all points so far.
struct Pool<'a> {
    base: &'a System,
    factors: &'a [Levelled],
    known: HashMap<Vec<usize>, Option<Box<System>>>,
}

impl Pool<'_> {
    fn machine(&self, levels: &[usize]) -> Option<Box<System>> {
        let set = self.factors.iter().zip(levels);
        let changes: Vec<Change> = set.map(|(f, &l)| f.key.change(&f.levels[l])).collect();
        Some(Box::new(self.base.with_from(&changes, &EmbeddedFiles).ok()?))
    }

    /// Makes the machines of these points, in parallel.
    fn prepare(&mut self, points: impl Iterator<Item = Vec<usize>>) {
        let mut new: Vec<Vec<usize>> = points.filter(|p| !self.known.contains_key(p)).collect();
        new.sort();
        new.dedup();
        let made: Vec<_> = new.par_iter().map(|p| self.machine(p)).collect();
        self.known.extend(new.into_iter().zip(made));
    }

    fn is_machine(&mut self, levels: &[usize]) -> bool {
        if let Some(known) = self.known.get(levels) {
            return known.is_some();
        }
        let made = self.machine(levels);
        let is_machine = made.is_some();
        self.known.insert(levels.to_vec(), made);
        is_machine
    }
}

/// The levels at a point of the unit cube.
fn levels(factors: &[Levelled], point: &[f64]) -> Vec<usize> {
    let level = |(f, u): (&Levelled, &f64)| {
        let n = f.levels.len();
        ((u * n as f64) as usize).min(n - 1)
    };
    factors.iter().zip(point).map(level).collect()
}

/// The points of the sample, and what to make of the outcomes.
enum Sample {
    Morris(morris::Design),
    Sobol(indices::Design),
}

impl Sample {
    fn draw(asked: &Asked, pool: &mut Pool) -> Sample {
        let (factors, count, seed) = (pool.factors, asked.count(), asked.seed);
        match asked.method {
            Method::Morris => {
                let n: Vec<usize> = factors.iter().map(|f| f.levels.len()).collect();
                // Most points of the first draw stay: their machines are made in parallel.
                let first = morris::Design::new(&n, count, seed, |_| true);
                pool.prepare(first.points().map(<[usize]>::to_vec));
                Sample::Morris(morris::Design::new(&n, count, seed, |p| pool.is_machine(p)))
            }
            Method::Sobol => {
                let n = factors.len();
                let first = indices::Design::new(n, count, seed, |_| true);
                pool.prepare(first.points().map(|p| levels(factors, &p)));
                let valid = |p: &[f64]| pool.is_machine(&levels(factors, p));
                Sample::Sobol(indices::Design::new(n, count, seed, valid))
            }
        }
    }

    /// The levels of all points, in order, some more than once.
    fn points(&self, factors: &[Levelled]) -> Vec<Vec<usize>> {
        match self {
            Sample::Morris(design) => design.points().map(<[usize]>::to_vec).collect(),
            Sample::Sobol(design) => design.points().map(|p| levels(factors, &p)).collect(),
        }
    }

    /// Samples that came out, and those that were drawn again.
    fn counts(&self) -> (usize, usize) {
        match self {
            Sample::Morris(design) => (design.trajectories.len(), design.redrawn),
            Sample::Sobol(design) => (design.rows(), design.redrawn),
        }
    }

    /// What the outcomes of all points say; effects in percent of `base`.
    fn results(&self, outcomes: &[Outcome], base: &Outcome, seed: u64) -> Results {
        let measures = Measure::ALL.into_iter().filter(|m| m.of(base).is_some_and(|y| y > 0.0));
        let values = |m: Measure| -> Vec<f64> {
            let of = |o: &Outcome| m.of(o).unwrap_or(0.0) / m.of(base).unwrap_or(1.0) * 100.0;
            outcomes.iter().map(of).collect()
        };
        match self {
            Sample::Morris(design) => {
                Results::Morris(measures.map(|m| (m, design.effects(&values(m)))).collect())
            }
            Sample::Sobol(design) => {
                Results::Sobol(measures.map(|m| (m, design.indices(&values(m), seed))).collect())
            }
        }
    }
}

/// Takes the traces through the machines of a sample; `None` if not even one frame was done.
///
/// # Errors
/// Exit code 2: too many machines, or none; otherwise as [`measure::measure`].
pub fn run(
    asked: &Asked,
    machine: &str,
    base: &System,
    factors: &[Levelled],
    sources: &mut [TraceFile],
    context: &Context,
) -> Result<Option<Interactions>, Failure> {
    let machines = asked.machines(factors.len());
    if machines > MOST {
        let what = format!("--samples: up to {machines} machines are more than {MOST}");
        return Err(Failure::new(Exit::Usage, what));
    }
    let mut pool = Pool { base, factors, known: HashMap::new() };
    let sample = Sample::draw(asked, &mut pool);
    let all = sample.points(factors);
    if all.is_empty() {
        let what = "--keys: hardly any combination of these values is a machine; narrow them";
        return Err(Failure::new(Exit::Usage, what.to_owned()));
    }
    let mut distinct = all.clone();
    distinct.sort();
    distinct.dedup();
    let taken = |p: &Vec<usize>| *pool.known.remove(p).flatten().expect("a valid point");
    let systems = std::iter::once(base.clone()).chain(distinct.iter().map(taken)).collect();
    let machines = Machines::known(systems, asked.display_fps);
    let Some(means) = measure::all(sources, &machines, context)? else { return Ok(None) };
    let outcome = |place: usize| Outcome::mean(&measure::outcomes(&means, place));
    let points: Vec<Point> = (distinct.iter().enumerate())
        .map(|(i, p)| Point { levels: p.clone(), outcome: outcome(i + 1) })
        .collect();
    let find = |p: &Vec<usize>| points[distinct.binary_search(p).expect("it is there")].outcome;
    let outcomes: Vec<Outcome> = all.iter().map(find).collect();
    let (samples, redrawn) = sample.counts();
    Ok(Some(Interactions {
        machine: machine.to_owned(),
        display_fps: asked.display_fps,
        traces: measure::traced(&means),
        factors: factors.iter().map(Levelled::factor).collect(),
        asked: asked.count(),
        samples,
        redrawn,
        seed: asked.seed,
        points,
        results: sample.results(&outcomes, &outcome(0), asked.seed),
    }))
}
