//! Which pruning ratios are sampled, and for how many iterations.
//!
//! [`Schedule::Adaptive`] is ours: a few ratios, and where a sample misses its target the rest of
//! the budget goes to ratios below it. [`Schedule::Listed`] takes what the user says.
//! [`Schedule::Published`] is the coarse-to-fine search of the published code, 7 + 5 samples
//! (`powergs`, section 4.5).

use serde::Serialize;

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
/// The range that fine samples cover.
const FINE_RANGE: f64 = 0.30;

/// A sample that is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TakenSample {
    /// The ratio of pruned Gaussians.
    pub rho: f64,
    /// Display and rendering power, watts.
    pub total_w: f64,
    /// Whether it ended on the target.
    pub passed: bool,
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
}

/// A way to choose samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Schedule {
    /// This many samples from 0 to `highest`, moved below the first that fails.
    Adaptive {
        /// Number of samples.
        count: usize,
        /// The highest ratio.
        highest: f64,
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
    /// Five samples, up to 0.8: what the program takes where it is not told otherwise.
    pub const FIVE: Schedule = Schedule::Adaptive { count: 5, highest: 0.8 };

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
    /// level: `share`, unless the plan has budgets of its own.
    pub fn upper(&self, share: f64) -> (Schedule, f64) {
        match self {
            Schedule::Adaptive { .. } | Schedule::Listed(_) => (self.clone(), share),
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
    pub(crate) fn most_effort(&self, first: f64) -> f64 {
        match self {
            Schedule::Adaptive { .. } | Schedule::Listed(_) => {
                self.count().saturating_sub(1) as f64 + first
            }
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
            Schedule::Adaptive { count, highest } => adaptive(done, *count, *highest, first),
            Schedule::Listed(rhos) => {
                let effort = if next == 0 { first } else { 1.0 };
                Some(NextSample { rho: rhos[next], from: next.checked_sub(1), effort })
            }
            Schedule::Published { budget } => Some(published(done, next, *budget)),
        }
    }
}

/// Ratios rise evenly until one fails. Then what is left of the budget divides the gap between the
/// last that passed and the first that failed. Where not even the unpruned model reaches the
/// target there is no gap, and no further sample.
fn adaptive(done: &[TakenSample], count: usize, highest: f64, first: f64) -> Option<NextSample> {
    let next = done.len();
    let Some(failed) = done.iter().filter(|d| !d.passed).map(|d| d.rho).reduce(f64::min) else {
        let rho = highest * next as f64 / (count - 1).max(1) as f64;
        let effort = if next == 0 { first } else { 1.0 };
        return Some(NextSample { rho, from: next.checked_sub(1), effort });
    };
    let below = |d: &&(usize, &TakenSample)| d.1.passed && d.1.rho < failed;
    let sorted: Vec<(usize, &TakenSample)> = done.iter().enumerate().collect();
    let base = sorted.iter().filter(below).max_by(|a, b| a.1.rho.total_cmp(&b.1.rho));
    let (from, rho) = base.map_or((None, 0.0), |(i, d)| (Some(*i), d.rho));
    let left = (count - next) as f64;
    let sample = NextSample { rho: rho + (failed - rho) / (left + 1.0), from, effort: 1.0 };
    (sample.rho > rho).then_some(sample)
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
        return NextSample { rho, from: next.checked_sub(1), effort: effort(iterations) };
    }
    let coarse = &done[..COARSE];
    let fine = Fine::around(best_of(coarse), COARSE_STEP);
    let k = next - COARSE;
    let offset = fine.step * (k + 1) as f64;
    let from = fine.start + usize::from(offset > COARSE_STEP + 1e-12);
    let from = from.min(COARSE - 1);
    let rho = fine.ratios[k];
    let base = COARSE_STEP * from as f64;
    let iterations = fine_tune(budget, rho - base, base);
    NextSample { rho, from: Some(from), effort: effort(iterations) }
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
        let step = FINE_RANGE.min(1.0 - begin) / (FINE + 1) as f64;
        Fine { start, step, ratios: std::array::from_fn(|k| begin + step * (k + 1) as f64) }
    }
}

/// Position of the smallest smoothed total of the samples that passed; the first if none did.
pub fn best_of(samples: &[TakenSample]) -> usize {
    let totals: Vec<f64> = samples.iter().map(|d| d.total_w).collect();
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
