//! Gradients by the parameters of Gaussians, found where they are asked for.

use fearless_simd::dispatch;

use super::{TrainFrame, Which};
use powergs_frame::splat::Splat;
use powergs_frame::splat::gradient::{GradientBlock, HIDDEN, PixelSums, Stretch, unproject_block};

/// The slopes of a loss: whoever goes through the parameters finds the gradient of sixteen
/// Gaussians at a time, and need not keep it.
#[derive(Debug, Clone, Copy)]
pub struct Slopes<'a> {
    pub(super) frame: &'a TrainFrame,
    pub(super) which: Which,
    /// By Gaussian.
    pub(super) ranks: &'a [u32],
    /// By rank.
    pub(super) sums: &'a [PixelSums],
    /// By rank.
    pub(super) splats: &'a [Splat],
}

impl Slopes<'_> {
    /// The splats that the view sees, front to back, each with the gradient by its centre,
    /// 1/pixels: K Σ s δ, as `docs/gradients.md` has it. A splat without an inverse covariance has
    /// zero.
    pub fn by_centre(&self) -> impl Iterator<Item = (&Splat, [f32; 2])> {
        self.splats.iter().zip(self.sums).map(|(splat, sums)| {
            let [a, b, c] = splat.conic().unwrap_or([0.0; 3]);
            let [_, x, y, ..] = *sums;
            (splat, [a * x + b * y, b * x + c * y])
        })
    }

    /// Gaussians of the scene.
    pub fn points(&self) -> usize {
        self.ranks.len()
    }

    /// Whether the view sees a Gaussian; if not, its gradient is zero.
    #[inline]
    pub fn is_seen(&self, gaussian: usize) -> bool {
        self.ranks[gaussian] != HIDDEN
    }

    /// Writes to `out` the gradients of up to sixteen Gaussians that are seen: those at the places
    /// `seen` of `part`, which begins with Gaussian `first` and has the parameters of the forward
    /// pass.
    pub fn find(&self, part: &Stretch<'_>, first: usize, seen: &[u32], out: &mut GradientBlock) {
        let ranks = &self.ranks[first..];
        match self.which {
            Which::All => dispatch!(self.frame.options.level, simd =>
                unproject_block(simd, &self.frame.view, part, seen, ranks, self.sums, out)),
            Which::ColourAndOpacity => out.colour_and_opacity(part, seen, ranks, self.sums),
        }
    }
}
