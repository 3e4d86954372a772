//! Few vectors for many: k-means in parts that are made by cutting.
//!
//! Comparing each vector with each of 65,536 means takes too long: 2e13 multiplications a round for
//! six million Gaussians of degree 3. So the vectors are divided into blocks of about a thousand
//! that lie together, each cut at the median of the coordinate that varies most. Each block has its
//! share of the means, finds a start by splitting the group with the largest squared error, and
//! then alternates between nearest mean and mean of the nearest. Blocks are worked on side by side,
//! and none depends on another, so that the result is the same for any number of threads.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use rayon::prelude::*;

/// Vectors in a block, at most, where that gives it a few means.
const BLOCK: usize = 1024;
/// Means of a block, at least.
const MEANS: usize = 32;
/// Rounds of nearest mean and mean of the nearest, at most.
const ROUNDS: usize = 6;
/// Coordinates that are added at a time, so that the compiler can use wide registers.
const LANES: usize = 8;

/// Vectors one after the other.
pub(super) struct Vectors<'a> {
    pub values: &'a [f32],
    pub dimensions: usize,
}

impl<'a> Vectors<'a> {
    /// All vectors in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &'a [f32]> {
        self.values.chunks_exact(self.dimensions)
    }

    fn len(&self) -> usize {
        self.values.len() / self.dimensions
    }

    fn at(&self, i: u32) -> &'a [f32] {
        &self.values[i as usize * self.dimensions..][..self.dimensions]
    }

    /// The mean of a coordinate over some vectors, and the sum of squared differences to it.
    fn spread(&self, of: &[u32], axis: usize) -> (f64, f64) {
        let value = |i: &u32| f64::from(self.at(*i)[axis]);
        let base = value(&of[0]);
        let mean = base + of.iter().map(|i| value(i) - base).sum::<f64>() / of.len() as f64;
        (mean, of.iter().map(|i| (value(i) - mean).powi(2)).sum())
    }
}

/// At most `count` vectors (of `1..=65536`, and no more than there are) that stand for all, and for
/// each vector the index of the one that stands for it.
pub(super) fn cluster(vectors: &Vectors<'_>, count: usize) -> (Vec<f32>, Vec<u16>) {
    let n = vectors.len();
    let most = BLOCK.max(2 * MEANS * n / count);
    let mut order: Vec<u32> = (0..n as u32).collect();
    let blocks = divide(vectors, &mut order, most);
    // Block by block, the share of all means up to its end.
    let share = |end: usize| (end as u128 * count as u128 / n as u128) as usize;
    let mut start = 0;
    let blocks: Vec<(&[u32], usize)> = blocks
        .into_iter()
        .map(|block| {
            let end = start + block.len();
            let means = share(end) - share(start);
            start = end;
            (block, means)
        })
        .collect();
    let found: Vec<(Vec<f32>, Vec<u32>)> =
        blocks.par_iter().map(|(block, means)| means_of(vectors, block, *means)).collect();
    let mut values = Vec::new();
    let mut labels = vec![0; n];
    for ((block, _), (means, own)) in blocks.iter().zip(found) {
        let first = values.len() / vectors.dimensions;
        for (i, label) in block.iter().zip(own) {
            labels[*i as usize] = (first + label as usize) as u16;
        }
        values.extend(means);
    }
    (values, labels)
}

/// Blocks of at most `most` vectors. Which vectors a block has does not depend on how they are
/// sorted; in it they are in ascending order.
fn divide<'o>(vectors: &Vectors<'_>, order: &'o mut [u32], most: usize) -> Vec<&'o [u32]> {
    if order.len() <= most {
        order.sort_unstable();
        return vec![order];
    }
    let spread = |axis: usize| vectors.spread(order, axis).1;
    let spreads: Vec<f64> = (0..vectors.dimensions).into_par_iter().map(spread).collect();
    let axis = largest(&spreads);
    let middle = order.len() / 2;
    order.select_nth_unstable_by(middle, |a, b| {
        vectors.at(*a)[axis].total_cmp(&vectors.at(*b)[axis]).then(a.cmp(b))
    });
    let (left, right) = order.split_at_mut(middle);
    let (mut left, right) =
        rayon::join(|| divide(vectors, left, most), || divide(vectors, right, most));
    left.extend(right);
    left
}

/// The index of the largest number, the first of several.
fn largest(numbers: &[f64]) -> usize {
    let better = |best: usize, i: usize| if numbers[i] > numbers[best] { i } else { best };
    (1..numbers.len()).fold(0, better)
}

/// The means of a block, at most `count`, and for each of its vectors the index of its mean.
fn means_of(vectors: &Vectors<'_>, block: &[u32], count: usize) -> (Vec<f32>, Vec<u32>) {
    let mut labels = split(vectors, block, count);
    let groups = labels.iter().max().map_or(0, |last| *last as usize + 1);
    let mut means = vec![0.0; groups * vectors.dimensions];
    move_means(vectors, block, &labels, &mut means);
    let points = Padded::of(block.iter().flat_map(|i| vectors.at(*i)), vectors.dimensions);
    for _ in 0..ROUNDS {
        let nearest = points.nearest(&Padded::of(&means, vectors.dimensions));
        if nearest == labels {
            break;
        }
        labels = nearest;
        move_means(vectors, block, &labels, &mut means);
    }
    (means, labels)
}

/// Moves each mean to the mean of its vectors; one without vectors stays.
fn move_means(vectors: &Vectors<'_>, block: &[u32], labels: &[u32], means: &mut [f32]) {
    let d = vectors.dimensions;
    let mut sums = vec![0.0_f64; means.len()];
    let mut counts = vec![0_u32; means.len() / d];
    for (i, label) in block.iter().zip(labels) {
        let label = *label as usize;
        counts[label] += 1;
        let sum = &mut sums[label * d..(label + 1) * d];
        sum.iter_mut().zip(vectors.at(*i)).for_each(|(s, v)| *s += f64::from(*v));
    }
    for (label, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
        let range = label * d..(label + 1) * d;
        let sums = sums[range.clone()].iter().map(|sum| (sum / f64::from(*count)) as f32);
        means[range].iter_mut().zip(sums).for_each(|(mean, new)| *mean = new);
    }
}

/// A group of vectors, before it is split.
struct VectorGroup {
    members: Vec<u32>,
    /// Sum of the squared differences to the mean, over all coordinates.
    error: f64,
    /// The coordinate that varies most, and its mean.
    axis: usize,
    mean: f64,
}

impl VectorGroup {
    /// `members` are places in the block, ascending.
    fn of(vectors: &Vectors<'_>, block: &[u32], members: Vec<u32>) -> VectorGroup {
        let inside: Vec<u32> = members.iter().map(|at| block[*at as usize]).collect();
        let all: Vec<_> = (0..vectors.dimensions).map(|a| vectors.spread(&inside, a)).collect();
        let spreads: Vec<f64> = all.iter().map(|(_, spread)| *spread).collect();
        let axis = largest(&spreads);
        VectorGroup { members, error: spreads.iter().sum(), axis, mean: all[axis].0 }
    }

    fn key(&self) -> (f64, Reverse<u32>) {
        (self.error, Reverse(self.members[0]))
    }
}

impl PartialEq for VectorGroup {
    fn eq(&self, other: &VectorGroup) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for VectorGroup {}

impl PartialOrd for VectorGroup {
    fn partial_cmp(&self, other: &VectorGroup) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The largest error first; of equal ones that with the earliest vector.
impl Ord for VectorGroup {
    fn cmp(&self, other: &VectorGroup) -> Ordering {
        let (a, b) = (self.key(), other.key());
        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
    }
}

/// Divides a block into at most `count` groups: for each vector the index of its group.
fn split(vectors: &Vectors<'_>, block: &[u32], count: usize) -> Vec<u32> {
    let all = (0..block.len() as u32).collect();
    let mut heap = BinaryHeap::from([VectorGroup::of(vectors, block, all)]);
    let mut whole = Vec::new();
    while heap.len() + whole.len() < count {
        let Some(group) = heap.pop() else { break };
        let below = |at: &u32| f64::from(vectors.at(block[*at as usize])[group.axis]) <= group.mean;
        let (left, right): (Vec<u32>, Vec<u32>) = group.members.iter().partition(|at| below(at));
        if left.is_empty() || right.is_empty() {
            whole.push(group);
            continue;
        }
        heap.push(VectorGroup::of(vectors, block, left));
        heap.push(VectorGroup::of(vectors, block, right));
    }
    whole.extend(heap);
    whole.sort_unstable_by_key(|group| group.members[0]);
    let mut labels = vec![0; block.len()];
    for (label, group) in whole.iter().enumerate() {
        group.members.iter().for_each(|at| labels[*at as usize] = label as u32);
    }
    labels
}

/// Vectors with zeros behind them, so that their lengths are multiples of [`LANES`].
struct Padded {
    values: Vec<[f32; LANES]>,
    /// Groups of lanes a vector.
    lanes: usize,
}

impl Padded {
    fn of<'a>(values: impl IntoIterator<Item = &'a f32>, dimensions: usize) -> Padded {
        let lanes = dimensions.div_ceil(LANES);
        let mut all = values.into_iter().copied();
        let mut padded = Vec::new();
        while let Some(first) = all.next() {
            let start = padded.len();
            padded.resize(start + lanes, [0.0; LANES]);
            let slots = padded[start..].as_flattened_mut()[..dimensions].iter_mut();
            slots.zip([first].into_iter().chain(&mut all)).for_each(|(slot, v)| *slot = v);
        }
        Padded { values: padded, lanes }
    }

    /// For each vector the nearest of `means`, the first of several: that with the largest
    /// `x·m − m·m / 2`.
    fn nearest(&self, means: &Padded) -> Vec<u32> {
        let halves: Vec<f32> =
            means.values.chunks_exact(means.lanes).map(|m| 0.5 * product(m, m)).collect();
        let nearest = |x: &[[f32; LANES]]| {
            let mut best = (f32::NEG_INFINITY, 0);
            for (i, m) in means.values.chunks_exact(means.lanes).enumerate() {
                let score = product(x, m) - halves[i];
                if score > best.0 {
                    best = (score, i as u32);
                }
            }
            best.1
        };
        self.values.chunks_exact(self.lanes).map(nearest).collect()
    }
}

/// The scalar product, added lane by lane.
fn product(a: &[[f32; LANES]], b: &[[f32; LANES]]) -> f32 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum()
}
