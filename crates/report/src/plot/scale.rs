//! Scales: from values to page coordinates, with ticks that people would have chosen.

use crate::format::significant;

/// A map from values to one page coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    /// Page coordinates of `low` and `high`.
    page: (f64, f64),
    logarithmic: bool,
}

impl Scale {
    /// From 0 to a round number at or above `high`. All-zero data get a scale to 1.
    pub fn from_zero(high: f64, page: (f64, f64)) -> Scale {
        let high = if high > 0.0 && high.is_finite() { high } else { 1.0 };
        let step = nice_step(high, 6);
        Scale { low: 0.0, high: (high / step - 1e-9).ceil() * step, page, logarithmic: false }
    }

    /// From `low` to `high` exactly, linear.
    pub fn exact(low: f64, high: f64, page: (f64, f64)) -> Scale {
        let high = if high > low { high } else { low + 1.0 };
        Scale { low, high, page, logarithmic: false }
    }

    /// Logarithmic, rounded outwards to 1, 2 or 5 times a power of ten. `low` is positive.
    pub fn logarithmic(low: f64, high: f64, page: (f64, f64)) -> Scale {
        let low = *one_two_five(low, low).first().expect("a tick at or below");
        let high = *one_two_five(high, high).last().expect("a tick at or above");
        let high = if high > low { high } else { low * 10.0 };
        Scale { low, high, page, logarithmic: true }
    }

    /// The page coordinate of `value`, kept on the page.
    pub fn at(&self, value: f64) -> f64 {
        let share = if self.logarithmic {
            (value.max(self.low) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.page.0 + share.clamp(0.0, 1.0) * (self.page.1 - self.page.0)
    }

    /// The smallest value on the scale.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// The largest value on the scale.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// About `count` values to label, ascending.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        if self.logarithmic {
            let all = one_two_five(self.low, self.high);
            let decades: Vec<f64> = all
                .iter()
                .copied()
                .filter(|t| (t.log10() - t.log10().round()).abs() < 1e-9)
                .collect();
            return if all.len() <= 2 * count || decades.len() < 2 { all } else { decades };
        }
        let step = nice_step(self.high - self.low, count);
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }

    /// As [`Scale::ticks`], whole numbers only.
    pub fn whole_ticks(&self, count: usize) -> Vec<f64> {
        let mut ticks: Vec<f64> = self.ticks(count).iter().map(|t| t.round()).collect();
        ticks.dedup();
        ticks.retain(|t| *t >= self.low && *t <= self.high);
        ticks
    }
}

/// A step of 1, 2 or 5 times a power of ten that cuts `range` into at most about `count` parts.
fn nice_step(range: f64, count: usize) -> f64 {
    let raw = range / count as f64;
    let magnitude = 10f64.powf(raw.log10().floor());
    let factor = match raw / magnitude {
        f if f <= 1.0 + 1e-9 => 1.0,
        f if f <= 2.0 + 1e-9 => 2.0,
        f if f <= 5.0 + 1e-9 => 5.0,
        _ => 10.0,
    };
    factor * magnitude
}

/// All 1, 2, 5 times powers of ten from the last at or below `low` to the first at or above `high`.
fn one_two_five(low: f64, high: f64) -> Vec<f64> {
    let mut ticks = Vec::new();
    let first = low.log10().floor() as i32;
    let last = high.log10().ceil() as i32;
    for exponent in first..=last {
        ticks.extend([1.0, 2.0, 5.0].map(|f| f * 10f64.powi(exponent)));
    }
    let start = ticks.iter().rposition(|t| *t <= low * (1.0 + 1e-9)).unwrap_or(0);
    let end = ticks.iter().position(|t| *t >= high * (1.0 - 1e-9)).unwrap_or(ticks.len() - 1);
    ticks[start..=end.max(start)].to_vec()
}

/// The text of a tick: as many digits as the step needs (on a logarithmic scale: the tick itself),
/// and no noise.
pub fn label(value: f64, ticks: &[f64]) -> String {
    let steps = || ticks.windows(2).map(|w| w[1] - w[0]);
    let (low, high) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
    let digits = |x: f64| (-(x.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize;
    if !low.is_finite() {
        significant(value)
    } else if high > 1.5 * low && value > 0.0 {
        format!("{value:.*}", digits(value))
    } else {
        format!("{value:.*}", digits(low))
    }
}
