//! Training from nothing: photos with poses become a model, by the published rules of 3DGS.
//!
//! Source: B. Kerbl, G. Kopanas, T. Leimkühler, G. Drettakis, *3D Gaussian Splatting for Real-Time
//! Radiance Field Rendering*, 2023, and the defaults of its reference code. `docs/train.md` lists
//! the rules and where this differs.
//!
//! ```text
//! points --start--> Gaussians --Trainer::step--> forward, loss, backward, then Adam or densify
//! ```
//!
//! The [`TrainState`] after any iteration is enough to go on bit for bit. Nothing here depends on
//! the number of threads.

pub mod densify;
mod neighbours;
mod rules;
pub mod start;
mod trainer;

pub use neighbours::nearest_three;
pub use rules::{PUBLISHED_ITERATIONS, TrainRules};
pub use trainer::{HeldOutSeen, TrainError, TrainInputs, TrainState, TrainStep, Trainer};
