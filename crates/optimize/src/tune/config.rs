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
    /// Whenever a check passes, and the display term is off.
    WhilePassing {
        /// So many Gaussians, but at least one.
        most: usize,
        /// At most this share of what is left; below 1 it shrinks where recovering takes long.
        share: f64,
    },
}

/// How what there is above the target is spent on the display.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DisplayTerm {
    /// None.
    Off,
    /// None, but what the model to keep has above the target is spent on the display in the end, by
    /// gains of the colour channels.
    Gains {
        /// From this iteration on nothing is pruned, so that what is left recovers.
        from: u32,
    },
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

impl DisplayTerm {
    /// Whether there is a term in the loss.
    pub fn is_term(self) -> bool {
        match self {
            DisplayTerm::Fixed(_) | DisplayTerm::Controlled { .. } => true,
            DisplayTerm::Off | DisplayTerm::Gains { .. } => false,
        }
    }
}

/// Which model a fine-tune ends with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// The last.
    Last,
    /// The one with the fewest Gaussians, and of these with the least display power, of those that
    /// passed a check with all ordered pruning done; the last if none passed.
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

/// How fast parameters move, and how quiet what is kept of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// The largest factor on the learning rates after Gaussians were pruned; 1 for none.
    pub heat: f64,
    /// The factor on the learning rates where nothing is damaged.
    pub rest: f64,
    /// The model that is checked and kept is the mean over so many of the last iterations.
    pub averaged: u32,
}

impl Pace {
    /// As the published code: damaged models get no longer steps.
    pub const PUBLISHED: Pace = Pace { heat: 1.0, rest: 1.0, averaged: 1 };
    /// Long steps after pruning; the mean over iterations takes their noise away.
    pub const RECOVERING: Pace = Pace { heat: 6.0, rest: 1.0, averaged: 20 };
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
    /// How fast it goes.
    pub pace: Pace,
}
