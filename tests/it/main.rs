//! One test binary; a module per topic.

mod camera;
mod cli;
mod geometry;
mod photos;
mod accel;
mod energy;
mod paper;
mod pipeline;
mod raster;
mod report;
mod synth;
mod tidy;
mod scene;
mod trace;
mod workload;
