//! HVSQ of the regions of a picture around a gaze, each at its own pooling.
//!
//! The squared differences of a map at a pooling are averaged over the samples of the region that
//! the pooling belongs to. A sample of a coarse level belongs to the region of the pixel in its
//! middle. Maps without samples in a region are left out of its mean: small regions have none in
//! the coarsest levels.

use rayon::prelude::*;

use super::axis::Axis;
use super::plane::{Plane, lanes};
use super::pool::{PoolGrid, PoolScratch, pooled};
use super::reference::MapReference;
use super::{Hvsq, LEVELS, MAPS, Reference, STATISTICS};
use powergs_base::picture::Picture;

/// Sums over the samples of a region: differences of means, of deviations.
type RegionalSums = [f64; 2];

impl Hvsq {
    /// The measure of every region: `regions` has the position of a pooling for every pixel.
    /// `None` for poolings without pixels. For reports: not as fast as [`Hvsq::values`].
    ///
    /// # Panics
    /// As [`Hvsq::values`]; if `regions` has another size than the picture.
    pub fn regional(
        &mut self,
        picture: &Picture,
        reference: &Reference,
        regions: &[u8],
    ) -> Vec<Option<f64>> {
        assert_eq!(regions.len(), self.width * self.height, "one region per pixel");
        assert_eq!(reference.poolings(), self.axes.len(), "a reference at the same poolings");
        self.analyse(picture);
        let masks: Vec<Vec<u8>> = (0..=LEVELS).map(|k| self.mask(regions, k)).collect();
        (0..self.axes.len()).map(|p| self.region(reference, &masks, p)).collect()
    }

    /// The regions of the samples of a level.
    fn mask(&self, regions: &[u8], level: usize) -> Vec<u8> {
        let [full_width, full_height] = self.pyramid.full;
        let (columns, rows) = (full_width >> level, full_height >> level);
        let at = |i: usize, n: usize, samples: usize| ((2 * i + 1) * n / (2 * samples)).min(n - 1);
        let of = |x: usize, y: usize| {
            regions[at(y, self.height, rows) * self.width + at(x, self.width, columns)]
        };
        (0..rows * columns).map(|i| of(i % columns, i / columns)).collect()
    }

    fn region(&self, reference: &Reference, masks: &[Vec<u8>], p: usize) -> Option<f64> {
        let counts: Vec<usize> =
            masks.iter().map(|m| m.iter().filter(|&&r| usize::from(r) == p).count()).collect();
        if counts[0] == 0 {
            return None;
        }
        let sums: Vec<RegionalSums> = (0..3 * MAPS)
            .into_par_iter()
            .map_init(PoolScratch::default, |scratch, i| {
                let (level, map) = self.pyramid.map(i);
                let inside = |x: usize, y: usize| usize::from(masks[level][y * map.width + x]) == p;
                let axes = &self.axes[p][level];
                match reference.map(i).pooled(p) {
                    None => unpooled(map, reference.map(i), inside),
                    Some(grid) => differences(map, grid, axes, scratch, inside),
                }
            })
            .collect();
        let mut means = Vec::with_capacity(STATISTICS);
        for k in 0..MAPS {
            let n = 3.0 * counts[self.pyramid.map(k).0] as f64;
            let all = (0..3).map(|channel| sums[channel * MAPS + k]);
            let [mean, deviation] = all.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
            if n > 0.0 {
                means.extend([mean / n, deviation / n]);
            }
        }
        if counts[LEVELS] > 0 {
            let low = |channel: usize| {
                let (own, expected) = (self.pyramid.lowest(channel), reference.lowest(channel));
                let inside =
                    |x: usize, y: usize| usize::from(masks[LEVELS][y * own.width + x]) == p;
                squares(own, expected, inside)
            };
            means.push((0..3).map(low).sum::<f64>() / (3.0 * counts[LEVELS] as f64));
        }
        Some(means.iter().sum::<f64>() / means.len() as f64)
    }
}

/// The sum of squared differences of two maps inside.
fn squares(own: &Plane, expected: &Plane, inside: impl Fn(usize, usize) -> bool) -> f64 {
    let mut sum = 0.0;
    for y in 0..own.height {
        let pairs = own.row(y).iter().zip(expected.row(y)).take(own.width).enumerate();
        for (_, (a, b)) in pairs.filter(|(x, _)| inside(*x, y)) {
            sum += f64::from(a - b).powi(2);
        }
    }
    sum
}

fn unpooled(
    map: &Plane,
    expected: &MapReference,
    inside: impl Fn(usize, usize) -> bool,
) -> RegionalSums {
    [squares(map, expected.map(), inside), 0.0]
}

/// Sums of squared differences of means and deviations inside.
fn differences(
    map: &Plane,
    expected: &PoolGrid,
    axes: &[Axis; 2],
    scratch: &mut PoolScratch,
    inside: impl Fn(usize, usize) -> bool,
) -> RegionalSums {
    let own = pooled(map, axes, scratch);
    let [x_axis, y_axis] = axes;
    let rows = || [vec![0.0f32; lanes(map.width)], vec![0.0f32; lanes(map.width)]];
    let (mut above, mut below) = ([rows(), rows()], [rows(), rows()]);
    let mut sums = [0.0; 2];
    let last = y_axis.cells.len() - 1;
    for y in 0..map.height {
        let first = y_axis.taps.first[y] as usize;
        let weight = y_axis.taps.weight[y];
        for (grid, k) in [(&own, 0), (expected, 1)] {
            scratch.widen(x_axis, grid, first, &mut above[k]);
            scratch.widen(x_axis, grid, (first + 1).min(last), &mut below[k]);
        }
        for x in (0..map.width).filter(|&x| inside(x, y)) {
            let between = |k: usize, what: usize| {
                let (a, b) = (above[k][what][x], below[k][what][x]);
                f64::from(a + weight * (b - a))
            };
            let deviation = |k: usize| (between(k, 1) - between(k, 0).powi(2)).max(1e-7).sqrt();
            sums[0] += (between(0, 0) - between(1, 0)).powi(2);
            sums[1] += (deviation(0) - deviation(1)).powi(2);
        }
    }
    sums
}
