//! Pooled statistics of one map, their squared differences from a reference, and the derivative.
//!
//! With B the pooling, the mean is μ = B(m) and the deviation σ = √max(B(m²) − μ², 1e-7). B goes
//! to a coarse grid and interpolates back; per pixel only the second half is done.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, i32x16};
use fearless_simd_macros::simd;

use super::axis::{Axis, AxisColumns, Rows};
use super::plane::{LANES, Plane, lanes};
use super::reference::MapReference;
use super::{LEVELS, STATISTICS};

/// Least variance; below it deviations do not differ.
const FLOOR: f32 = 1e-7;

/// Sums of squared differences over a map.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct PoolSums {
    /// Of means.
    pub mean: f64,
    /// Of deviations.
    pub deviation: f64,
}

/// Two coarse grids: of a map and of its square, or derivatives by them.
#[derive(Debug, Clone, Default)]
pub struct PoolGrid {
    /// Cells of a row.
    columns: usize,
    mean: Vec<f32>,
    square: Vec<f32>,
}

impl PoolGrid {
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

    /// Rows of cells: of means and squares.
    fn rows(&self, range: Range<usize>) -> [Rows<&[f32]>; 2] {
        let (range, len) = (range.start * self.columns..range.end * self.columns, self.columns);
        [&self.mean, &self.square].map(|values| Rows { values: &values[range.clone()], len })
    }

    fn rows_mut(&mut self, range: Range<usize>) -> [Rows<&mut [f32]>; 2] {
        let (range, len) = (range.start * self.columns..range.end * self.columns, self.columns);
        [&mut self.mean, &mut self.square]
            .map(|values| Rows { values: &mut values[range.clone()], len })
    }
}

/// Full rows: of means and squares, or derivatives by them.
type PoolPair = [Vec<f32>; 2];

/// Full rows in flight: one carried over from the rows before, sixteen, and one after the last.
const IN_FLIGHT: usize = LANES + 2;

/// Rows in flight.
#[derive(Debug, Default)]
pub struct PoolScratch {
    grid: PoolGrid,
    slopes: PoolGrid,
    columns: AxisColumns,
    /// Values of a full row.
    len: usize,
    sums: PoolPair,
    /// Interpolated rows of the map and of the reference.
    own: PoolPair,
    expected: PoolPair,
    /// Derivatives by the rows.
    back: PoolPair,
}

impl PoolScratch {
    fn sized(&mut self, len: usize) {
        self.len = len;
        let pairs = [&mut self.own, &mut self.expected, &mut self.back, &mut self.sums];
        for rows in pairs.into_iter().flatten() {
            rows.resize(IN_FLIGHT * len, 0.0);
        }
    }

    /// Row `j` of both lists of a grid, interpolated to all columns.
    pub(crate) fn widen(&mut self, x: &Axis, grid: &PoolGrid, j: usize, out: &mut PoolPair) {
        let out = &mut out.each_mut().map(|row| &mut row[..]);
        dispatch!(Level::new(), simd => widen(simd, x, grid, j..j + 1, out, &mut self.columns));
    }
}

/// Pools a map and its square.
pub(crate) fn pooled(map: &Plane, axes: &[Axis; 2], scratch: &mut PoolScratch) -> PoolGrid {
    scratch.sized(lanes(map.width));
    dispatch!(Level::new(), simd => pool(simd, map, axes, scratch));
    std::mem::take(&mut scratch.grid)
}

fn pool<S: Simd>(simd: S, map: &Plane, axes: &[Axis; 2], scratch: &mut PoolScratch) {
    let PoolScratch { grid, columns, len, sums, .. } = scratch;
    let len = *len;
    grid.sized(axes);
    let [x, y] = axes;
    for (first, cells) in (0..).step_by(LANES).zip(y.cells.chunks(LANES)) {
        let mut scale = [0.0; LANES];
        let [mean, square] = sums;
        for (k, &(first, end)) in cells.iter().enumerate() {
            let range = k * len..(k + 1) * len;
            let (mean, square) = (&mut mean[range.clone()], &mut square[range]);
            mean.fill(0.0);
            square.fill(0.0);
            for row in first..end {
                add_row(simd, map.row(row as usize), mean, square);
            }
            scale[k] = 1.0 / (end - first) as f32;
        }
        let to = grid.rows_mut(first..first + cells.len());
        for (sums, to) in [mean, square].into_iter().zip(to) {
            let rows = Rows { values: &sums[..cells.len() * len], len };
            columns.sums(simd, x, rows, &scale, to);
        }
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
    scratch: &mut PoolScratch,
) -> Vec<PoolSums> {
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
            None => {
                PoolSums { mean: unpooled(map, reference.map(), scale, gradient), deviation: 0.0 }
            }
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
    expected: &PoolGrid,
    axes: &[Axis; 2],
    scale: f32,
    gradient: Option<&mut Plane>,
    scratch: &mut PoolScratch,
) -> PoolSums {
    pool(simd, map, axes, scratch);
    let PoolScratch { grid, slopes, columns, len, own, expected: wanted, back, sums: spare } =
        scratch;
    let len = *len;
    slopes.sized(axes);
    let [x, y] = axes;
    let count = y.cells.len();
    let mut sums = PoolSums::default();
    for first in (0..count).step_by(LANES) {
        // Row 0 is the one before `first`.
        let some = LANES.min(count - first);
        let is_last = first + some == count;
        widen(
            simd,
            x,
            grid,
            first..first + some,
            &mut own.each_mut().map(|r| &mut r[len..]),
            columns,
        );
        let to = &mut wanted.each_mut().map(|rows| &mut rows[len..]);
        widen(simd, x, expected, first..first + some, to, columns);
        back.iter_mut().for_each(|rows| rows[len..].fill(0.0));
        if is_last {
            for rows in own.iter_mut().chain(wanted.iter_mut()) {
                rows.copy_within(some * len..(some + 1) * len, (some + 1) * len);
            }
        }
        // Rows that have the next one beside them.
        let ready = usize::from(first == 0)..some + usize::from(is_last);
        for k in ready.clone() {
            let j = first + k - 1;
            let rows = y.taps.start[j] as usize..y.taps.start[j + 1] as usize;
            if !rows.is_empty() {
                let at = k * len..(k + 2) * len;
                let weights = &y.taps.weight[rows];
                let [own, wanted] =
                    [&*own, &*wanted].map(|pair| pair.each_ref().map(|rows| &rows[at.clone()]));
                let back = back.each_mut().map(|rows| &mut rows[at.clone()]);
                let part = between(simd, len, own, wanted, weights, back);
                sums.mean += part.mean;
                sums.deviation += part.deviation;
            }
        }
        if gradient.is_some() {
            let range = ready.start * len..ready.end * len;
            let rows = back.each_ref().map(|rows| Rows { values: &rows[range.clone()], len });
            narrow(simd, x, rows, scale, first + ready.start - 1, slopes, columns);
        }
        for rows in own.iter_mut().chain(wanted.iter_mut()).chain(back.iter_mut()) {
            rows.copy_within(some * len..(some + 1) * len, 0);
        }
    }
    if let Some(gradient) = gradient {
        spread(simd, map, axes, slopes, spare, columns, gradient);
    }
    sums
}

/// Rows `range` of both lists of a grid, interpolated to all columns.
fn widen<S: Simd>(
    simd: S,
    x: &Axis,
    grid: &PoolGrid,
    range: Range<usize>,
    out: &mut [&mut [f32]; 2],
    columns: &mut AxisColumns,
) {
    let len = lanes(x.taps.first.len());
    let n = range.len() * len;
    for (from, to) in grid.rows(range).into_iter().zip(out) {
        columns.widen(simd, x, from, Rows { values: &mut to[..n], len });
    }
}

/// Derivatives by full rows, carried to the slopes from row `first` on.
fn narrow<S: Simd>(
    simd: S,
    x: &Axis,
    back: [Rows<&[f32]>; 2],
    scale: f32,
    first: usize,
    slopes: &mut PoolGrid,
    columns: &mut AxisColumns,
) {
    let len = back[0].len;
    for at in (0..back[0].values.len() / len).step_by(LANES) {
        let end = (at + LANES).min(back[0].values.len() / len);
        let to = slopes.rows_mut(first + at..first + end);
        for (from, to) in back.into_iter().zip(to) {
            let from = Rows { values: &from.values[at * len..end * len], len };
            columns.narrow(simd, x, from, scale, to);
        }
    }
}

/// Derivatives by the coarse grids, carried to the map.
fn spread<S: Simd>(
    simd: S,
    map: &Plane,
    [x, y]: &[Axis; 2],
    slopes: &PoolGrid,
    full: &mut PoolPair,
    columns: &mut AxisColumns,
    gradient: &mut Plane,
) {
    let len = lanes(map.width);
    for (first, cells) in (0..).step_by(LANES).zip(y.cells.chunks(LANES)) {
        let mut share = [0.0; LANES];
        for (share, &(first, end)) in share.iter_mut().zip(cells) {
            *share = 1.0 / (end - first) as f32;
        }
        let from = slopes.rows(first..first + cells.len());
        for (from, to) in from.into_iter().zip(&mut *full) {
            let to = Rows { values: &mut to[..cells.len() * len], len };
            columns.spread(simd, x, from, &share, to);
        }
        for (k, &(first, end)) in cells.iter().enumerate() {
            let slopes = full.each_ref().map(|rows| &rows[k * len..(k + 1) * len]);
            for row in first as usize..end as usize {
                add_slopes(simd, map.row(row), slopes, gradient.row_mut(row));
            }
        }
    }
}

/// Adds the derivative by the mean, and by the square times twice the map.
#[simd]
fn add_slopes<S: Simd>(simd: S, map: &[f32], slopes: [&[f32]; 2], out: &mut [f32]) {
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

/// The rows between two coarse rows, which lie one after the other: sums of squared differences,
/// and their derivatives by both, added to `back`.
#[simd]
fn between<S: Simd>(
    simd: S,
    len: usize,
    own: [&[f32]; 2],
    expected: [&[f32]; 2],
    weights: &[f32],
    back: [&mut [f32]; 2],
) -> PoolSums {
    let floor = f32x16::splat(simd, FLOOR);
    let zero = f32x16::splat(simd, 0.0);
    let (mut mean_sum, mut deviation_sum) = (zero, zero);
    let [(mean_above, mean_below), (square_above, square_below)] =
        back.map(|rows| rows.split_at_mut(len));
    for i in (0..len).step_by(LANES) {
        let (at, below) = (i..i + LANES, len + i..len + i + LANES);
        let own_mean = f32x16::from_slice(simd, &own[0][at.clone()]);
        let own_square = f32x16::from_slice(simd, &own[1][at.clone()]);
        let mean = f32x16::from_slice(simd, &expected[0][at.clone()]);
        let square = f32x16::from_slice(simd, &expected[1][at]);
        let own_mean_step = f32x16::from_slice(simd, &own[0][below.clone()]) - own_mean;
        let own_square_step = f32x16::from_slice(simd, &own[1][below.clone()]) - own_square;
        let mean_step = f32x16::from_slice(simd, &expected[0][below.clone()]) - mean;
        let square_step = f32x16::from_slice(simd, &expected[1][below]) - square;
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
    PoolSums { mean: total(mean_sum.into()), deviation: total(deviation_sum.into()) }
}
