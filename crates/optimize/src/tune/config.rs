//! What a fine-tune is to do.

use std::num::NonZeroU32;

use super::super::lambda::Control;
use super::super::prune::Score;

/// What is pruned, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pruning {
    /// Nothing.
    Never,
    /// In equal steps, the first before iteration 0, until `goal` Gaussians are left.
    Steps {
        /// What goes first.
        score: Score,
        /// Gaussians that are left.
        goal: usize,
        /// Number of steps.
        steps: NonZeroU32,
        /// Iterations between steps.
        every: u32,
    },
    /// `count` Gaussians whenever a check passes.
    WhilePassing {
        /// How many.
        count: usize,
    },
}

/// The display term of the loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DisplayTerm {
    /// None.
    Off,
    /// With this λ, 1/W.
    Fixed(f64),
    /// With a controlled λ, from this iteration on; none before.
    Controlled {
        /// First iteration with the term.
        from: u32,
        /// The controller's settings, with iterations counted from `from`.
        control: Control,
    },
}

/// Which model a fine-tune ends with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// The last.
    Last,
    /// The one with the least display power of those that passed a check with all pruning done;
    /// the last if none passed.
    Dimmest,
    /// The last that passed, else the last.
    LastPassing,
}

/// What a fine-tune minimises beside the display term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Objective {
    /// `0.8 L1 + 0.2 (1 - SSIM)`: the picture is looked at.
    Likeness,
    /// `100 HVSQ`: the picture is seen in the periphery, where the eye pools over so many pixels.
    Hvsq {
        /// The pooling, pixels.
        pooling: f64,
    },
}

/// Which parameters train.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trains {
    /// All.
    All,
    /// All SH coefficients.
    Colours,
    /// The constant SH coefficients and the opacities: the only parameters that a level of the
    /// periphery does not share.
    ColoursAndOpacities,
}

/// TuneConfig for a fine-tune.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TuneConfig {
    /// Iterations, at least 1.
    pub iterations: u32,
    /// What is pruned.
    pub pruning: Pruning,
    /// The display term.
    pub display: DisplayTerm,
    /// What it minimises.
    pub objective: Objective,
    /// What trains.
    pub trains: Trains,
    /// Which model it ends with.
    pub keep: Keep,
}
