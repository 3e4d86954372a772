//! Sweeps, what their tables say, and published numbers beside ours.

mod analysis;
mod estimators;
mod slurm;
mod sweep_results;
mod sweep_space;
mod validate;
