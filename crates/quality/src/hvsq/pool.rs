//! Pooled statistics of one map, their squared differences from a reference, and the derivative.
//!
//! With B the pooling, the mean is μ = B(m) and the deviation σ = √max(B(m²) − μ², 1e-7). B goes
//! to a coarse grid and interpolates back; per pixel only the second half is done.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, i32x16};
use fearless_simd_macros::simd;

use super::axis::Axis;
use super::plane::{LANES, Plane, lanes};
use super::reference::MapReference;
use super::{LEVELS, STATISTICS};

/// Least variance; below it deviations do not differ.
const FLOOR: f32 = 1e-7;

/// Sums of squared differences over a map.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Sums {
    /// Of means.
    pub mean: f64,
    /// Of deviations.
    pub deviation: f64,
}

/// Two coarse grids: of a map and of its square, or derivatives by them.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    /// Cells of a row.
    columns: usize,
    mean: Vec<f32>,
    square: Vec<f32>,
}

impl Grid {
    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<f32>() * (self.mean.capacity() + self.square.capacity())
    }

    fn sized(&mut self, [x, y]: &[Axis; 2]) {
        self.columns = x.cells.len();
        for values in [&mut self.mean, &mut self.square] {
            values.clear();
            values.resize(self.columns * y.cells.len(), 0.0);
        }
    }

    fn rows(&self, j: usize) -> [&[f32]; 2] {
        let range = j * self.columns..(j + 1) * self.columns;
        [&self.mean[range.clone()], &self.square[range]]
    }

    fn rows_mut(&mut self, j: usize) -> [&mut [f32]; 2] {
        let range = j * self.columns..(j + 1) * self.columns;
        [&mut self.mean[range.clone()], &mut self.square[range]]
    }
}

/// A pair of full rows: of means and squares, or derivatives by them.
type Pair = [Vec<f32>; 2];

/// Rows in flight.
#[derive(Debug, Default)]
pub struct Scratch {
    grid: Grid,
    slopes: Grid,
    sums: Pair,
    /// Interpolated rows above and below, of the map and of the reference.
    own: [Pair; 2],
    expected: [Pair; 2],
    /// Derivatives by the rows above and below.
    back: [Pair; 2],
}

impl Scratch {
    /// All full rows zero and `n` long.
    fn sized(&mut self, n: usize) {
        let pairs = [&mut self.own, &mut self.expected, &mut self.back];
        for row in pairs.into_iter().flatten().flatten().chain(&mut self.sums) {
            row.clear();
            row.resize(n, 0.0);
        }
    }
}

/// Pools a map and its square.
pub(crate) fn pooled(map: &Plane, axes: &[Axis; 2], scratch: &mut Scratch) -> Grid {
    scratch.sized(lanes(map.width));
    let mut grid = Grid::default();
    dispatch!(Level::new(), simd => pool(simd, map, axes, &mut scratch.sums, &mut grid));
    grid
}

fn pool<S: Simd>(simd: S, map: &Plane, axes: &[Axis; 2], sums: &mut Pair, grid: &mut Grid) {
    grid.sized(axes);
    let [x, y] = axes;
    for (j, &(first, end)) in y.cells.iter().enumerate() {
        let [mean, square] = sums;
        mean.fill(0.0);
        square.fill(0.0);
        for row in first..end {
            add_row(simd, map.row(row as usize), mean, square);
        }
        let [to_mean, to_square] = grid.rows_mut(j);
        let scale = 1.0 / (end - first) as f32;
        x.sums(mean, scale, to_mean);
        x.sums(square, scale, to_square);
    }
}

/// Adds a row and its square.
#[simd]
fn add_row<S: Simd>(simd: S, row: &[f32], mean: &mut [f32], square: &mut [f32]) {
    for i in (0..row.len()).step_by(LANES) {
        let v = f32x16::from_slice(simd, &row[i..i + LANES]);
        let m = f32x16::from_slice(simd, &mean[i..i + LANES]);
        let s = f32x16::from_slice(simd, &square[i..i + LANES]);
        (m + v).store_slice(&mut mean[i..i + LANES]);
        v.mul_add(v, s).store_slice(&mut square[i..i + LANES]);
    }
}

/// Compares a map of `level` with its reference at every pooling. With weights, `gradient` gets
/// the derivative of the weighted sum of measures by the map.
pub(crate) fn compare(
    map: &Plane,
    reference: &MapReference,
    level: usize,
    axes: &[[[Axis; 2]; LEVELS]],
    weights: Option<&[f64]>,
    mut gradient: Option<&mut Plane>,
    scratch: &mut Scratch,
) -> Vec<Sums> {
    scratch.sized(lanes(map.width));
    if let Some(gradient) = gradient.as_deref_mut() {
        gradient.body_mut().fill(0.0);
    }
    let mut all = Vec::with_capacity(axes.len());
    for (p, axes) in axes.iter().enumerate() {
        let weight = weights.map_or(0.0, |w| w[p]);
        let scale = (weight / (STATISTICS as f64 * 3.0 * map.area())) as f32;
        let axes = &axes[level];
        let gradient = gradient.as_deref_mut();
        let sums = match reference.pooled(p) {
            None => Sums { mean: unpooled(map, reference.map(), scale, gradient), deviation: 0.0 },
            Some(expected) => dispatch!(Level::new(), simd =>
                pooling(simd, map, expected, axes, scale, gradient, scratch)),
        };
        all.push(sums);
    }
    all
}

/// Where pooling changes nothing, means are the map itself and deviations are constant.
fn unpooled(map: &Plane, expected: &Plane, scale: f32, mut gradient: Option<&mut Plane>) -> f64 {
    let level = Level::new();
    let mut sum = 0.0;
    for y in 0..map.height {
        let rows = [map.row(y), expected.row(y)];
        let out = gradient.as_deref_mut().map_or(&mut [][..], |gradient| gradient.row_mut(y));
        sum += dispatch!(level, simd => compare_row(simd, rows, 2.0 * scale, out));
    }
    sum
}

/// The sum of squared differences of two rows. `out`, if any, gets the differences times `scale`
/// added.
#[simd]
fn compare_row<S: Simd>(simd: S, [a, b]: [&[f32]; 2], scale: f32, out: &mut [f32]) -> f64 {
    let mut sum = f32x16::splat(simd, 0.0);
    for i in (0..a.len()).step_by(LANES) {
        let a = f32x16::from_slice(simd, &a[i..i + LANES]);
        let off = a - f32x16::from_slice(simd, &b[i..i + LANES]);
        sum = off.mul_add(off, sum);
        if let Some(out) = out.get_mut(i..i + LANES) {
            off.mul_add(scale, f32x16::from_slice(simd, out)).store_slice(out);
        }
    }
    let lanes: [f32; LANES] = sum.into();
    lanes.iter().map(|&v| f64::from(v)).sum()
}

fn pooling<S: Simd>(
    simd: S,
    map: &Plane,
    expected: &Grid,
    axes: &[Axis; 2],
    scale: f32,
    gradient: Option<&mut Plane>,
    scratch: &mut Scratch,
) -> Sums {
    pool(simd, map, axes, &mut scratch.sums, &mut scratch.grid);
    scratch.slopes.sized(axes);
    let [x, y] = axes;
    let count = y.cells.len();
    let mut sums = Sums::default();
    widen(x, &scratch.grid, 0, &mut scratch.own[0]);
    widen(x, expected, 0, &mut scratch.expected[0]);
    scratch.back.iter_mut().flatten().for_each(|row| row.fill(0.0));
    for j in 0..count {
        let next = (j + 1).min(count - 1);
        widen(x, &scratch.grid, next, &mut scratch.own[1]);
        widen(x, expected, next, &mut scratch.expected[1]);
        let rows = y.taps.start[j] as usize..y.taps.start[j + 1] as usize;
        if !rows.is_empty() {
            let weights = &y.taps.weight[rows];
            let part = between(simd, &scratch.own, &scratch.expected, weights, &mut scratch.back);
            sums.mean += part.mean;
            sums.deviation += part.deviation;
        }
        if gradient.is_some() {
            let [mean, square] = scratch.slopes.rows_mut(j);
            x.taps.narrow(&scratch.back[0][0], scale, mean);
            x.taps.narrow(&scratch.back[0][1], scale, square);
        }
        scratch.own.swap(0, 1);
        scratch.expected.swap(0, 1);
        scratch.back.swap(0, 1);
        scratch.back[1].iter_mut().for_each(|row| row.fill(0.0));
    }
    if let Some(gradient) = gradient {
        spread(simd, map, axes, &scratch.slopes, &mut scratch.sums, gradient);
    }
    sums
}

/// Row `j` of both grids, interpolated to all columns.
pub(crate) fn widen(x: &Axis, grid: &Grid, j: usize, out: &mut Pair) {
    x.taps.widen(grid.rows(j), out);
}

/// Derivatives by the coarse grids, carried to the map.
fn spread<S: Simd>(
    simd: S,
    map: &Plane,
    [x, y]: &[Axis; 2],
    slopes: &Grid,
    sums: &mut Pair,
    gradient: &mut Plane,
) {
    for (j, &(first, end)) in y.cells.iter().enumerate() {
        let share = 1.0 / (end - first) as f32;
        for (coarse, full) in slopes.rows(j).into_iter().zip(sums.iter_mut()) {
            x.spread(coarse, share, full);
        }
        for row in first as usize..end as usize {
            add_slopes(simd, map.row(row), sums, gradient.row_mut(row));
        }
    }
}

/// Adds the derivative by the mean, and by the square times twice the map.
#[simd]
fn add_slopes<S: Simd>(simd: S, map: &[f32], slopes: &Pair, out: &mut [f32]) {
    for i in (0..map.len()).step_by(LANES) {
        let m = f32x16::from_slice(simd, &map[i..i + LANES]);
        let by_mean = f32x16::from_slice(simd, &slopes[0][i..i + LANES]);
        let by_square = f32x16::from_slice(simd, &slopes[1][i..i + LANES]);
        let sum = f32x16::from_slice(simd, &out[i..i + LANES]) + by_mean;
        (m + m).mul_add(by_square, sum).store_slice(&mut out[i..i + LANES]);
    }
}

/// 1/√v for positive v: a guess from the exponent, then Newton steps; relative errors 3e-2, 2e-3,
/// 5e-6, 3e-11.
#[inline(always)]
fn inverse_root<S: Simd>(simd: S, v: f32x16<S>) -> f32x16<S> {
    let half = v * -0.5;
    let bits = v.bitcast::<i32x16<S>>();
    let mut r = (i32x16::splat(simd, 0x5f37_59df) - (bits >> 1)).bitcast::<f32x16<S>>();
    for _ in 0..3 {
        r = r * (half * r).mul_add(r, f32x16::splat(simd, 1.5));
    }
    r
}

/// The rows between two coarse rows: sums of squared differences, and their derivatives by the
/// interpolated rows above and below, added to `back`.
#[simd]
fn between<S: Simd>(
    simd: S,
    own: &[Pair; 2],
    expected: &[Pair; 2],
    weights: &[f32],
    back: &mut [Pair; 2],
) -> Sums {
    let floor = f32x16::splat(simd, FLOOR);
    let zero = f32x16::splat(simd, 0.0);
    let (mut mean_sum, mut deviation_sum) = (zero, zero);
    let [[mean_above, square_above], [mean_below, square_below]] = back;
    for i in (0..mean_above.len()).step_by(LANES) {
        let own_mean = f32x16::from_slice(simd, &own[0][0][i..i + LANES]);
        let own_square = f32x16::from_slice(simd, &own[0][1][i..i + LANES]);
        let mean = f32x16::from_slice(simd, &expected[0][0][i..i + LANES]);
        let square = f32x16::from_slice(simd, &expected[0][1][i..i + LANES]);
        let own_mean_step = f32x16::from_slice(simd, &own[1][0][i..i + LANES]) - own_mean;
        let own_square_step = f32x16::from_slice(simd, &own[1][1][i..i + LANES]) - own_square;
        let mean_step = f32x16::from_slice(simd, &expected[1][0][i..i + LANES]) - mean;
        let square_step = f32x16::from_slice(simd, &expected[1][1][i..i + LANES]) - square;
        let (mut by_mean, mut by_mean_below) = (zero, zero);
        let (mut by_square, mut by_square_below) = (zero, zero);
        for &weight in weights {
            let w = f32x16::splat(simd, weight);
            let m = own_mean_step.mul_add(w, own_mean);
            let n = mean_step.mul_add(w, mean);
            let v = own_square_step.mul_add(w, own_square) - m * m;
            let u = (square_step.mul_add(w, square) - n * n).max(floor);
            let open = v.simd_gt(floor);
            let v = v.max(floor);
            let inverse = inverse_root(simd, v);
            let off = m - n;
            let apart = v * inverse - u * inverse_root(simd, u);
            mean_sum = off.mul_add(off, mean_sum);
            deviation_sum = apart.mul_add(apart, deviation_sum);
            // d(σ − σ')² / dE[m²] = (σ − σ') / σ.
            let slope = open.select(apart * inverse, zero);
            let slope_mean = (off - m * slope) * 2.0;
            by_mean += slope_mean;
            by_mean_below = slope_mean.mul_add(w, by_mean_below);
            by_square += slope;
            by_square_below = slope.mul_add(w, by_square_below);
        }
        for (row, sum) in [
            (&mut *mean_above, by_mean - by_mean_below),
            (&mut *mean_below, by_mean_below),
            (&mut *square_above, by_square - by_square_below),
            (&mut *square_below, by_square_below),
        ] {
            (f32x16::from_slice(simd, &row[i..i + LANES]) + sum)
                .store_slice(&mut row[i..i + LANES]);
        }
    }
    let total = |lanes: [f32; LANES]| lanes.iter().map(|&v| f64::from(v)).sum::<f64>();
    Sums { mean: total(mean_sum.into()), deviation: total(deviation_sum.into()) }
}
