//! Co-design: the model and the machine that need the fewest watts together.
//!
//! A space ([`space`]) has axes of the model (how much is pruned, the degree of its colours, the
//! number formats of its record, a codebook of its colours) and axes of the machine. Every model is
//! fine-tuned to the quality that is asked for once ([`fit`]), with a record that is read as the
//! machine will read it; its frames are priced on every machine ([`pricing`]), in a sweep with the
//! calibrated model of the DRAM. [`compare`] holds what is concluded: the best pair of all, beside
//! what searching one half after the other finds, after the winners were simulated once more with
//! the banked model.
//!
//! ```text
//! dense model --axes of the model--> fit --> K models at the target --> traces
//!                                                                        |  sweep
//! base machine --axes of the machine--> N machines ----------------------+--> K x N pairs
//! pairs --rank--> confirm on `banked` --> (a) to (e)
//! ```
//!
//! Everything is kept in a [`Store`](powergs_core::run::Store) under hashes of what it depends on,
//! so a run that was stopped goes on bit for bit, and a space that grows keeps what it has.

#![warn(clippy::missing_errors_doc)]

pub mod alternate;
pub mod compare;
pub mod error;
pub mod export;
pub mod fit;
pub mod halving;
pub mod machines;
pub mod model;
mod names;
mod part;
pub mod pricing;
pub mod run;
pub mod space;
pub mod stability;
pub mod watch;

pub use error::CodesignError;
pub use run::{Codesign, Finished};
