//! The training loss: `0.8 L1 + 0.2 (1 − SSIM) + λ P`, with its gradient, in one pass.
//!
//! The picture is not clamped: L1, SSIM and display power all count values above 1. Values below 0
//! are black for the display and have no display gradient. The reported PSNR is that of the clamped
//! picture. Source: `powergs`; `docs/metrics.md` has the formulas.
//!
//! Rows are processed in bands. The computation of a row does not depend on its band, and sums of
//! rows are added from top to bottom, so results do not depend on the number of threads.

mod band;
mod glow;
mod light;
mod window;

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::metrics::psnr_db;
use band::{BandJob, BandWork, Sums};
pub use glow::display_term;
use powergs_base::picture::Picture;
use powergs_frame::display::Display;
use window::LANES;

/// Weight of the structural part of the loss.
pub(crate) const SSIM_WEIGHT: f64 = 0.2;

/// The parts of a loss.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Parts {
    /// Mean absolute difference over pixels and channels, not clamped.
    pub l1: f64,
    /// Structural similarity, not clamped.
    pub ssim: f64,
    /// PSNR of the clamped picture, dB; infinite for equal pictures.
    pub psnr_db: f64,
    /// Display power of the picture, values above 1 counted as they are, W.
    pub display_w: f64,
    /// `0.8 l1 + 0.2 (1 − ssim) + λ display_w`.
    pub total: f64,
}

/// The loss for pictures of one size; keeps its work space between evaluations.
#[derive(Debug)]
pub struct Loss {
    width: usize,
    height: usize,
    work: Vec<BandWork>,
    rows: Vec<Sums>,
}

impl Loss {
    /// A loss for pictures of `width` x `height` pixels.
    ///
    /// # Panics
    /// If there are no pixels.
    pub fn new(width: u32, height: u32) -> Loss {
        assert!(width > 0 && height > 0, "a loss needs pixels");
        let (width, height) = (width as usize, height as usize);
        Loss { width, height, work: Vec::new(), rows: vec![Sums::default(); height] }
    }

    /// The loss of `picture` against `reference`; `gradient` gets its derivative by every channel
    /// of every pixel of `picture`, row-major. `lambda` weighs the watts on `display`. A value that
    /// is not a number makes the parts and the gradients near it not a number.
    ///
    /// # Panics
    /// If a picture or `gradient` is not of the size of this loss.
    pub fn evaluate(
        &mut self,
        picture: &Picture,
        reference: &Picture,
        lambda: f64,
        display: &Display,
        gradient: &mut [[f32; 3]],
    ) -> Parts {
        assert_eq!(gradient.len(), self.width * self.height, "one gradient per pixel");
        let mut job = self.job(picture, reference, false);
        let pixels = (self.width * self.height) as f64;
        let n = 3.0 * pixels;
        job.watts = display.coefficients().map(|k| (k / pixels) as f32);
        job.slopes = display.coefficients().map(|k| (lambda * k / pixels) as f32);
        job.l1_slope = ((1.0 - SSIM_WEIGHT) / n) as f32;
        job.ssim_slope = (-SSIM_WEIGHT / n) as f32;
        let mean = self.run(&job, Some(gradient.as_flattened_mut()));
        let display_w = mean.watts * n + display.static_power.0;
        Parts {
            l1: mean.l1,
            ssim: mean.ssim,
            psnr_db: psnr_db(mean.square),
            display_w,
            total: (1.0 - SSIM_WEIGHT) * mean.l1
                + SSIM_WEIGHT * (1.0 - mean.ssim)
                + lambda * display_w,
        }
    }

    /// Means over all values, of the pictures clamped to 0..1.
    pub(super) fn measure(&mut self, picture: &Picture, reference: &Picture) -> Sums {
        let job = self.job(picture, reference, true);
        self.run(&job, None)
    }

    fn job<'a>(&self, picture: &'a Picture, reference: &'a Picture, clamped: bool) -> BandJob<'a> {
        for p in [picture, reference] {
            let size = (p.width as usize, p.height as usize);
            assert_eq!(size, (self.width, self.height), "the size of the loss");
            assert_eq!(p.pixels.len(), self.width * self.height, "all pixels are there");
        }
        BandJob::new(
            self.width,
            self.height,
            picture.pixels.as_flattened(),
            reference.pixels.as_flattened(),
            clamped,
        )
    }

    /// Runs all bands; returns means.
    fn run(&mut self, job: &BandJob, gradient: Option<&mut [f32]>) -> Sums {
        // Neighbouring bands share ten rows of work: few bands, but enough to share evenly.
        let threads = rayon::current_num_threads();
        let bands = if threads == 1 { 1 } else { 2 * threads }.min(self.height.div_ceil(16));
        let height = self.height.div_ceil(bands);
        let bands = self.height.div_ceil(height);
        let width = self.width;
        self.work.resize_with(bands.max(self.work.len()), || BandWork::new(width));
        let level = Level::new();
        let band =
            |i: usize, work: &mut BandWork, rows: &mut [Sums], gradient: Option<&mut [f32]>| {
                let first = i * height;
                dispatch!(level, simd => band::run(simd, job, first, work, rows, gradient));
            };
        let parts =
            self.work[..bands].par_iter_mut().zip(self.rows.par_chunks_mut(height)).enumerate();
        match gradient {
            Some(gradient) => parts
                .zip(gradient.par_chunks_mut(height * width * 3))
                .for_each(|((i, (work, rows)), gradient)| band(i, work, rows, Some(gradient))),
            None => parts.for_each(|(i, (work, rows))| band(i, work, rows, None)),
        }
        let sum = self.rows.iter().fold(Sums::default(), |a, b| a.plus(b));
        sum.over((3 * self.width * self.height) as f64)
    }
}

/// `n` rounded up to whole SIMD vectors.
fn lanes(n: usize) -> usize {
    n.next_multiple_of(LANES)
}
