//! A codebook of 256 numbers for many.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use rayon::prelude::*;

/// Numbers in a codebook.
pub(super) const ENTRIES: usize = 256;
/// Rounds of moving numbers between cells and cells to their means, at most.
const ROUNDS: usize = 40;

/// 256 numbers in ascending order.
pub(super) struct Codebook([f32; ENTRIES]);

impl Codebook {
    /// A codebook of `values`, of which there is one at least and none is NaN: all of them where no
    /// more than 256 are different, otherwise numbers with a small squared error.
    ///
    /// The range is cut at the mean of the cell with the largest squared error until there are 256
    /// cells; then values move to the nearest mean, and means follow, until nothing changes.
    pub(crate) fn of(mut values: Vec<f32>) -> Codebook {
        values.par_sort_unstable_by(f32::total_cmp);
        let mut different: Vec<f32> = Vec::with_capacity(ENTRIES);
        for value in &values {
            if different.last().is_none_or(|last| last.to_bits() != value.to_bits()) {
                different.push(*value);
            }
            if different.len() > ENTRIES {
                different = means(&values);
                break;
            }
        }
        let last = different[different.len() - 1];
        different.resize(ENTRIES, last);
        Codebook(different.try_into().expect("filled up to its length"))
    }

    /// The place of the number nearest to `value`.
    pub(crate) fn code(&self, value: f32) -> u8 {
        let above = self.0.partition_point(|entry| entry.total_cmp(&value).is_lt());
        let apart = |i: usize| (f64::from(self.0[i]) - f64::from(value)).abs();
        let code = match above {
            0 => 0,
            ENTRIES => ENTRIES - 1,
            above if apart(above - 1) < apart(above) => above - 1,
            // Also where it is the number itself.
            above => above,
        };
        code as u8
    }

    /// The numbers as JSON, which holds them exactly.
    pub(crate) fn json(&self) -> Vec<f64> {
        self.0.map(f64::from).to_vec()
    }
}

/// A run of sorted values.
struct CodebookCell {
    start: usize,
    end: usize,
    mean: f64,
    /// Sum of the squared differences to the mean.
    error: f64,
}

impl CodebookCell {
    fn of(sorted: &[f32], start: usize, end: usize) -> CodebookCell {
        let values = &sorted[start..end];
        // Differences to one of the values, so that large ones elsewhere cost no digits.
        let base = f64::from(values[0]);
        let sum: f64 = values.iter().map(|v| f64::from(*v) - base).sum();
        let mean = base + sum / values.len() as f64;
        let error = values.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum();
        CodebookCell { start, end, mean, error }
    }
}

impl PartialEq for CodebookCell {
    fn eq(&self, other: &CodebookCell) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for CodebookCell {}

impl PartialOrd for CodebookCell {
    fn partial_cmp(&self, other: &CodebookCell) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The largest error first; of equal ones the cell farther left.
impl Ord for CodebookCell {
    fn cmp(&self, other: &CodebookCell) -> Ordering {
        self.error.total_cmp(&other.error).then(other.start.cmp(&self.start))
    }
}

/// At most 256 numbers for more than that.
fn means(sorted: &[f32]) -> Vec<f32> {
    let mut means: Vec<f64> = split(sorted).iter().map(|cell| cell.mean).collect();
    let mut cuts = Vec::new();
    for _ in 0..ROUNDS {
        let next = cuts_between(sorted, &means);
        if next == cuts {
            break;
        }
        cuts = next;
        means.par_iter_mut().enumerate().for_each(|(i, mean)| {
            let (start, end) = (cuts[i], cuts[i + 1]);
            if start < end {
                *mean = CodebookCell::of(sorted, start, end).mean;
            }
        });
    }
    means.into_iter().map(|mean| mean as f32).collect()
}

/// Cells in ascending order.
fn split(sorted: &[f32]) -> Vec<CodebookCell> {
    let mut heap = BinaryHeap::from([CodebookCell::of(sorted, 0, sorted.len())]);
    let mut whole = Vec::new();
    while heap.len() + whole.len() < ENTRIES {
        let Some(cell) = heap.pop() else { break };
        let (start, end) = (cell.start, cell.end);
        let cut = start + sorted[start..end].partition_point(|v| f64::from(*v) <= cell.mean);
        if cut == start || cut == end {
            whole.push(cell);
            continue;
        }
        heap.push(CodebookCell::of(sorted, start, cut));
        heap.push(CodebookCell::of(sorted, cut, end));
    }
    whole.extend(heap);
    whole.sort_unstable_by_key(|cell| cell.start);
    whole
}

/// Where the values of each mean begin, and the end of the last.
fn cuts_between(sorted: &[f32], means: &[f64]) -> Vec<usize> {
    let middle = |pair: &[f64]| 0.5 * (pair[0] + pair[1]);
    let inner = means.windows(2).map(middle);
    let inner = inner.map(|cut| sorted.partition_point(|v| f64::from(*v) <= cut));
    [0].into_iter().chain(inner).chain([sorted.len()]).collect()
}
