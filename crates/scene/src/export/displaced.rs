//! Gaussians that a coarse grid of positions moves so far that pictures show it, and those that
//! made it coarse.

use std::fmt;

use powergs_base::format::counted;
use serde::Serialize;

use super::super::Gaussians;

/// The share of the size of a Gaussian, its longest standard deviation, by which it may be moved:
/// its edge changes by 6 % of its opacity then, and pictures are some 30 dB from what they were.
const VISIBLE: f64 = 0.1;
/// The share of all Gaussians that may be moved by more.
const FEW: f64 = 0.25;
/// How many times as far from the middle as 95 % of all Gaussians those are that lie apart.
const APART: f64 = 30.0;

/// A model many of whose Gaussians a file moves by more than a tenth of their size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Displaced {
    /// How many it moves by more.
    pub count: u64,
    /// How many there are.
    pub of: u64,
    /// By how much half of those are moved at least, world units.
    pub median: f64,
    /// Those far from all others, if there are any: formats divide the whole range into steps.
    pub apart: Option<Apart>,
}

/// Gaussians far from all others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Apart {
    /// How many.
    pub count: u64,
    /// Index of the farthest.
    pub farthest: u64,
    /// How far it is from the middle, along an axis, world units.
    pub distance: f64,
    /// How far 95 % of all are at most, world units.
    pub others: f64,
}

impl Displaced {
    /// Compares `scene` with `held`, which has as many Gaussians; `None` where few are
    /// moved.
    pub(super) fn of(scene: &Gaussians, held: &Gaussians) -> Option<Displaced> {
        let mut errors: Vec<f64> = Vec::new();
        for ((was, is), scale) in scene.means.iter().zip(&held.means).zip(&scene.log_scales) {
            let squares = was.iter().zip(is).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
            let error = squares.sum::<f64>().sqrt();
            let longest = scale.iter().fold(f32::MIN, |most, s| most.max(*s));
            if error > VISIBLE * f64::from(longest).exp() {
                errors.push(error);
            }
        }
        let (count, of) = (errors.len(), scene.len());
        if count as f64 <= FEW * of as f64 {
            return None;
        }
        let (_, median, _) = errors.select_nth_unstable_by(count / 2, f64::total_cmp);
        let (count, of) = (count as u64, of as u64);
        Some(Displaced { count, of, median: *median, apart: Apart::of(scene) })
    }
}

impl Apart {
    fn of(scene: &Gaussians) -> Option<Apart> {
        let n = scene.len();
        let middle: [f64; 3] = std::array::from_fn(|axis| {
            let mut values: Vec<f32> = scene.means.iter().map(|mean| mean[axis]).collect();
            let (_, median, _) = values.select_nth_unstable_by(n / 2, f32::total_cmp);
            f64::from(*median)
        });
        let far = |mean: &[f32; 3]| {
            let along = mean.iter().zip(middle).map(|(v, middle)| (f64::from(*v) - middle).abs());
            along.fold(0.0, f64::max)
        };
        let distances: Vec<f64> = scene.means.iter().map(far).collect();
        let mut sorted = distances.clone();
        let (_, others, _) = sorted.select_nth_unstable_by(19 * (n - 1) / 20, f64::total_cmp);
        let others = *others;
        let count = distances.iter().filter(|d| **d > APART * others).count() as u64;
        let last = distances.iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
        let (farthest, distance) = last.filter(|_| count > 0)?;
        Some(Apart { count, farthest: farthest as u64, distance: *distance, others })
    }
}

impl fmt::Display for Displaced {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Displaced { count, of, median, apart } = self;
        write!(
            f,
            "the format is too coarse for the positions: {count} of {of} Gaussians are moved by \
             more than a tenth of their size, half of them by {median:.1e} world units and more; "
        )?;
        match apart {
            Some(Apart { count, farthest, distance, others }) => {
                let far = counted(count, "Gaussian");
                let verb = if *count == 1 { "lies" } else { "lie" };
                write!(
                    f,
                    "{far} {verb} far from all others (#{farthest}: {distance:.1e} from the \
                     middle, 95 % are within {others:.1e}), which costs the others their places: \
                     take them out, or write .glb or .ply"
                )
            }
            None => write!(
                f,
                "sort them along a curve first (--order morton), which helps where steps are of \
                 parts of the model, or write .glb or .ply"
            ),
        }
    }
}
