//! A foveated model: four levels of one trained model in one.
//!
//! Level 1 is a whole model. Each further level is a part of the one before, with its own opacity
//! and DC colour; position, scale, rotation and the other SH coefficients are shared
//! (`powergs.md` §6.3). A Gaussian is in all levels up to its *highest* one.
//! `docs/foveation.md` describes the file byte by byte.

mod compose;
mod file;

pub use compose::ComposeError;
pub use file::{MAGIC, VERSION};

use super::{Gaussians, StorageOrder};

/// The parameters of one Gaussian that a level trains: DC colour and opacity, raw.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LevelPaint {
    /// SH coefficients of degree 0, by channel.
    pub dc: [f32; 3],
    /// Opacity before the logistic function.
    pub logit_opacity: f32,
}

/// A model with four levels. All lists have one entry per Gaussian of level 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Foveated {
    /// Level 1: what is shared, and its own DC colours and opacities.
    pub base: Gaussians,
    /// The highest level of every Gaussian: 0 for level 1 to 3 for level 4.
    pub highest: Vec<u8>,
    /// Paints of levels 2, 3 and 4, per Gaussian. A level that does not have the Gaussian repeats
    /// the paint of the level before, which is never used.
    pub paints: Vec<[LevelPaint; 3]>,
}

impl Foveated {
    /// Levels.
    pub const LEVELS: usize = 4;

    /// Gaussians of level 1.
    pub fn len(&self) -> usize {
        self.base.len()
    }

    /// Whether the model has no Gaussian.
    pub fn is_empty(&self) -> bool {
        self.base.is_empty()
    }

    /// Gaussians of each level.
    pub fn counts(&self) -> [usize; Self::LEVELS] {
        let mut counts = [0; Self::LEVELS];
        for &highest in &self.highest {
            counts[..=usize::from(highest)].iter_mut().for_each(|n| *n += 1);
        }
        counts
    }

    /// Sorts the Gaussians.
    pub fn sort(&mut self, order: StorageOrder) {
        if let Some(order) = order.of(&self.base) {
            self.base = self.base.permuted(&order);
            self.highest = order.iter().map(|i| self.highest[*i as usize]).collect();
            self.paints = order.iter().map(|i| self.paints[*i as usize]).collect();
        }
    }

    /// The paint of Gaussian `i` in `level`, 0 for level 1.
    pub fn paint(&self, level: usize, i: usize) -> LevelPaint {
        match level.checked_sub(1) {
            Some(upper) => self.paints[i][upper],
            None => paint_of(&self.base, i),
        }
    }

    /// `level` (0 for level 1) as a model of its own: the inverse of [`Foveated::compose`].
    ///
    /// # Panics
    /// If there is no such level.
    pub fn level(&self, level: usize) -> Gaussians {
        assert!(level < Self::LEVELS, "levels are 0 to 3");
        let base = &self.base;
        let kept = (0..self.len()).filter(|&i| usize::from(self.highest[i]) >= level);
        let mut out = Gaussians::with_capacity(self.counts()[level], base.sh_degree);
        out.antialiased = base.antialiased;
        let n = base.sh_coefficients();
        for i in kept {
            let paint = self.paint(level, i);
            out.means.push(base.means[i]);
            out.log_scales.push(base.log_scales[i]);
            out.rotations.push(base.rotations[i]);
            out.logit_opacities.push(paint.logit_opacity);
            for (channel, dc) in base.sh_of(i).chunks_exact(n).zip(paint.dc) {
                out.sh.push(dc);
                out.sh.extend_from_slice(&channel[1..]);
            }
        }
        out
    }
}

/// The paint of Gaussian `i` in `base`.
fn paint_of(scene: &Gaussians, i: usize) -> LevelPaint {
    let (sh, n) = (scene.sh_of(i), scene.sh_coefficients());
    LevelPaint { dc: [sh[0], sh[n], sh[2 * n]], logit_opacity: scene.logit_opacities[i] }
}
