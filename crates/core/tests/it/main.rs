//! The simulator: units against their rules, frames against naive twins, energy, memory, knobs.

mod accel;
mod calibrated;
mod clusters;
mod codebook;
mod config;
mod contract;
mod energy;
mod foveated;
mod gpu;
mod gradients;
mod kept_lists;
mod knobs;
mod oracle_memory;
mod pairs;
mod paper;
mod pipeline;
mod pixels;
mod placement;
mod recorded;
mod resident;
mod run;
mod second_master;
mod sh_degree;
mod stereo;
mod store;
mod workload;
