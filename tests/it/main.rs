//! One test binary; a module per topic.

mod camera;
mod geometry;
mod photos;
mod raster;
mod workload;
mod report;
