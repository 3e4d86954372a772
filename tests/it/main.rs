//! One test binary; a module per topic.

mod camera;
mod cli;
mod geometry;
mod photos;
mod raster;
mod report;
mod synth;
mod tidy;
mod scene;
mod trace;
mod workload;
