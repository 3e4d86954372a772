//! Pooling and resizing along one axis of a map.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use super::plane::LANES;
use powergs_frame::splat::simd::transpose;

/// Interpolation between two neighbours: full place i lies between `first[i]` and the one after,
/// the share `weight[i]` of the way.
#[derive(Debug, Clone)]
pub(crate) struct Taps {
    /// The lower neighbour; never falls.
    pub first: Vec<u32>,
    /// The share of the upper neighbour; 0 where there is none.
    pub weight: Vec<f32>,
    /// First full place whose lower neighbour is at least j, for j up to the coarse size.
    pub start: Vec<u32>,
}

impl Taps {
    /// Bilinear interpolation from `coarse` to `full` places; ends of places, not their middles,
    /// are aligned.
    pub(crate) fn new(coarse: usize, full: usize) -> Taps {
        let scale = coarse as f64 / full as f64;
        let mut taps = Taps { first: Vec::new(), weight: Vec::new(), start: Vec::new() };
        for i in 0..full {
            let at = ((i as f64 + 0.5) * scale - 0.5).max(0.0);
            let first = (at.floor() as usize).min(coarse - 1);
            let weight = if first + 1 < coarse { at - first as f64 } else { 0.0 };
            taps.first.push(first as u32);
            taps.weight.push(weight as f32);
        }
        taps.start = (0..=coarse)
            .map(|j| taps.first.partition_point(|&first| (first as usize) < j) as u32)
            .collect();
        taps
    }

    /// Coarse columns interpolated to all full places of rows; what lies beyond is zero.
    #[inline(always)]
    fn widen<S: Simd>(&self, simd: S, coarse: &[AxisColumn], full: Rows<&mut [f32]>) {
        let last = self.start.len() - 2;
        let places = self.first.chunks(LANES).zip(self.weight.chunks(LANES));
        for (at, (first, weight)) in (0..full.len).step_by(LANES).zip(places) {
            let mut block = [f32x16::splat(simd, 0.0); LANES];
            for (full, (&first, &weight)) in block.iter_mut().zip(first.iter().zip(weight)) {
                let first = first as usize;
                let value = f32x16::from_slice(simd, &coarse[first]);
                let step = f32x16::from_slice(simd, &coarse[(first + 1).min(last)]) - value;
                *full = value + step * weight;
            }
            put(block, full.values, full.len, at);
        }
    }

    /// The adjoint of [`Taps::widen`], times `scale`.
    #[inline(always)]
    fn narrow<S: Simd>(&self, simd: S, full: &[AxisColumn], scale: f32, coarse: &mut [AxisColumn]) {
        let zero = f32x16::splat(simd, 0.0);
        // What the places after the lower neighbour before give.
        let mut before = zero;
        for (out, range) in coarse.iter_mut().zip(self.start.windows(2)) {
            let (mut lower, mut upper) = (zero, zero);
            let range = range[0] as usize..range[1] as usize;
            for (column, weight) in full[range.clone()].iter().zip(&self.weight[range]) {
                let value = f32x16::from_slice(simd, column);
                let share = value * *weight;
                lower += value - share;
                upper += share;
            }
            ((lower + before) * scale).store_slice(out);
            before = upper;
        }
    }
}

/// Pooling of one axis: means over cells, and interpolation back.
#[derive(Debug, Clone)]
pub struct Axis {
    /// First place and end of every cell; neighbours may share places.
    pub cells: Vec<(u32, u32)>,
    /// The interpolation back to all places.
    pub taps: Taps,
    /// Whether pooling and interpolating back changes nothing.
    pub is_identity: bool,
}

impl Axis {
    /// Pooling over `pooling` places of `n`; below 1 there are more cells than places.
    pub(crate) fn pooled(n: usize, pooling: f64) -> Axis {
        // As published: a float product, rounded down. A picture smaller than the pooling of a
        // coarse level has one cell there.
        let count = ((n as f64 * (1.0 / pooling)).floor() as usize).max(1);
        let cells = (0..count)
            .map(|i| ((i * n / count) as u32, ((i + 1) * n).div_ceil(count) as u32))
            .collect();
        // With k cells per place all cells of a place are equal, and interpolation stays inside.
        Axis { cells, taps: Taps::new(count, n), is_identity: count.is_multiple_of(n) }
    }

    /// Sums over cells, times `scale`, a number for each lane.
    #[inline(always)]
    fn sums<S: Simd>(
        &self,
        simd: S,
        full: &[AxisColumn],
        scale: &AxisColumn,
        coarse: &mut [AxisColumn],
    ) {
        let scale = f32x16::from_slice(simd, scale);
        for (out, &(first, end)) in coarse.iter_mut().zip(&self.cells) {
            let mut sum = f32x16::splat(simd, 0.0);
            for column in &full[first as usize..end as usize] {
                sum += f32x16::from_slice(simd, column);
            }
            (sum * scale / (end - first) as f32).store_slice(out);
        }
    }

    /// The adjoint of [`Axis::sums`].
    #[inline(always)]
    fn spread<S: Simd>(
        &self,
        simd: S,
        coarse: &[AxisColumn],
        scale: &AxisColumn,
        full: &mut [AxisColumn],
    ) {
        let scale = f32x16::from_slice(simd, scale);
        full.fill([0.0; LANES]);
        for (column, &(first, end)) in coarse.iter().zip(&self.cells) {
            let share = f32x16::from_slice(simd, column) * scale / (end - first) as f32;
            for out in &mut full[first as usize..end as usize] {
                (f32x16::from_slice(simd, out) + share).store_slice(out);
            }
        }
    }
}

/// A place of sixteen rows.
type AxisColumn = [f32; LANES];

/// Sixteen rows at a time along their axis: they are turned into columns, so that a vector holds
/// the same place of all of them, and back.
#[derive(Debug, Default)]
pub(crate) struct AxisColumns {
    full: Vec<AxisColumn>,
    coarse: Vec<AxisColumn>,
}

impl AxisColumns {
    fn sized(&mut self, axis: &Axis, full: usize) {
        self.full.resize(full, [0.0; LANES]);
        self.sized_coarse(axis);
    }

    fn sized_coarse(&mut self, axis: &Axis) {
        self.coarse.resize(axis.cells.len().next_multiple_of(LANES), [0.0; LANES]);
    }

    /// Sums of up to sixteen full rows over cells, times `scale` of each row.
    #[simd]
    pub(crate) fn sums<S: Simd>(
        &mut self,
        simd: S,
        axis: &Axis,
        full: Rows<&[f32]>,
        scale: &[f32; LANES],
        coarse: Rows<&mut [f32]>,
    ) {
        self.sized(axis, full.len);
        turn(simd, full, &mut self.full);
        axis.sums(simd, &self.full, scale, &mut self.coarse);
        turn_back(simd, &self.coarse, coarse);
    }

    /// The adjoint of [`AxisColumns::sums`].
    #[simd]
    pub(crate) fn spread<S: Simd>(
        &mut self,
        simd: S,
        axis: &Axis,
        coarse: Rows<&[f32]>,
        scale: &[f32; LANES],
        full: Rows<&mut [f32]>,
    ) {
        self.sized(axis, full.len);
        turn(simd, coarse, &mut self.coarse);
        axis.spread(simd, &self.coarse, scale, &mut self.full);
        turn_back(simd, &self.full, full);
    }

    /// Up to sixteen coarse rows, interpolated to all full places.
    #[simd]
    pub(crate) fn widen<S: Simd>(
        &mut self,
        simd: S,
        axis: &Axis,
        coarse: Rows<&[f32]>,
        full: Rows<&mut [f32]>,
    ) {
        self.sized_coarse(axis);
        turn(simd, coarse, &mut self.coarse);
        axis.taps.widen(simd, &self.coarse, full);
    }

    /// The adjoint of [`AxisColumns::widen`], times `scale`.
    #[simd]
    pub(crate) fn narrow<S: Simd>(
        &mut self,
        simd: S,
        axis: &Axis,
        full: Rows<&[f32]>,
        scale: f32,
        coarse: Rows<&mut [f32]>,
    ) {
        self.sized(axis, full.len);
        turn(simd, full, &mut self.full);
        axis.taps.narrow(simd, &self.full, scale, &mut self.coarse);
        turn_back(simd, &self.coarse, coarse);
    }
}

/// Up to sixteen rows of `len` values each, one after the other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows<T> {
    /// Their values.
    pub values: T,
    /// Values of a row.
    pub len: usize,
}

#[inline(always)]
fn turn<S: Simd>(simd: S, rows: Rows<&[f32]>, columns: &mut [AxisColumn]) {
    let zero = f32x16::splat(simd, 0.0);
    for (at, columns) in (0..rows.len).step_by(LANES).zip(columns.chunks_exact_mut(LANES)) {
        let mut block = [zero; LANES];
        for (vector, row) in block.iter_mut().zip(rows.values.chunks_exact(rows.len)) {
            *vector = match row.get(at..at + LANES) {
                Some(values) => f32x16::from_slice(simd, values),
                None => {
                    let mut values = [0.0; LANES];
                    values[..row.len() - at].copy_from_slice(&row[at..]);
                    f32x16::simd_from(simd, values)
                }
            };
        }
        transpose(&mut block);
        for (column, vector) in columns.iter_mut().zip(&block) {
            vector.store_slice(column);
        }
    }
}

#[inline(always)]
fn turn_back<S: Simd>(simd: S, columns: &[AxisColumn], rows: Rows<&mut [f32]>) {
    for (at, columns) in (0..rows.len).step_by(LANES).zip(columns.chunks_exact(LANES)) {
        let mut block = [f32x16::splat(simd, 0.0); LANES];
        for (vector, column) in block.iter_mut().zip(columns) {
            *vector = f32x16::from_slice(simd, column);
        }
        put(block, rows.values, rows.len, at);
    }
}

/// Sixteen columns, from the place `at` of rows of `len` on.
#[inline(always)]
fn put<S: Simd>(mut block: [f32x16<S>; LANES], rows: &mut [f32], len: usize, at: usize) {
    transpose(&mut block);
    for (vector, row) in block.iter().zip(rows.chunks_exact_mut(len)) {
        match row.get_mut(at..at + LANES) {
            Some(values) => vector.store_slice(values),
            None => {
                let values: [f32; LANES] = (*vector).into();
                let left = row.len() - at;
                row[at..].copy_from_slice(&values[..left]);
            }
        }
    }
}
