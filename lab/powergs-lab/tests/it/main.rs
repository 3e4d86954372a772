//! The laboratory: its commands, pictures of the hardware, and the units of the cycle model against
//! those in RTL.

mod characterise;
mod chip;
mod claims;
mod claims_command;
mod docs;
#[path = "../../../../crates/report/tests/it/foveated_run.rs"]
mod foveated_run;
#[allow(dead_code)] // the tests of the rasteriser use the rest
#[path = "../../../../crates/raster/tests/it/naive.rs"]
mod naive;
mod picture;
mod render;
mod rendering_hardware;
mod sorting_hardware;
#[allow(dead_code)] // the tests of the accelerator use the rest
#[path = "../../../../crates/core/tests/it/pipeline/support.rs"]
mod support;
mod vectors;
