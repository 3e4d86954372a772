//! Mean, quantiles and maximum over the frames of a run.

use super::Value;

/// One statistic over all frames of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aggregate {
    /// Mean, weighted with the [`Weight`](super::Weight) of the statistic.
    pub mean: f64,
    /// Median (nearest rank).
    pub p50: Value,
    /// 95 % of the frames are at or below this (nearest rank).
    pub p95: Value,
    /// 99 % of the frames are at or below this (nearest rank).
    pub p99: Value,
    /// The largest.
    pub max: Value,
}

impl Aggregate {
    /// Names of the parts, in report order.
    pub const PARTS: [&'static str; 5] = ["mean", "p50", "p95", "p99", "max"];

    /// The aggregate of `values`, one per frame, each with equal weight. `None` unless every frame
    /// has a value: a mean over some frames must not stand beside means over all of them.
    ///
    /// Quantiles are nearest-rank: the smallest value of the run such that at least p % of the
    /// frames are at or below it. So every quantile is a value that really occurred, counts stay
    /// integers, and p99 of fewer than 100 frames is the maximum.
    pub fn of(values: impl IntoIterator<Item = Option<Value>>) -> Option<Aggregate> {
        Self::weighted(values.into_iter().map(|value| (value, 1.0)))
    }

    /// The aggregate of pairs of value and positive weight in the mean, one per frame. Quantiles
    /// are those of [`Aggregate::of`].
    pub fn weighted(values: impl IntoIterator<Item = (Option<Value>, f64)>) -> Option<Aggregate> {
        let both = values.into_iter().map(|(value, weight)| Some((value?, weight)));
        let mut sorted = both.collect::<Option<Vec<(Value, f64)>>>()?;
        sorted.sort_by(|a, b| a.0.as_f64().total_cmp(&b.0.as_f64()));
        let max = sorted.last()?.0;
        let weights: f64 = sorted.iter().map(|(_, weight)| weight).sum();
        let mean = sorted.iter().map(|(v, weight)| v.as_f64() * weight).sum::<f64>() / weights;
        let quantile = |percent| sorted[nearest_rank(sorted.len(), percent)].0;
        Some(Aggregate { mean, p50: quantile(50), p95: quantile(95), p99: quantile(99), max })
    }

    /// The parts in the order of [`Aggregate::PARTS`].
    pub fn parts(&self) -> [Value; 5] {
        [Value::Real(self.mean), self.p50, self.p95, self.p99, self.max]
    }
}

/// Index of the nearest-rank quantile in `n > 0` sorted values: `ceil(n * percent / 100) - 1`, in
/// integers because `0.95 * n` is not exact.
fn nearest_rank(n: usize, percent: usize) -> usize {
    (n * percent).div_ceil(100).max(1) - 1
}
