//! Many machines on many frames: sweeps, the analysis of their tables, and published numbers beside
//! ours.

pub mod analysis;
pub mod sweep;
pub mod validate;
pub mod views;
