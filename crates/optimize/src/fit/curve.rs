//! One Michaelis-Menten curve: the fit, its shape and how good it is.

/// What a fitted curve looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// V and K are determined.
    Curved,
    /// Nearly a straight line: only V / K is determined.
    Straight,
    /// All of the drop is at the first sample: only V is determined.
    Step,
    /// The power does not depend on ρ, or changes against the model: V is 0.
    Flat,
}

impl Shape {
    /// Its name in outputs.
    pub fn name(self) -> &'static str {
        match self {
            Shape::Curved => "curved",
            Shape::Straight => "straight",
            Shape::Step => "step",
            Shape::Flat => "flat",
        }
    }
}

/// The drop from the largest power: `V x / (K + x)` of the range, x from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curve {
    /// Least power of the samples, W.
    pub low_w: f64,
    /// Largest power of the samples, W: the curve at x = 0.
    pub high_w: f64,
    /// s: the drop at x = 1 as a share of the range; V / (1 + K).
    pub drop: f64,
    /// t: K / (1 + K), above 0, at most 1.
    pub bend: f64,
    /// Share of the variance that the curve explains; `None` if there is none. May be negative.
    pub r2: Option<f64>,
    /// Mean of |fit − power| / power; `None` if a power is 0.
    pub mre: Option<f64>,
}

/// Least t: K is then 1e-9, a step for all data.
const BEND_MIN: f64 = 1e-9;
/// Places that are tried before the search narrows.
const SCAN: usize = 400;
/// From this K on the curve differs from a straight line by at most 1 % of its range.
const STRAIGHT: f64 = 24.0;
/// Up to this K the drop at a hundredth of the range is complete to 1 %.
const STEP: f64 = 1e-4;
/// Below this the curve does not describe the samples.
const R2_POOR: f64 = 0.9;

impl Curve {
    /// Fits `(x, watts)`, x from 0 to 1.
    pub(super) fn fit(points: &[(f64, f64)]) -> Curve {
        let low_w = points.iter().fold(f64::INFINITY, |a, p| a.min(p.1));
        let high_w = points.iter().fold(f64::NEG_INFINITY, |a, p| a.max(p.1));
        let range = high_w - low_w;
        let drops: Vec<(f64, f64)> = points
            .iter()
            .map(|&(x, w)| (x, if range > 0.0 { (high_w - w) / range } else { 0.0 }))
            .collect();
        let bend = best_bend(&drops);
        let (drop, _) = best_drop(&drops, bend);
        let mut curve = Curve { low_w, high_w, drop, bend, r2: None, mre: None };
        curve.judge(points);
        curve
    }

    /// Goodness on the samples, in watts.
    fn judge(&mut self, points: &[(f64, f64)]) {
        let n = points.len() as f64;
        let mean = points.iter().map(|p| p.1).sum::<f64>() / n;
        let spread: f64 = points.iter().map(|p| (p.1 - mean).powi(2)).sum();
        let rest: f64 = points.iter().map(|p| (p.1 - self.at(p.0)).powi(2)).sum();
        self.r2 = (self.high_w > self.low_w && spread > 0.0).then(|| 1.0 - rest / spread);
        let relative = points.iter().map(|p| (self.at(p.0) - p.1).abs() / p.1).sum::<f64>() / n;
        self.mre = points.iter().all(|p| p.1 > 0.0).then_some(relative);
    }

    /// Watts at x.
    pub fn at(&self, x: f64) -> f64 {
        self.high_w - (self.high_w - self.low_w) * self.drop * shape(self.bend, x)
    }

    /// V; infinite for a straight line.
    pub fn v(&self) -> f64 {
        if self.drop == 0.0 { 0.0 } else { self.drop / (1.0 - self.bend) }
    }

    /// K; infinite for a straight line.
    pub fn k(&self) -> f64 {
        self.bend / (1.0 - self.bend)
    }

    /// What it looks like.
    pub fn shape(&self) -> Shape {
        match self.k() {
            _ if self.drop == 0.0 || self.high_w == self.low_w => Shape::Flat,
            k if k >= STRAIGHT => Shape::Straight,
            k if k <= STEP => Shape::Step,
            _ => Shape::Curved,
        }
    }

    /// What a reader should know about this curve.
    pub(super) fn note(&self) -> Option<String> {
        let poor = self.r2.is_some_and(|r2| r2 < R2_POOR);
        let what = match self.shape() {
            Shape::Flat if self.high_w == self.low_w => "is the same in all samples",
            Shape::Flat => "does not fall as the model says; the fit is a constant",
            Shape::Straight if poor => {
                "bends the other way than the model; the fit is a straight line"
            }
            Shape::Straight => "is nearly a straight line, so V and K are not determined, V/K is",
            Shape::Step => "drops all at once, so K is not determined",
            Shape::Curved if poor => "is not described well by the model",
            Shape::Curved => return None,
        };
        let r2 = self.r2.filter(|_| poor).map_or(String::new(), |r2| format!(" (R2 {r2:.3})"));
        Some(format!("{what}{r2}"))
    }

    /// √A of the derivative `A / (t + (1 − t) x)²` of the drop, in watts.
    pub(super) fn root_slope(&self) -> f64 {
        ((self.high_w - self.low_w) * self.drop * self.bend).sqrt()
    }
}

/// The curve with s = 1.
fn shape(bend: f64, x: f64) -> f64 {
    x / (bend + (1.0 - bend) * x)
}

/// The best s ≥ 0 for t, and the sum of squares that it leaves.
fn best_drop(points: &[(f64, f64)], bend: f64) -> (f64, f64) {
    let (mut along, mut square) = (0.0, 0.0);
    for &(x, y) in points {
        let f = shape(bend, x);
        along += f * y;
        square += f * f;
    }
    // Some x is 1: the square is not 0.
    let drop = (along / square).max(0.0);
    let rest = points.iter().map(|&(x, y)| (y - drop * shape(bend, x)).powi(2)).sum();
    (drop, rest)
}

/// The t that leaves the least squares; the straightest of equally good ones. Small t are looked
/// at closely: t = BEND_MIN + (1 − BEND_MIN) p³.
fn best_bend(points: &[(f64, f64)]) -> f64 {
    let bend = |p: f64| BEND_MIN + (1.0 - BEND_MIN) * p * p * p;
    let rest = |p: f64| best_drop(points, bend(p)).1;
    let at = |i: usize| i as f64 / SCAN as f64;
    let (mut best, mut least) = (SCAN, rest(1.0));
    // From the straight end, and only by more than rounding: of equal fits the straightest stays.
    for i in (0..SCAN).rev() {
        let value = rest(at(i));
        if value < least - 1e-15 {
            (best, least) = (i, value);
        }
    }
    // The narrowing search never ends on an end itself.
    let found = golden(at(best.saturating_sub(1)), at((best + 1).min(SCAN)), rest);
    bend(if rest(found) < least { found } else { at(best) })
}

/// Golden-section search for a minimum between `a` and `b`.
fn golden(mut a: f64, mut b: f64, value: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_8;
    let (mut c, mut d) = (b - RATIO * (b - a), a + RATIO * (b - a));
    let (mut at_c, mut at_d) = (value(c), value(d));
    // 0.618 to the 80th is below the precision of a double.
    for _ in 0..80 {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - RATIO * (b - a);
            at_c = value(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + RATIO * (b - a);
            at_d = value(d);
        }
    }
    (a + b) / 2.0
}
