//! HVSQ: how different two pictures look in peripheral vision, with its gradient.
//!
//! A steerable pyramid decomposes the pictures. The mean and the standard deviation of every band
//! over patches of a pooling size are compared, and the mean of the 51 squared differences is the
//! measure. 0 is equal; published targets are about 2e-5. Source: `powergs`; `docs/metrics.md` has
//! the definition.
//!
//! Pooling is linear and separable. Statistics are kept on the coarse grid of the pooling; the
//! steps per pixel (the deviation and its gradient) are computed in registers between two rows of
//! that grid. Sums are taken in a fixed order: results do not depend on the number of threads.

mod axis;
mod bands;
mod gradient;
mod measures;
mod plane;
mod pool;
mod pyramid;
mod reference;
mod regional;

use rayon::prelude::*;

use axis::Axis;
use gradient::HvsqGradients;
use pool::{PoolScratch, PoolSums};
use powergs_base::picture::Picture;
use pyramid::Pyramid;

pub use measures::Measures;
pub use reference::Reference;

/// Pyramid levels with bands.
const LEVELS: usize = 4;
/// Bands of a level.
const BANDS: usize = 6;
/// Maps of a channel that are pooled: the highest frequencies, and the bands of all levels.
const MAPS: usize = 1 + LEVELS * BANDS;
/// Compared maps: mean and deviation of each pooled one, and the lowest frequencies.
pub(crate) const STATISTICS: usize = 2 * MAPS + 1;
/// Sides of pictures are brought up to multiples of this.
const MULTIPLE: u32 = 32;
/// Largest side, pixels.
const SIDE_MAX: u32 = 1 << 15;

/// A pooling or a picture that HVSQ is not defined for.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum HvsqError {
    /// The pooling is below a pixel, not a number, or larger than the picture.
    #[error(
        "pooling {pooling}: a pooling is from 1 pixel to the shorter side of the picture \
         ({width} x {height}, brought up to multiples of 32)"
    )]
    Pooling {
        /// The pooling, pixels.
        pooling: f64,
        /// Width of the picture, brought up.
        width: u32,
        /// Height of the picture, brought up.
        height: u32,
    },
    /// No pixels, or too many.
    #[error("a picture of {width} x {height}: HVSQ needs sides from 1 to 32768 pixels")]
    Size {
        /// Width of the picture.
        width: u32,
        /// Height of the picture.
        height: u32,
    },
}

/// HVSQ for pictures of one size at some poolings; keeps its work space between evaluations.
#[derive(Debug)]
pub struct Hvsq {
    width: usize,
    height: usize,
    /// Per pooling, level by level: how its columns and rows are pooled.
    axes: Vec<[[Axis; 2]; LEVELS]>,
    pyramid: Pyramid,
    /// Made with the first gradient.
    gradients: Option<HvsqGradients>,
}

impl Hvsq {
    /// HVSQ for pictures of `width` x `height` pixels at these poolings, pixels.
    ///
    /// # Errors
    /// A picture without pixels or with sides above 32768; a pooling below 1 or larger than the
    /// picture.
    pub fn new(width: u32, height: u32, poolings: &[f64]) -> Result<Hvsq, HvsqError> {
        if !(1..=SIDE_MAX).contains(&width) || !(1..=SIDE_MAX).contains(&height) {
            return Err(HvsqError::Size { width, height });
        }
        let full = [width, height].map(|n| n.next_multiple_of(MULTIPLE));
        let bad = |pooling| HvsqError::Pooling { pooling, width: full[0], height: full[1] };
        let axes = poolings
            .iter()
            .map(|&p| {
                let fits = p >= 1.0 && p <= f64::from(full[0].min(full[1]));
                let axes = |level: usize| {
                    full.map(|n| Axis::pooled((n >> level) as usize, p / f64::from(1 << level)))
                };
                fits.then(|| std::array::from_fn(axes)).ok_or(bad(p))
            })
            .collect::<Result<_, _>>()?;
        let (width, height) = (width as usize, height as usize);
        let pyramid = Pyramid::new([width, height], full.map(|n| n as usize));
        Ok(Hvsq { width, height, axes, pyramid, gradients: None })
    }

    /// The statistics of a reference picture, to be kept for comparisons: about 4 floats per value
    /// of the picture and pooling.
    ///
    /// # Panics
    /// If the picture is not of the size of this measure.
    pub fn reference(&mut self, picture: &Picture) -> Reference {
        self.analyse(picture);
        Reference::of(&self.pyramid, &self.axes)
    }

    /// The measure at every pooling, in the order given.
    ///
    /// # Panics
    /// If the picture or the reference is not of the size and poolings of this measure.
    pub fn values(&mut self, picture: &Picture, reference: &Reference) -> Vec<f64> {
        let all = self.statistics(picture, reference);
        all.iter().map(|s| s.iter().sum::<f64>() / STATISTICS as f64).collect()
    }

    /// The 51 mean squared differences at every pooling: the mean and the deviation of the highest
    /// frequencies, then of every band of every level, then the lowest frequencies.
    ///
    /// # Panics
    /// As [`Hvsq::values`].
    pub fn statistics(
        &mut self,
        picture: &Picture,
        reference: &Reference,
    ) -> Vec<[f64; STATISTICS]> {
        self.analyse(picture);
        self.compare(reference, None)
    }

    /// The measure at every pooling; `gradient` gets the derivative of its sum, weighted by
    /// `weights`, by every channel of every pixel.
    ///
    /// # Panics
    /// As [`Hvsq::values`]; if `weights` has not one weight per pooling; if `gradient` has another
    /// size than the picture.
    pub fn evaluate(
        &mut self,
        picture: &Picture,
        reference: &Reference,
        weights: &[f64],
        gradient: &mut [[f32; 3]],
    ) -> Vec<f64> {
        assert_eq!(weights.len(), self.axes.len(), "one weight per pooling");
        assert_eq!(gradient.len(), self.width * self.height, "one gradient per pixel");
        self.analyse(picture);
        let all = self.compare(reference, Some(weights));
        let gradients = self.gradients.as_mut().expect("made by the comparison");
        gradients.collect(&self.pyramid, gradient);
        all.iter().map(|s| s.iter().sum::<f64>() / STATISTICS as f64).collect()
    }

    fn analyse(&mut self, picture: &Picture) {
        let size = (picture.width as usize, picture.height as usize);
        assert_eq!(size, (self.width, self.height), "the size of this measure");
        assert_eq!(picture.pixels.len(), self.width * self.height, "all pixels are there");
        self.pyramid.analyse(&picture.pixels);
    }

    /// Compares the pyramid with a reference; with weights, the derivatives by all maps go into
    /// the gradients.
    fn compare(
        &mut self,
        reference: &Reference,
        weights: Option<&[f64]>,
    ) -> Vec<[f64; STATISTICS]> {
        assert_eq!(reference.poolings(), self.axes.len(), "a reference at the same poolings");
        let mut all = vec![[0.0; STATISTICS]; self.axes.len()];
        if weights.is_some() && self.gradients.is_none() {
            self.gradients = Some(HvsqGradients::new(&self.pyramid));
        }
        let slots: Vec<_> = match (&mut self.gradients, weights) {
            (Some(gradients), Some(_)) => gradients.maps_mut().map(Some).collect(),
            _ => std::iter::repeat_with(|| None).take(3 * MAPS).collect(),
        };
        let (pyramid, axes) = (&self.pyramid, &self.axes);
        let sums: Vec<Vec<PoolSums>> = slots
            .into_par_iter()
            .enumerate()
            .map_init(PoolScratch::default, |scratch, (i, gradient)| {
                let (level, map) = pyramid.map(i);
                pool::compare(map, reference.map(i), level, axes, weights, gradient, scratch)
            })
            .collect();
        for (i, poolings) in sums.iter().enumerate() {
            for (statistics, sums) in all.iter_mut().zip(poolings) {
                let n = 3.0 * pyramid.map(i).1.area();
                statistics[2 * (i % MAPS)] += sums.mean / n;
                statistics[2 * (i % MAPS) + 1] += sums.deviation / n;
            }
        }
        let weight: f64 = weights.unwrap_or_default().iter().sum();
        for channel in 0..3 {
            let (low, expected) = (pyramid.lowest(channel), reference.lowest(channel));
            let gradient = self.gradients.as_mut().filter(|_| weights.is_some());
            let gradient = gradient.map(|g| g.lowest_mut(channel));
            let scale = 2.0 * weight / (STATISTICS as f64 * 3.0 * low.area());
            let sum = low.difference(expected, scale as f32, gradient);
            for statistics in &mut all {
                statistics[STATISTICS - 1] += sum / (3.0 * low.area());
            }
        }
        all
    }
}
