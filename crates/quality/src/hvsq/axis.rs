//! Pooling and resizing along one axis of a map.

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

    /// Two coarse rows interpolated to all full places.
    pub(crate) fn widen(&self, coarse: [&[f32]; 2], full: &mut [Vec<f32>; 2]) {
        // Side by side, values and what comes next: one place to look for each full place.
        let next = |row: &[f32], j: usize| row.get(j + 1).map_or(0.0, |next| next - row[j]);
        let [a, b] = coarse;
        let both: Vec<[f32; 4]> =
            (0..a.len()).map(|j| [a[j], next(a, j), b[j], next(b, j)]).collect();
        let [a, b] = full;
        let places = self.first.iter().zip(&self.weight);
        for ((a, b), (&first, weight)) in a.iter_mut().zip(b).zip(places) {
            let [value, step, other, other_step] = both[first as usize];
            *a = value + weight * step;
            *b = other + weight * other_step;
        }
    }

    /// The adjoint of [`Taps::widen`], times `scale`.
    pub(crate) fn narrow(&self, full: &[f32], scale: f32, coarse: &mut [f32]) {
        // What the places after the lower neighbour before give.
        let mut before = 0.0;
        for (j, out) in coarse.iter_mut().enumerate() {
            let range = self.start[j] as usize..self.start[j + 1] as usize;
            let (mut lower, mut upper) = (0.0, 0.0);
            let (full, weights) = (&full[range.clone()], &self.weight[range]);
            for i in 0..weights.len() {
                let share = weights[i] * full[i];
                lower += full[i] - share;
                upper += share;
            }
            *out = (lower + before) * scale;
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

    /// Sums over cells, times `scale`.
    pub(crate) fn sums(&self, full: &[f32], scale: f32, out: &mut [f32]) {
        for (out, &(first, end)) in out.iter_mut().zip(&self.cells) {
            let mut sum = 0.0;
            for value in &full[first as usize..end as usize] {
                sum += value;
            }
            *out = sum * scale / (end - first) as f32;
        }
    }

    /// The adjoint of [`Axis::sums`].
    pub(crate) fn spread(&self, coarse: &[f32], scale: f32, full: &mut [f32]) {
        full.fill(0.0);
        for (value, &(first, end)) in coarse.iter().zip(&self.cells) {
            let share = value * scale / (end - first) as f32;
            for v in &mut full[first as usize..end as usize] {
                *v += share;
            }
        }
    }
}
