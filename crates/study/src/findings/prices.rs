//! How far the price assumptions that are in use move the power of a run: its counts priced again
//! with the knob of each at its low and high, and nothing simulated.

/// What one assumption does to the power.
#[derive(Debug, Clone, PartialEq)]
pub struct PriceBar {
    /// Number in the docs: `A40`.
    pub assumption: String,
    /// The keys that were turned.
    pub keys: Vec<String>,
    /// Least power at the display rate, watts.
    pub low_w: f64,
    /// Greatest power at the display rate, watts.
    pub high_w: f64,
}

impl PriceBar {
    /// From the least to the greatest power, watts.
    pub fn spread_w(&self) -> f64 {
        self.high_w - self.low_w
    }
}

/// The assumptions behind the prices of a run, one at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct PriceBars {
    /// Power at the display rate with the prices as they are, watts.
    pub power_w: f64,
    /// Those that move it by [`PriceBars::LEAST`] or more, the widest first; one each.
    pub bars: Vec<PriceBar>,
}

impl PriceBars {
    /// A bar that is narrower than this share of the power is none.
    pub const LEAST: f64 = 0.005;

    /// The bars in order. Of several knobs of one assumption the widest counts.
    pub fn new(power_w: f64, bars: impl IntoIterator<Item = PriceBar>) -> PriceBars {
        let least = power_w * PriceBars::LEAST;
        let mut bars: Vec<PriceBar> = bars.into_iter().filter(|b| b.spread_w() >= least).collect();
        // Equal ones stay in the order of their numbers.
        bars.sort_by(|a, b| b.spread_w().total_cmp(&a.spread_w()));
        let mut seen = std::collections::BTreeSet::new();
        bars.retain(|bar| seen.insert(bar.assumption.clone()));
        PriceBars { power_w, bars }
    }
}
