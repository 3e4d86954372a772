//! Sensitivity experiments: a machine with its keys or modelling assumptions perturbed, on any
//! lists of frames. What comes out is in [`findings::sensitivity`](crate::findings::sensitivity).
//!
//! - [`AssumptionStudy`] perturbs the knobs of the modelling assumptions, one at a time;
//! - [`KeyStudy`] perturbs every key of the machine, of its energy table and of its DRAM device,
//!   one at a time, and with [`InteractionStudy`] several keys together.

mod assumptions;
mod interactions;
mod key;
mod keys;
mod levels;
mod measure;

pub use assumptions::AssumptionStudy;
pub use interactions::{InteractionStudy, Method};
pub use keys::{KeyResults, KeyStudy};
pub use levels::{KeySelection, Levels};
