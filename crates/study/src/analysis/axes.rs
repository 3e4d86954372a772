//! What every axis moves, and which axes move nothing.

use std::collections::HashMap;

use xxhash_rust::xxh3::Xxh3;

use super::question::Objective;
use super::table::Table;

/// What one axis does to one objective.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effect {
    /// Spread of the means per value of the axis, over the mean of all: the main effect.
    pub main: f64,
    /// Largest relative spread between designs that differ in this axis only; `None` without such
    /// designs (sampled spaces).
    pub alone: Option<f64>,
}

/// What one axis does.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Its key.
    pub name: String,
    /// Different values among the designs.
    pub values: usize,
    /// By objective.
    pub effects: Vec<Effect>,
}

impl Axis {
    /// Whether designs that differ in this axis only are equal in every objective. An axis without
    /// such designs is not called dead.
    pub fn is_dead(&self) -> bool {
        self.values > 1 && self.effects.iter().all(|e| e.alone.is_some_and(|a| a < DEAD))
    }

    /// The largest main effect.
    pub fn largest(&self) -> f64 {
        self.effects.iter().map(|e| e.main).fold(0.0, f64::max)
    }
}

/// Relative spreads below this are rounding of sums.
const DEAD: f64 = 1e-9;

/// The axes by their largest main effect over the designs `rows`, the largest first.
pub fn effects(table: &Table, objectives: &[Objective], rows: &[u32]) -> Vec<Axis> {
    let columns: Vec<&[f64]> =
        objectives.iter().map(|o| table.numbers(&o.name).unwrap_or(&[])).collect();
    let one = |axis: usize| {
        let words = &table.axes[axis].1;
        let mut seen = vec![false; words.distinct().len()];
        rows.iter().for_each(|&row| seen[words.code(row) as usize] = true);
        let values = seen.into_iter().filter(|s| *s).count();
        let groups = groups(table, axis, rows);
        let effect = |column: &&[f64]| Effect {
            main: main_effect(table, axis, rows, column),
            alone: alone_effect(&groups, column),
        };
        let effects = columns.iter().map(effect).collect();
        Axis { name: table.axes[axis].0.clone(), values, effects }
    };
    let mut all: Vec<Axis> = (0..table.axes.len()).map(one).collect();
    all.sort_by(|a, b| b.largest().total_cmp(&a.largest()));
    all
}

fn main_effect(table: &Table, axis: usize, rows: &[u32], column: &[f64]) -> f64 {
    let words = &table.axes[axis].1;
    let mut sums = vec![(0.0, 0_u64); words.distinct().len()];
    let (mut sum, mut n) = (0.0, 0_u64);
    for &row in rows {
        let value = column[row as usize];
        if value.is_finite() {
            let group = &mut sums[words.code(row) as usize];
            (group.0, group.1) = (group.0 + value, group.1 + 1);
            (sum, n) = (sum + value, n + 1);
        }
    }
    let means = sums.iter().filter(|(_, n)| *n > 0).map(|(sum, n)| sum / *n as f64);
    let ends = means.fold((f64::INFINITY, f64::NEG_INFINITY), |e, m| (e.0.min(m), e.1.max(m)));
    let mean = (sum / n as f64).abs();
    if mean > 0.0 && ends.1 > ends.0 { (ends.1 - ends.0) / mean } else { 0.0 }
}

/// For every row the number of its group; rows of one group differ in `axis` only.
fn groups(table: &Table, axis: usize, rows: &[u32]) -> Vec<(u32, u32)> {
    let mut numbers: HashMap<u128, u32> = HashMap::new();
    let group = |&row: &u32| {
        let mut hash = Xxh3::new();
        for (_, (_, words)) in table.axes.iter().enumerate().filter(|(a, _)| *a != axis) {
            hash.update(&words.code(row).to_le_bytes());
        }
        let next = numbers.len() as u32;
        (*numbers.entry(hash.digest128()).or_insert(next), row)
    };
    let mut groups: Vec<(u32, u32)> = rows.iter().map(group).collect();
    groups.sort_unstable();
    groups
}

fn alone_effect(groups: &[(u32, u32)], column: &[f64]) -> Option<f64> {
    let mut largest: Option<f64> = None;
    for group in groups.chunk_by(|a, b| a.0 == b.0) {
        let values =
            || group.iter().map(|(_, row)| column[*row as usize]).filter(|v| v.is_finite());
        if values().count() < 2 {
            continue;
        }
        let (low, high) =
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let size = low.abs().max(high.abs());
        let spread = if size > 0.0 { (high - low) / size } else { 0.0 };
        largest = Some(largest.map_or(spread, |l| l.max(spread)));
    }
    largest
}
