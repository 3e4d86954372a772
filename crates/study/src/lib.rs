//! What runs say ([`findings`]), and many machines on many frames: sweeps, the analysis of their
//! tables, and published numbers beside ours.

pub mod ablation;
pub mod analysis;
pub mod common;
pub mod extract;
pub mod findings;
pub mod replay;
pub mod run_record;
pub mod sensitivity;
pub mod slurm;
pub mod speedup;
pub mod sweep;
pub mod validate;
