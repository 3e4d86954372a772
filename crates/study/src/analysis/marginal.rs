//! What the next square millimetre and the next milliwatt buy.
//!
//! Along the front: of all ways up from the cheapest design, each step goes to the design that
//! gains most per unit of the price, so the steps are the edges of the upper hull of (price, gain)
//! and their values fall. Around one design: what a single axis does, one value up and down.

use super::front::is_alike;
use super::question::Objective;
use super::table::Table;

/// What is paid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Price {
    /// Area, mm².
    Area,
    /// Power at the display rate, mW.
    Power,
}

impl Price {
    /// All of them.
    pub const ALL: [Price; 2] = [Price::Area, Price::Power];

    /// The column of the results that an answer with these objectives pays in: the core where that
    /// is an objective, else the die.
    pub fn column(self, objectives: &[Objective]) -> &'static str {
        const CORE: &str = "area_mm2.core";
        match self {
            Price::Area if objectives.iter().any(|o| o.name == CORE) => CORE,
            Price::Area => "area_mm2",
            Price::Power => "power_w.mean",
        }
    }

    /// The unit that gains are for.
    pub fn unit(self) -> &'static str {
        match self {
            Price::Area => "mm²",
            Price::Power => "mW",
        }
    }

    /// The price of a row, in its unit.
    pub fn of(self, table: &Table, objectives: &[Objective], row: u32) -> Option<f64> {
        let scale = match self {
            Price::Area => 1.0,
            Price::Power => 1e3,
        };
        Some(table.number(self.column(objectives), row)? * scale)
    }

    /// Whether the gain of an objective can be weighed against this price. Energy and power are
    /// one thing at a given rate.
    fn buys(self, objective: &Objective, objectives: &[Objective]) -> bool {
        let name = objective.name.as_str();
        let energy = || ["energy_pj", "power_", "edp_"].iter().any(|p| name.starts_with(p));
        name != self.column(objectives) && !(self == Price::Power && energy())
    }
}

/// A step along the front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Row of the design before.
    pub from: u32,
    /// Row of the design after.
    pub to: u32,
    /// What it costs more, in the unit of the price.
    pub price: f64,
    /// What it gains, in the unit of the objective's column; positive.
    pub gain: f64,
}

impl Step {
    /// Gain per unit of the price.
    pub fn value(&self) -> f64 {
        self.gain / self.price
    }
}

/// What a price buys of an objective, along the front.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Marginal {
    /// What is paid.
    pub price: Price,
    /// What is gained.
    pub objective: Objective,
    /// The steps, the cheapest and most worth first; at least one.
    pub steps: Vec<Step>,
}

/// What every price buys of every objective among the rows `front`. Differences up to the share
/// `epsilon` are no step.
pub fn along(
    table: &Table,
    objectives: &[Objective],
    front: &[u32],
    epsilon: f64,
) -> Vec<Marginal> {
    let mut all = Vec::new();
    for price in Price::ALL {
        for objective in objectives.iter().filter(|o| price.buys(o, objectives)) {
            let point = |&row: &u32| {
                let gain = -objective.goal.cost(table.number(&objective.name, row)?);
                Some((price.of(table, objectives, row)?, gain, row))
            };
            let steps = hull(front.iter().filter_map(point).collect(), epsilon);
            if !steps.is_empty() {
                all.push(Marginal { price, objective: objective.clone(), steps });
            }
        }
    }
    all
}

/// The edges of the upper hull of (price, gain, row) from the cheapest to the largest gain.
fn hull(mut points: Vec<(f64, f64, u32)>, epsilon: f64) -> Vec<Step> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2)));
    let mut kept: Vec<(f64, f64, u32)> = Vec::new();
    for point in points {
        if let Some(last) = kept.last() {
            if point.1 <= last.1 || is_alike(point.1, last.1, epsilon) {
                continue;
            }
            if is_alike(point.0, last.0, epsilon) {
                kept.pop();
            }
        }
        let slope = |a: &(f64, f64, u32), b: &(f64, f64, u32)| (b.1 - a.1) / (b.0 - a.0);
        while let [.., before, last] = kept.as_slice()
            && slope(before, last) <= slope(last, &point)
        {
            kept.pop();
        }
        kept.push(point);
    }
    let step = |pair: &[(f64, f64, u32)]| Step {
        from: pair[0].2,
        to: pair[1].2,
        price: pair[1].0 - pair[0].0,
        gain: pair[1].1 - pair[0].1,
    };
    kept.windows(2).map(step).collect()
}

/// A design that differs from another in one axis only.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Neighbour {
    /// Position of the axis.
    pub axis: usize,
    /// Row of the other design.
    pub row: u32,
    /// What it gains in every objective, in the unit of its column; negative where it loses.
    pub gains: Vec<Option<f64>>,
    /// What it costs more, mm² and mW.
    pub prices: [Option<f64>; Price::ALL.len()],
}

/// The designs among `rows` that differ from `reference` in one axis: of an axis of numbers the
/// next values below and above, of an axis of names all. In the order of axes and values.
pub fn around(
    table: &Table,
    objectives: &[Objective],
    rows: &[u32],
    reference: u32,
) -> Vec<Neighbour> {
    let mut found: Vec<Vec<u32>> = vec![Vec::new(); table.axes.len()];
    // Of two models of the memory the difference would be in it too.
    let same_model = |row: u32| table.models.code(row) == table.models.code(reference);
    for &row in rows.iter().filter(|row| same_model(**row)) {
        let mut differing =
            (0..table.axes.len()).filter(|&a| !table.axes[a].1.same(row, reference));
        if let (Some(axis), None) = (differing.next(), differing.next()) {
            found[axis].push(row);
        }
    }
    let mut all = Vec::new();
    for (axis, mut rows) in found.into_iter().enumerate() {
        let words = &table.axes[axis].1;
        if words.is_numeric() {
            rows = next_to(&rows, |row| words.number(row).unwrap_or(f64::NAN), reference);
        }
        for row in rows {
            let gain = |o: &Objective| {
                let (new, old) = (table.number(&o.name, row)?, table.number(&o.name, reference)?);
                Some(o.goal.gain(old, new))
            };
            let more = |p: Price| {
                Some(p.of(table, objectives, row)? - p.of(table, objectives, reference)?)
            };
            let gains = objectives.iter().map(gain).collect();
            all.push(Neighbour { axis, row, gains, prices: Price::ALL.map(more) });
        }
    }
    all
}

/// The rows with the largest value below and the smallest above that of `reference`.
fn next_to(rows: &[u32], value: impl Fn(u32) -> f64, reference: u32) -> Vec<u32> {
    let here = value(reference);
    let by_value = |a: &&u32, b: &&u32| value(**a).total_cmp(&value(**b));
    let below = rows.iter().filter(|r| value(**r) < here).max_by(by_value);
    let above = rows.iter().filter(|r| value(**r) > here).min_by(by_value);
    below.into_iter().chain(above).copied().collect()
}
