//! What runs the program (crates have their own tests).

#[allow(dead_code)] // the tests of the crate use the rest
#[path = "../../crates/report/tests/it/builder.rs"]
mod builder;
mod camera;
mod cli;
mod codesign;
mod config;
mod contract;
mod docs;
mod dram;
mod elsewhere;
mod examples;
mod fovea;
mod geometry;
mod headset;
mod lpips;
mod optimize;
mod order;
mod own_flow;
mod pareto;
mod photos;
mod regressions;
mod scene;
mod sensitivity;
#[cfg(unix)]
mod slurm;
mod sweep_command;
mod synth;
mod tidy;
mod trace;
