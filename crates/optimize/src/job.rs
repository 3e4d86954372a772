//! One model to make or to measure.

use serde::{Deserialize, Serialize};

use super::role::Role;
use super::tune::TuneConfig;

/// The quality and the level of the periphery that a model is made for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Place {
    /// Position in the variants of the plan.
    pub variant: u8,
    /// 0 for level 1, the whole picture and the fovea, to 3 for level 4.
    pub level: u8,
}

/// One model to make or to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Unique in the run; also the name of its files.
    pub name: String,
    /// What it is for.
    pub role: Role,
    /// Where it belongs.
    pub place: Place,
    /// Share of the Gaussians of `base` that is pruned.
    pub rho: f64,
    /// How many Gaussians `rho` is a share of; `None`: as many as the dense model has.
    pub base: Option<usize>,
    /// The job whose model it starts from; `None`: the dense (or the user's other) model.
    pub from: Option<String>,
    /// Whether it is the end of a curve: pruned without a display term for as long as the target is
    /// reached.
    pub is_end: bool,
    /// How it is trained; `None`: it is measured only.
    pub config: Option<TuneConfig>,
    /// Keeps the order of views of different fine-tunes apart. It is that of the same job of
    /// another variant, so that a variant is what it is alone.
    pub stream: u64,
}
