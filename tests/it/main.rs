//! One test binary; a module per topic.

mod accel;
mod analysis;
mod camera;
mod cli;
mod config;
mod display;
mod dram;
mod energy;
mod fit;
mod geometry;
mod knobs;
mod paper;
mod photos;
mod pipeline;
mod quality;
mod raster;
mod report;
mod scene;
mod sweep_command;
mod sweep_results;
mod sweep_space;
mod synth;
mod tidy;
mod trace;
mod validate;
mod workload;
