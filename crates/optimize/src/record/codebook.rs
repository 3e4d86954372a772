//! A codebook: the coefficients beyond the constant one of all Gaussians as so many entries, each
//! the mean of those that share it.
//!
//! Which Gaussians share an entry is a list of labels, and the entries follow from labels and
//! parameters. In training a Gaussian keeps coefficients of its own; the picture is that of the
//! entries, whose gradients go to all who share them as they are (straight through), so that an
//! entry follows the mean of their steps. From time to time everyone looks for the nearest entry
//! again, and entries that nobody has take those that are farthest from theirs.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use powergs_scene::Gaussians;

/// Coefficients beyond the constant one, at degree 3, of three channels, with room to align.
const WIDTH: usize = 48;
/// Sums that a distance is made in side by side.
const LANES: usize = 16;
/// Rounds of looking for the nearest entry from nothing.
const ROUNDS: u32 = 6;
/// Seed of the Gaussians that entries begin with.
const SEED: u64 = 0x5eed_c0de;

/// A colour beyond the constant one, or an entry; zeros behind.
type Vector = [f32; WIDTH];

/// Labels from nothing: which of at most `entries` entries each Gaussian shares. None for a model
/// of degree 0, whose colours are constant.
pub fn labels(scene: &Gaussians, entries: u32) -> Vec<u32> {
    let vectors = vectors(scene);
    let entries = (entries as usize).min(vectors.len());
    if entries == 0 {
        return Vec::new();
    }
    let mut rng = Pcg64Mcg::seed_from_u64(SEED);
    let mut order: Vec<usize> = (0..vectors.len()).collect();
    // A shuffle only as far as entries are taken from it.
    for first in 0..entries {
        let other = rng.random_range(first as u64..vectors.len() as u64) as usize;
        order.swap(first, other);
    }
    let mut book: Vec<Vector> = order[..entries].iter().map(|&i| vectors[i]).collect();
    let mut labels = nearest(&vectors, &mut book);
    for _ in 1..ROUNDS {
        book = means(&vectors, &labels, entries);
        labels = nearest(&vectors, &mut book);
    }
    labels
}

/// Everyone looks for the nearest of the entries again. A model that was pruned below so many has
/// as many as it has Gaussians, each its own.
pub fn relabel(scene: &Gaussians, labels: &mut Vec<u32>, entries: u32) {
    let vectors = vectors(scene);
    if vectors.len() <= entries as usize {
        *labels = (0..vectors.len() as u32).collect();
        return;
    }
    let mut book = means(&vectors, labels, entries as usize);
    *labels = nearest(&vectors, &mut book);
}

/// Gives every Gaussian the entry that it shares in the place of its own coefficients.
pub fn share(scene: &mut Gaussians, labels: &[u32]) {
    let each = scene.sh_coefficients();
    let Some(entries) = labels.iter().max().map(|most| *most as usize + 1) else { return };
    let book = means(&vectors(scene), labels, entries);
    let rest = each - 1;
    scene.sh.par_chunks_mut(3 * each).zip(labels).for_each(|(sh, &label)| {
        let entry = &book[label as usize];
        for (channel, values) in sh.chunks_exact_mut(each).zip(entry.chunks(rest)) {
            channel[1..].copy_from_slice(values);
        }
    });
}

fn vectors(scene: &Gaussians) -> Vec<Vector> {
    let each = scene.sh_coefficients();
    // A coefficient beyond degree 3 is not part of a record.
    if !(2..=WIDTH / 3).contains(&each) {
        return Vec::new();
    }
    let vector = |sh: &[f32]| {
        let mut vector = [0.0; WIDTH];
        let others = sh.chunks_exact(each).flat_map(|channel| &channel[1..]);
        vector.iter_mut().zip(others).for_each(|(to, from)| *to = *from);
        vector
    };
    scene.sh.par_chunks(3 * each).map(vector).collect()
}

/// The means of those that share an entry; zeros where nobody does.
fn means(vectors: &[Vector], labels: &[u32], entries: usize) -> Vec<Vector> {
    let mut sums = vec![[0.0_f64; WIDTH]; entries];
    let mut counts = vec![0_u32; entries];
    // By one thread, so that sums do not depend on how many there are.
    for (vector, &label) in vectors.iter().zip(labels) {
        counts[label as usize] += 1;
        let sum = &mut sums[label as usize];
        sum.iter_mut().zip(vector).for_each(|(sum, value)| *sum += f64::from(*value));
    }
    let mean = |(sum, &n): (&[f64; WIDTH], &u32)| sum.map(|sum| (sum / f64::from(n.max(1))) as f32);
    sums.iter().zip(&counts).map(mean).collect()
}

/// The nearest entry of each, the first of several. An entry that nobody has becomes one of those
/// that are farthest from theirs.
fn nearest(vectors: &[Vector], book: &mut [Vector]) -> Vec<u32> {
    let find = |vector: &Vector| {
        let all = book.iter().map(|entry| distance(vector, entry));
        let less = |a: (u32, f32), b: (u32, f32)| if b.1 < a.1 { b } else { a };
        (0..).zip(all).reduce(less).expect("a book has entries")
    };
    let mut found: Vec<(u32, f32)> = vectors.par_iter().map(find).collect();
    let mut counts = vec![0_u32; book.len()];
    found.iter().for_each(|(label, _)| counts[*label as usize] += 1);
    let empty: Vec<usize> = (0..book.len()).filter(|&entry| counts[entry] == 0).collect();
    if !empty.is_empty() {
        let mut far: Vec<usize> = (0..found.len()).collect();
        far.sort_unstable_by(|&a, &b| found[b].1.total_cmp(&found[a].1).then(a.cmp(&b)));
        // Who already has an entry of exactly its value gains nothing by another.
        let apart = far.into_iter().filter(|&i| found[i].1 > 0.0).take(empty.len());
        let moved: Vec<usize> = apart.collect();
        for (entry, i) in empty.into_iter().zip(moved) {
            book[entry] = vectors[i];
            found[i] = (entry as u32, 0.0);
        }
    }
    found.into_iter().map(|(label, _)| label).collect()
}

/// The square of a distance, in sums of a fixed order.
fn distance(a: &Vector, b: &Vector) -> f32 {
    let mut sums = [0.0_f32; LANES];
    for (a, b) in a.chunks_exact(LANES).zip(b.chunks_exact(LANES)) {
        for lane in 0..LANES {
            let d = a[lane] - b[lane];
            sums[lane] += d * d;
        }
    }
    let [half, quarter] = [8, 4];
    (0..half).for_each(|i| sums[i] += sums[i + half]);
    (0..quarter).for_each(|i| sums[i] += sums[i + quarter]);
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}
