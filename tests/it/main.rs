//! What runs the program, and what reports look like (crates have their own tests).

mod camera;
mod cli;
mod codesign;
mod config;
mod contract;
mod docs;
mod dram;
mod examples;
mod fovea;
mod geometry;
mod lpips;
mod optimize;
mod own_unit;
mod pareto;
mod photos;
mod report;
mod scene;
mod sensitivity;
#[cfg(unix)]
mod slurm;
mod sweep_command;
mod synth;
mod tidy;
mod trace;
