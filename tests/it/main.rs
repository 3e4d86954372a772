//! One test binary; a module per topic.

mod camera;
mod raster;
mod workload;
