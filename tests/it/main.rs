//! One test binary; a module per topic.

mod raster;
mod workload;
