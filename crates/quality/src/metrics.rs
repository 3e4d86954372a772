//! L1, PSNR and SSIM of two pictures, both clamped to 0..1 as a display would.

use super::loss::Loss;
use powergs_base::picture::Picture;

/// The similarity of two pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Likeness {
    /// Mean absolute difference over pixels and channels.
    pub l1: f64,
    /// Mean squared difference over pixels and channels.
    pub mse: f64,
    /// Structural similarity, 1 for equal pictures.
    pub ssim: f64,
    /// Peak signal-to-noise ratio for a peak of 1, dB; infinite for equal pictures.
    pub psnr_db: f64,
}

impl Likeness {
    /// The result for pictures with a value that is not a number.
    const UNKNOWN: Likeness =
        Likeness { l1: f64::NAN, mse: f64::NAN, ssim: f64::NAN, psnr_db: f64::NAN };
}

/// Compares two pictures, both clamped to 0..1 and not rounded; NaN if one of them holds a value
/// that is not finite. Allocates its work space: for many pictures of one size, keep a [`Loss`] and
/// call [`Loss::likeness`].
///
/// # Panics
/// If the sizes differ or there are no pixels.
pub fn likeness(picture: &Picture, reference: &Picture) -> Likeness {
    Loss::new(picture.width, picture.height).likeness(picture, reference)
}

impl Loss {
    /// [`likeness`] in this work space.
    ///
    /// # Panics
    /// If a picture is not of the size of this loss.
    pub fn likeness(&mut self, picture: &Picture, reference: &Picture) -> Likeness {
        let sums = self.measure(picture, reference);
        if !sums.l1.is_finite() {
            return Likeness::UNKNOWN;
        }
        Likeness { l1: sums.l1, mse: sums.square, ssim: sums.ssim, psnr_db: psnr_db(sums.square) }
    }
}

/// Peak signal-to-noise ratio of a mean squared error for a peak of 1, dB; infinite for 0.
pub fn psnr_db(mse: f64) -> f64 {
    -10.0 * mse.log10()
}
