//! Axes: title, scale, and ticks at round values.

use super::Words;

/// An axis of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it shows, with its unit; may be empty.
    pub title: String,
    /// Its scale.
    pub scale: Scale,
    /// Which values are labelled.
    pub ticks: Ticks,
    /// Whether lines cross the panel at the ticks.
    pub grid: bool,
    /// Whether ticks and title are shown.
    pub shown: bool,
    /// Whether values are positions, such as times or numbers of frames: their axis may begin
    /// anywhere. A scale of amounts that does not begin at zero gets a mark.
    pub positions: bool,
}

impl Axis {
    /// An axis with ticks and grid lines.
    pub fn new(title: impl Into<String>, scale: Scale) -> Axis {
        let grid = !matches!(scale, Scale::Names(_));
        let (ticks, title) = (Ticks::About(6), title.into());
        Axis { title, scale, ticks, grid, shown: true, positions: false }
    }

    /// An axis of names, one place for each.
    pub fn names(names: impl IntoIterator<Item = impl Into<Name>>) -> Axis {
        Axis::new("", Scale::Names(names.into_iter().map(Into::into).collect()))
    }

    /// With about `count` ticks.
    pub fn ticks(self, count: usize) -> Axis {
        Axis { ticks: Ticks::About(count), ..self }
    }

    /// About `count` ticks, at whole numbers.
    pub fn whole(self, count: usize) -> Axis {
        Axis { ticks: Ticks::Whole(count), ..self }
    }

    /// Ticks at these values with these labels.
    pub fn labelled(self, labels: Vec<(f64, String)>) -> Axis {
        Axis { ticks: Ticks::At(labels), ..self }
    }

    /// Without grid lines.
    pub fn plain(self) -> Axis {
        Axis { grid: false, ..self }
    }

    /// Without ticks and title.
    pub fn hidden(self) -> Axis {
        Axis { shown: false, grid: false, ..self }
    }

    /// Of positions, not of amounts.
    pub fn positions(self) -> Axis {
        Axis { positions: true, ..self }
    }

    /// Whether the scale leaves out zero: lengths on it are no ratios.
    pub fn is_broken(&self) -> bool {
        let Scale::Linear { low, high } = self.scale else { return false };
        self.shown && !self.positions && low < high && (low > 0.0 || high < 0.0)
    }

    /// The title, and whether the scale is logarithmic.
    pub fn words(&self) -> String {
        match self.scale {
            Scale::Log { .. } if self.title.is_empty() => "log scale".into(),
            Scale::Log { .. } => format!("{} (log)", self.title),
            Scale::Linear { .. } | Scale::Names(_) => self.title.clone(),
        }
    }

    /// A value of this axis in words: the name at its place, or its title with four digits.
    pub(crate) fn spoken(&self, value: f64) -> String {
        if let Scale::Names(names) = &self.scale {
            let name = names.get(value.floor().max(0.0) as usize);
            return name.map_or_else(String::new, |name| name.words.text.clone());
        }
        let number = four_digits(value);
        if self.title.is_empty() { number } else { format!("{}: {number}", self.title) }
    }

    /// The values of the ticks with their labels. Names are in the middle of their places.
    pub fn labels(&self) -> Vec<(f64, String)> {
        let numbers = match (&self.ticks, &self.scale) {
            (Ticks::At(labels), _) => return labels.clone(),
            (_, Scale::Names(names)) => {
                let place = |(i, n): (usize, &Name)| (i as f64 + 0.5, n.words.text.clone());
                return names.iter().enumerate().map(place).collect();
            }
            (Ticks::About(count), scale) => scale.ticks(*count),
            (Ticks::Whole(count), scale) => scale.whole_ticks(*count),
        };
        numbers.iter().map(|t| (*t, label(*t, &numbers))).collect()
    }
}

/// Which values an axis labels.
#[derive(Debug, Clone, PartialEq)]
pub enum Ticks {
    /// About as many round values; all names of an axis of names.
    About(usize),
    /// As many, whole numbers only.
    Whole(usize),
    /// These.
    At(Vec<(f64, String)>),
}

/// A place on an axis of names.
#[derive(Debug, Clone, PartialEq)]
pub struct Name {
    /// The name.
    pub words: Words,
    /// What stands before all names, at the edge of the page; may be empty.
    pub lead: String,
}

impl<T: Into<Words>> From<T> for Name {
    fn from(words: T) -> Name {
        Name { words: words.into(), lead: String::new() }
    }
}

/// The values of an axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// Equal steps are equally far apart.
    Linear {
        /// Where the axis begins; above `high` on an axis that is turned round.
        low: f64,
        /// Where it ends.
        high: f64,
    },
    /// Equal ratios are equally far apart. Both ends are positive.
    Log {
        /// Where the axis begins.
        low: f64,
        /// Where it ends.
        high: f64,
    },
    /// A place for each name, from 0 to their number: left to right, or downwards.
    Names(Vec<Name>),
}

impl Scale {
    /// From 0 to a round number at or above `high`. All-zero data get a scale to 1.
    pub fn from_zero(high: f64) -> Scale {
        let high = if high > 0.0 && high.is_finite() { high } else { 1.0 };
        let step = nice_step(high, 6);
        Scale::Linear { low: 0.0, high: (high / step - 1e-9).ceil() * step }
    }

    /// From `low` to `high` exactly.
    pub fn linear(low: f64, high: f64) -> Scale {
        let low = if low.is_finite() { low } else { 0.0 };
        let high = if high.is_finite() && high != low { high } else { low + low.abs().max(1.0) };
        Scale::Linear { low, high }
    }

    /// Logarithmic, rounded outwards to 1, 2 or 5 times a power of ten. Only positive values have a
    /// place on it.
    pub fn logarithmic(low: f64, high: f64) -> Scale {
        let is_positive = |v: f64| v > f64::MIN_POSITIVE && v.is_finite();
        let low = if is_positive(low) { low } else { 1.0 };
        let high = if is_positive(high) { high.max(low) } else { low };
        let first = |ticks: Vec<f64>| ticks.first().copied();
        let low = first(one_two_five(low, low)).unwrap_or(low);
        let high = one_two_five(high, high).last().copied().unwrap_or(high);
        Scale::Log { low, high: if high > low { high } else { low * 10.0 } }
    }

    /// Linear around the finite ones of `values`, with a share of `room` at both ends; never below
    /// zero if no value is.
    pub fn around(values: impl IntoIterator<Item = f64>, room: f64) -> Scale {
        let (low, high) = ends(values);
        if low > high {
            return Scale::linear(0.0, 1.0);
        }
        if high - low <= 1e-9 * high.abs() {
            let around = 0.1 * high.abs().max(1e-9);
            return Scale::linear(low - around, high + around);
        }
        let width = (high - low).max(0.02 * high.abs()).max(1e-9);
        let below = low - room * width;
        Scale::linear(if low >= 0.0 { below.max(0.0) } else { below }, high + room * width)
    }

    /// Linear from a round number at or below `low` to one at or above `high`, so that the ends
    /// have ticks; never below zero if `low` is not.
    pub fn rounded(low: f64, high: f64) -> Scale {
        let whole = Scale::linear(low, high);
        let (low, high) = (whole.low(), whole.high());
        let step = nice_step(high - low, 6);
        let at = |v: f64, round: fn(f64) -> f64, slack: f64| round(v / step + slack) * step;
        Scale::linear(at(low, f64::floor, 1e-9), at(high, f64::ceil, -1e-9))
    }

    /// The smallest value.
    pub fn low(&self) -> f64 {
        match self {
            Scale::Linear { low, high } => low.min(*high),
            Scale::Log { low, .. } => *low,
            Scale::Names(_) => 0.0,
        }
    }

    /// The largest value.
    pub fn high(&self) -> f64 {
        match self {
            Scale::Linear { low, high } => low.max(*high),
            Scale::Log { high, .. } => *high,
            Scale::Names(names) => names.len().max(1) as f64,
        }
    }

    /// Where a value is between the beginning of the axis (0) and its end (1); values off the axis
    /// are at its ends, numbers that are none at its beginning.
    pub fn share(&self, value: f64) -> f64 {
        let share = match self {
            Scale::Linear { low, high } => (value - low) / (high - low),
            Scale::Log { low, high } => (value.max(*low) / low).ln() / (high / low).ln(),
            Scale::Names(_) => value / self.high(),
        };
        if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
    }

    /// About `count` values to label, ascending; at least three.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        let few = self.some_ticks(count);
        if few.len() > 2 {
            return few;
        }
        let more = (3..=12).map(|count| self.some_ticks(count)).find(|t| t.len() > 2);
        // Less than a decade has fewer than three of 1, 2 and 5 times a power of ten.
        let inside = || Scale::linear(self.low(), self.high()).ticks(5);
        match self {
            Scale::Log { .. } => more.unwrap_or_else(inside),
            Scale::Linear { .. } | Scale::Names(_) => more.unwrap_or(few),
        }
    }

    fn some_ticks(&self, count: usize) -> Vec<f64> {
        let (low, high) = (self.low(), self.high());
        if let Scale::Log { .. } = self {
            let all = one_two_five(low, high);
            let decades: Vec<f64> = all
                .iter()
                .copied()
                .filter(|t| (t.log10() - t.log10().round()).abs() < 1e-9)
                .collect();
            return if all.len() <= 2 * count || decades.len() < 2 { all } else { decades };
        }
        let step = nice_step(high - low, count);
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        (first..=last.min(first.saturating_add(100))).map(|i| i as f64 * step).collect()
    }

    /// As [`Scale::ticks`], whole numbers only.
    pub fn whole_ticks(&self, count: usize) -> Vec<f64> {
        let mut ticks: Vec<f64> = self.ticks(count).iter().map(|t| t.round()).collect();
        ticks.dedup();
        ticks.retain(|t| *t >= self.low() && *t <= self.high());
        ticks
    }
}

/// The least and the largest of the finite ones of `values`; turned round if there is none.
pub fn ends(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let finite = values.into_iter().filter(|v| v.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |e, v| (e.0.min(v), e.1.max(v)))
}

/// A step of 1, 2 or 5 times a power of ten that cuts `range` into at most about `count` parts.
fn nice_step(range: f64, count: usize) -> f64 {
    let raw = (range / count.max(1) as f64).max(f64::MIN_POSITIVE);
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
        format!("{value}")
    } else if high > 1.5 * low && value > 0.0 {
        format!("{value:.*}", digits(value))
    } else {
        format!("{value:.*}", digits(low))
    }
}

/// A number with four digits, or as many as stand before its point.
pub(crate) fn four_digits(value: f64) -> String {
    if !value.is_finite() {
        return "no number".into();
    }
    let before = value.abs().log10().floor();
    if value == 0.0 {
        "0".into()
    } else if !(-6.0..9.0).contains(&before) {
        format!("{value:.3e}")
    } else {
        let text = format!("{value:.*}", (3.0 - before).max(0.0) as usize);
        let short = text.trim_end_matches('0').trim_end_matches('.');
        if text.contains('.') { short.into() } else { text }
    }
}
