//! Picture quality and display cost: losses with gradients for the optimiser, metrics for reports.
//! Definitions, formulas and sources: `docs/metrics.md`.

pub mod flip;
pub mod hvsq;
pub mod loss;
pub mod lpips;
pub mod metrics;

pub use hvsq::{Hvsq, HvsqError};
pub use loss::{Loss, Parts};
pub use lpips::{Lpips, LpipsError};
pub use metrics::{Likeness, likeness};
