//! Several keys perturbed together: elementary effects after Morris, or Sobol indices.

use std::collections::HashMap;

use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{Change, Frames, RunError, System, Watch};
use rayon::prelude::*;

use super::levels::FactorLevels;
use super::measure::MeasuredMachines;
use crate::analysis::{indices, morris};
use crate::findings::cost::Cost;
use crate::findings::sensitivity::Measure;
use crate::findings::sensitivity::interactions::{InteractionPoint, Interactions, Results};

/// The most machines of one experiment: about a gigabyte of them.
const MOST: usize = 100_000;

/// How keys are perturbed together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Elementary effects: cheap; they say which keys matter, and which act alone.
    Morris,
    /// Shares of the variance of each key alone and with others, with intervals.
    Sobol,
}

/// Several keys together.
#[derive(Debug, Clone, Copy)]
pub struct InteractionStudy {
    /// The method.
    pub method: Method,
    /// Trajectories or rows; `None`: 20 trajectories, 128 rows.
    pub samples: Option<usize>,
    /// Seed of the sample.
    pub seed: u64,
}

impl InteractionStudy {
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

    /// Takes the frames through the machines of a sample; `None` if not even one frame was done.
    ///
    /// # Errors
    /// [`RunError::Request`]: too many machines, or none; otherwise as
    /// [`MeasuredMachines::measure`].
    pub(super) fn run<F: Frames>(
        &self,
        base: &System,
        display_fps: f64,
        factors: &[FactorLevels],
        lists: &mut [F],
        watch: &dyn Watch,
    ) -> Result<Option<Interactions>, RunError> {
        let most = self.machines(factors.len());
        if most > MOST {
            let what = format!("--samples: up to {most} machines are more than {MOST}");
            return Err(RunError::Request(what));
        }
        let mut pool = InteractionPool { base, factors, known: HashMap::new() };
        let sample = InteractionSample::draw(self, &mut pool);
        let all = sample.points(factors);
        if all.is_empty() {
            let what = "--keys: hardly any combination of these values is a machine; narrow them";
            return Err(RunError::Request(what.to_owned()));
        }
        let mut distinct = all.clone();
        distinct.sort();
        distinct.dedup();
        let mut machines = MeasuredMachines::new(base);
        for point in &distinct {
            machines.add(*pool.known.remove(point).flatten().expect("a valid point"));
        }
        let measured = machines.measure(lists, display_fps, watch)?;
        let Some(measured) = measured else { return Ok(None) };
        let outcome = |place: usize| Cost::mean(&measured.outcomes(place));
        let points: Vec<InteractionPoint> = (distinct.iter().enumerate())
            .map(|(i, p)| InteractionPoint { levels: p.clone(), outcome: outcome(i + 1) })
            .collect();
        let find = |p: &Vec<usize>| points[distinct.binary_search(p).expect("it is there")].outcome;
        let outcomes: Vec<Cost> = all.iter().map(find).collect();
        let (samples, redrawn) = sample.counts();
        Ok(Some(Interactions {
            machine: base.machine().name.clone(),
            display_fps,
            traces: measured.traced(),
            factors: factors.iter().map(FactorLevels::factor).collect(),
            asked: self.count(),
            samples,
            redrawn,
            seed: self.seed,
            points,
            results: sample.results(&outcomes, &outcome(0), self.seed),
        }))
    }
}

/// The machines of all points so far.
struct InteractionPool<'a> {
    base: &'a System,
    factors: &'a [FactorLevels],
    known: HashMap<Vec<usize>, Option<Box<System>>>,
}

impl InteractionPool<'_> {
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
fn levels(factors: &[FactorLevels], point: &[f64]) -> Vec<usize> {
    let level = |(f, u): (&FactorLevels, &f64)| {
        let n = f.levels.len();
        ((u * n as f64) as usize).min(n - 1)
    };
    factors.iter().zip(point).map(level).collect()
}

/// The points of the sample, and what to make of the outcomes.
enum InteractionSample {
    Morris(morris::Design),
    Sobol(indices::Design),
}

impl InteractionSample {
    fn draw(study: &InteractionStudy, pool: &mut InteractionPool) -> InteractionSample {
        let (factors, count, seed) = (pool.factors, study.count(), study.seed);
        match study.method {
            Method::Morris => {
                let n: Vec<usize> = factors.iter().map(|f| f.levels.len()).collect();
                // Most points of the first draw stay: their machines are made in parallel.
                let first = morris::Design::new(&n, count, seed, |_| true);
                pool.prepare(first.points().map(<[usize]>::to_vec));
                InteractionSample::Morris(morris::Design::new(&n, count, seed, |p| {
                    pool.is_machine(p)
                }))
            }
            Method::Sobol => {
                let n = factors.len();
                let first = indices::Design::new(n, count, seed, |_| true);
                pool.prepare(first.points().map(|p| levels(factors, &p)));
                let valid = |p: &[f64]| pool.is_machine(&levels(factors, p));
                InteractionSample::Sobol(indices::Design::new(n, count, seed, valid))
            }
        }
    }

    /// The levels of all points, in order, some more than once.
    fn points(&self, factors: &[FactorLevels]) -> Vec<Vec<usize>> {
        match self {
            InteractionSample::Morris(design) => design.points().map(<[usize]>::to_vec).collect(),
            InteractionSample::Sobol(design) => {
                design.points().map(|p| levels(factors, &p)).collect()
            }
        }
    }

    /// Samples that came out, and those that were drawn again.
    fn counts(&self) -> (usize, usize) {
        match self {
            InteractionSample::Morris(design) => (design.trajectories.len(), design.redrawn),
            InteractionSample::Sobol(design) => (design.rows(), design.redrawn),
        }
    }

    /// What the outcomes of all points say; effects in percent of `base`.
    fn results(&self, outcomes: &[Cost], base: &Cost, seed: u64) -> Results {
        let measures = Measure::ALL.into_iter().filter(|m| m.of(base).is_some_and(|y| y > 0.0));
        let values = |m: Measure| -> Vec<f64> {
            let of = |o: &Cost| m.of(o).unwrap_or(0.0) / m.of(base).unwrap_or(1.0) * 100.0;
            outcomes.iter().map(of).collect()
        };
        match self {
            InteractionSample::Morris(design) => {
                Results::Morris(measures.map(|m| (m, design.effects(&values(m)))).collect())
            }
            InteractionSample::Sobol(design) => {
                Results::Sobol(measures.map(|m| (m, design.indices(&values(m), seed))).collect())
            }
        }
    }
}
