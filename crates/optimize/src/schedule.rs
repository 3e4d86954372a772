//! Which pruning ratios are sampled, and for how many iterations.
//!
//! [`Schedule::Adaptive`] is ours: both ends of the curve, one ratio between, then wherever the
//! curve has its minimum. [`Schedule::Listed`] takes what the user says.
//! [`Schedule::Published`] is the coarse-to-fine search of the published code, 7 + 5 samples
//! (`powergs`, section 4.5).

use serde::Serialize;

use super::fit::{self, Sample};
use super::invalid::Invalid;

/// Coarse samples of the published schedule.
const COARSE: usize = 7;
/// Fine samples of the published schedule.
const FINE: usize = 5;
/// Ratio between two coarse samples.
pub const COARSE_STEP: f64 = 0.15;
/// The published budget of a sample that prunes everything: first level, other levels.
const BUDGETS: [u32; 2] = [10_000, 5_000];
/// The published iterations that the budget of a sample stands for.
const UNIT: f64 = 1500.0;
/// Most ratios of a list.
const MOST_RHOS: usize = 1000;
/// Iterations of a sample of the adaptive schedule, relative to the budget of a sample. The end of
/// the curve needs most of what there is: what is pruned recovers slowly, and dimming is quick.
const EFFORT: f64 = 0.5;
/// Iterations of the end of the curve, relative to the same.
const END_EFFORT: f64 = 4.0;
/// How often a ratio is tried.
const TRIES: usize = 2;
/// Ratios that differ by less are the same.
const SAME: f64 = 1e-3;
/// Samples are at least so far apart.
pub(crate) const APART: f64 = 0.02;
/// The range that fine samples cover.
const FINE_RANGE: f64 = 0.30;

/// A sample that is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TakenSample {
    /// The ratio of pruned Gaussians.
    pub rho: f64,
    /// Display power, watts; where it is known, that with all quality above the target spent.
    pub display_w: f64,
    /// Rendering power, watts.
    pub render_w: f64,
    /// Whether it ended on the target.
    pub passed: bool,
    /// Whether it is the end of the curve where nothing is spent on the display.
    pub is_end: bool,
}

impl TakenSample {
    /// Display and rendering power, watts.
    fn total_w(&self) -> f64 {
        self.display_w + self.render_w
    }
}

/// A sample to take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextSample {
    /// The ratio of pruned Gaussians, of the dense model.
    pub rho: f64,
    /// Position of the sample that it starts from; `None`: the dense model.
    pub from: Option<usize>,
    /// Iterations, relative to the budget of a sample.
    pub effort: f64,
    /// Pruned without a display term for as long as the target is reached, whatever ratio that
    /// comes to.
    pub is_end: bool,
}

/// A way to choose samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Schedule {
    /// This many samples: nothing pruned, a first ratio, as much as can be pruned without a display
    /// term, then around the minimum of the curve through them.
    Adaptive {
        /// Number of samples.
        count: usize,
        /// The first ratio beyond 0. `None`: what is pruned most comes next, with as many
        /// iterations as both would have, and starts where the search does, for an unpruned model
        /// with a display term has spent on it what pruning is to spend.
        first: Option<f64>,
    },
    /// These ratios, ascending.
    Listed(Vec<f64>),
    /// Seven coarse samples and five fine ones.
    Published {
        /// Iterations of a sample that prunes everything: 10,000 for the first level, 5,000 for
        /// the others.
        budget: u32,
    },
}

impl Schedule {
    /// Five samples: what the program takes where it is not told otherwise.
    pub const FIVE: Schedule = Schedule::Adaptive { count: 5, first: Some(0.15) };

    /// These ratios.
    ///
    /// # Errors
    /// [`Invalid::Rhos`]: too many, not ascending, or not from 0 to below 1.
    pub fn listed(rhos: &[f64]) -> Result<Schedule, Invalid> {
        let ascending = rhos.windows(2).all(|w| w[0] < w[1]);
        if ascending && rhos.iter().all(|r| (0.0..1.0).contains(r)) && rhos.len() <= MOST_RHOS {
            return Ok(Schedule::Listed(rhos.to_vec()));
        }
        Err(Invalid::Rhos { most: MOST_RHOS })
    }

    /// The published search of the first level.
    pub const PUBLISHED: Schedule = Schedule::Published { budget: BUDGETS[0] };

    /// The same search in the periphery, and the budget of a sample there relative to the first
    /// level: `share`, unless the plan has budgets of its own. Its models were pruned to their
    /// limit before, so that the first ratio of level 1 is often beyond what a level bears. Its
    /// longer end counts as two samples.
    pub fn upper(&self, share: f64) -> (Schedule, f64) {
        match self {
            Schedule::Adaptive { count, .. } => {
                let count = (*count).saturating_sub(1).max(1);
                (Schedule::Adaptive { count, first: None }, share)
            }
            Schedule::Listed(_) => (self.clone(), share),
            Schedule::Published { .. } => (Schedule::Published { budget: BUDGETS[1] }, 1.0),
        }
    }

    /// The most samples that it takes.
    pub fn count(&self) -> usize {
        match self {
            Schedule::Adaptive { count, .. } => *count,
            Schedule::Listed(rhos) => rhos.len(),
            Schedule::Published { .. } => COARSE + FINE,
        }
    }

    /// The most iterations that all samples take, relative to the budget of a sample. `first` is
    /// the effort of the very first.
    pub fn most_effort(&self, first: f64) -> f64 {
        match self {
            Schedule::Adaptive { count, first: rho } => {
                let before = 1 + usize::from(rho.is_some());
                let end = if *count > before { end_effort(*rho) - EFFORT } else { 0.0 };
                EFFORT * (self.count().saturating_sub(1) as f64 + first) + end
            }
            Schedule::Listed(_) => self.count().saturating_sub(1) as f64 + first,
            Schedule::Published { budget } => {
                let coarse = (0..COARSE).map(|i| coarse_iterations(i, *budget)).sum::<u32>();
                // The longest fine-tune of a fine sample prunes 0.15 after 0.9 are pruned.
                let fine = FINE as u32 * fine_tune(*budget, COARSE_STEP, 0.9);
                f64::from(coarse + fine) / UNIT
            }
        }
    }

    /// The next sample, or `None` at the end. `first` is the effort of the very first.
    pub fn next(&self, done: &[TakenSample], first: f64) -> Option<NextSample> {
        let next = done.len();
        if next >= self.count() {
            return None;
        }
        match self {
            Schedule::Adaptive { first: rho, .. } => adaptive(done, *rho, first),
            Schedule::Listed(rhos) => {
                let effort = if next == 0 { first } else { 1.0 };
                let from = next.checked_sub(1);
                Some(NextSample { rho: rhos[next], from, effort, is_end: false })
            }
            Schedule::Published { budget } => Some(published(done, next, *budget)),
        }
    }
}

/// Iterations of the end, relative to the budget of a sample. Without a ratio before it, it has
/// those of that sample too.
fn end_effort(first: Option<f64>) -> f64 {
    if first.is_some() { END_EFFORT } else { END_EFFORT + EFFORT }
}

/// The ends first, then refinement. A sample that misses is retried once, with as many iterations
/// more, before anything else; what misses twice is given up. Where not even the unpruned model
/// reaches the target there is no further sample, unless the end starts elsewhere.
fn adaptive(done: &[TakenSample], rho: Option<f64>, first: f64) -> Option<NextSample> {
    let tuned = |rho, from| Some(NextSample { rho, from, effort: EFFORT, is_end: false });
    let Some(last) = done.last() else {
        return Some(NextSample { rho: 0.0, from: None, effort: first * EFFORT, is_end: false });
    };
    let is_at = |d: &TakenSample, rho: f64| !d.is_end && (d.rho - rho).abs() < SAME;
    let tries = done.iter().filter(|d| is_at(d, last.rho)).count();
    if !last.passed && !last.is_end && tries < TRIES {
        return tuned(last.rho, Some(done.len() - 1));
    }
    let by_rho = |a: &&(usize, &TakenSample), b: &&(usize, &TakenSample)| {
        a.1.rho.total_cmp(&b.1.rho).then(b.0.cmp(&a.0))
    };
    let mut passed: Vec<(usize, &TakenSample)> =
        done.iter().enumerate().filter(|(_, d)| d.passed).collect();
    passed.sort_by(|a, b| by_rho(&a, &b));
    let below = |rho: f64| passed.iter().rev().find(|(_, d)| d.rho <= rho + SAME).map(|p| p.0);
    if rho.is_none() && done.iter().all(|d| !d.is_end) {
        let effort = end_effort(rho);
        return Some(NextSample { rho: 0.0, from: None, effort, is_end: true });
    }
    let &(top, highest) = passed.last()?;
    if let Some(rho) = rho.filter(|_| done.iter().all(|d| is_at(d, 0.0))) {
        return tuned(rho, below(rho));
    }
    if done.iter().all(|d| !d.is_end) {
        let effort = end_effort(rho);
        return Some(NextSample { rho: highest.rho, from: Some(top), effort, is_end: true });
    }
    let rho = refined(done, &passed)?;
    tuned(rho, below(rho))
}

/// At the minimum of the fitted curve, or if that is known already, between the best sample and its
/// cheaper neighbour. `passed` ascends in ρ.
fn refined(done: &[TakenSample], passed: &[(usize, &TakenSample)]) -> Option<f64> {
    let is_new = |rho: f64| done.iter().all(|d| (d.rho - rho).abs() >= APART);
    let sample = |(_, d): &(usize, &TakenSample)| Sample {
        rho: d.rho,
        display_w: d.display_w,
        render_w: d.render_w,
    };
    let samples: Vec<Sample> = passed.iter().map(sample).collect();
    let minimum = fit::fit(&samples).ok().map(|f| fit::optimum(&f));
    let total = |i: usize| passed[i].1.total_w();
    let best = (0..passed.len()).min_by(|&a, &b| total(a).total_cmp(&total(b)))?;
    // Two samples at one place say the same.
    let is_apart = |&i: &usize| (passed[i].1.rho - passed[best].1.rho).abs() >= APART;
    let sides = [(0..best).rev().find(is_apart), (best + 1..passed.len()).find(is_apart)];
    let mut neighbours: Vec<usize> = sides.into_iter().flatten().collect();
    neighbours.sort_by(|&a, &b| total(a).total_cmp(&total(b)));
    let between = neighbours.into_iter().map(|i| (passed[best].1.rho + passed[i].1.rho) / 2.0);
    let minimum = minimum.map(|m| m.rho);
    minimum.into_iter().chain(between).find(|&rho| is_new(rho))
}

/// The budgets of the published schedule: iterations of coarse sample `i` where a sample has
/// `budget` (10,000 for the first level, 5,000 for the others).
pub fn coarse_iterations(i: usize, budget: u32) -> u32 {
    match i {
        0 => 5000,
        _ => fine_tune(budget, COARSE_STEP, COARSE_STEP * (i - 1) as f64),
    }
}

/// Iterations for pruning `step` more after `pruned`: in proportion to the share of what
/// is left, at least 1,500.
pub(crate) fn fine_tune(budget: u32, step: f64, pruned: f64) -> u32 {
    // In this order the rounding gives the published 3,749 and not 3,750.
    ((f64::from(budget) * (step / (1.0 - pruned))) as u32).max(1500)
}

fn published(done: &[TakenSample], next: usize, budget: u32) -> NextSample {
    let effort = |iterations: u32| f64::from(iterations) / UNIT;
    if next < COARSE {
        let rho = COARSE_STEP * next as f64;
        let iterations = coarse_iterations(next, budget);
        let from = next.checked_sub(1);
        return NextSample { rho, from, effort: effort(iterations), is_end: false };
    }
    let coarse = &done[..COARSE];
    let fine = Fine::around(best_of(coarse), COARSE_STEP);
    let k = next - COARSE;
    let offset = fine.step * (k + 1) as f64;
    // Ratios that are equal in decimals may differ by rounding.
    let from = fine.start + usize::from(offset > COARSE_STEP + 1e-12);
    let from = from.min(COARSE - 1);
    let rho = fine.ratios[k];
    let base = COARSE_STEP * from as f64;
    let iterations = fine_tune(budget, rho - base, base);
    NextSample { rho, from: Some(from), effort: effort(iterations), is_end: false }
}

/// The fine samples of the published schedule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fine {
    /// Position of the coarse sample where they begin.
    pub start: usize,
    /// Distance between two of them.
    pub step: f64,
    /// The ratios.
    pub ratios: [f64; FINE],
}

impl Fine {
    /// The fine samples around the best coarse sample.
    pub fn around(best: usize, coarse_step: f64) -> Fine {
        let start = best.saturating_sub(1);
        let begin = coarse_step * start as f64;
        // No ratio reaches 1, at which nothing would be left.
        let step = FINE_RANGE.min(1.0 - begin) / (FINE + 1) as f64;
        Fine { start, step, ratios: std::array::from_fn(|k| begin + step * (k + 1) as f64) }
    }
}

/// Position of the smallest smoothed total of the samples that passed; the first if none did.
pub fn best_of(samples: &[TakenSample]) -> usize {
    let totals: Vec<f64> = samples.iter().map(TakenSample::total_w).collect();
    let passed: Vec<bool> = samples.iter().map(|d| d.passed).collect();
    let smooth = smoothed(&totals, &passed);
    let candidates = (0..samples.len()).filter(|&i| passed[i]);
    candidates.min_by(|&a, &b| smooth[a].total_cmp(&smooth[b]).then(a.cmp(&b))).unwrap_or(0)
}

/// Totals smoothed with weights 1/4, 1/2, 1/4 over neighbours that passed; at the ends 0.67 and
/// 0.33. What failed stays as it is.
pub fn smoothed(totals: &[f64], passed: &[bool]) -> Vec<f64> {
    let end = totals.len().saturating_sub(1);
    let usable = |i: usize| passed.get(i).copied().unwrap_or(false);
    let smooth = |i: usize| {
        if !usable(i) || end == 0 {
            return totals[i];
        }
        if i == 0 || i == end {
            let neighbour = if i == 0 { 1 } else { end - 1 };
            let weighted = 0.67 * totals[i] + 0.33 * totals[neighbour];
            return if usable(neighbour) { weighted } else { totals[i] };
        }
        let weights = [(i - 1, 0.25), (i, 0.5), (i + 1, 0.25)];
        let used = weights.into_iter().filter(|(j, _)| usable(*j));
        let (sum, weight) = used.fold((0.0, 0.0), |(s, w), (j, k)| (s + k * totals[j], w + k));
        sum / weight
    };
    (0..totals.len()).map(smooth).collect()
}
