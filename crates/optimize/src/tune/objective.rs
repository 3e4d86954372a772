//! The loss of an iteration and its gradient by the pixels.

use serde::{Deserialize, Serialize};

use super::super::pooled::Pooled;
use super::super::setup::Setup;
use powergs_base::picture::Picture;
use powergs_quality::loss::display_term;
use powergs_quality::{HvsqError, Loss};

/// Weight of HVSQ in the loss (`powergs`, section 6.2).
const HVSQ_WEIGHT: f64 = 100.0;

/// What a loss is made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Everything.
    pub total: f64,
    /// Display power of the picture, values above 1 counted as they are, W.
    pub display_w: f64,
    /// At level 1: mean absolute difference, SSIM, PSNR in dB.
    pub likeness: Option<[f64; 3]>,
    /// In the periphery: HVSQ.
    pub hvsq: Option<f64>,
}

/// Losses for all sizes of views.
#[derive(Debug, Default)]
pub(super) struct Losses {
    losses: Vec<((u32, u32), Loss)>,
    reference: Picture,
}

impl Losses {
    /// The loss of `picture`, which shows `view`, in HVSQ where that is given; `gradient` gets its
    /// derivatives.
    ///
    /// # Errors
    /// A view that HVSQ is not defined for.
    pub fn evaluate(
        &mut self,
        setup: &Setup<'_>,
        pooled: Option<&mut Pooled>,
        view: usize,
        picture: &Picture,
        lambda: f64,
        gradient: &mut [[f32; 3]],
    ) -> Result<Term, HvsqError> {
        match pooled {
            None => Ok(self.likeness(setup, view, picture, lambda, gradient)),
            Some(pooled) => {
                let hvsq = pooled.gradient(setup, view, picture, HVSQ_WEIGHT, gradient)?;
                let display_w = display_term(picture, lambda, setup.display, gradient);
                let total = HVSQ_WEIGHT * hvsq + lambda * display_w;
                Ok(Term { total, display_w, likeness: None, hvsq: Some(hvsq) })
            }
        }
    }

    fn likeness(
        &mut self,
        setup: &Setup<'_>,
        view: usize,
        picture: &Picture,
        lambda: f64,
        gradient: &mut [[f32; 3]],
    ) -> Term {
        setup.references.write_to(view, &mut self.reference);
        let size = (picture.width, picture.height);
        let at = self.losses.iter().position(|(s, _)| *s == size).unwrap_or_else(|| {
            self.losses.push((size, Loss::new(size.0, size.1)));
            self.losses.len() - 1
        });
        let loss = &mut self.losses[at].1;
        let parts = loss.evaluate(picture, &self.reference, lambda, setup.display, gradient);
        let likeness = Some([parts.l1, parts.ssim, parts.psnr_db]);
        Term { total: parts.total, display_w: parts.display_w, likeness, hvsq: None }
    }
}
