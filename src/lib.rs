//! `powergs-sim`: a cycle-approximate simulator of GSCore-like 3D Gaussian Splatting (3DGS)
//! accelerators.
//!
//! ```text
//! scene + cameras --raster--> image
//!        '-- extract --> trace --workload::bin(Geometry)--> FrameWorkload
//!                                  --accel(Machine)--> cycles, stalls, ActionCounts
//!                                  --energy(Table)--> FrameReport --> report
//! ```
//!
//! Five kinds of thing are never mixed: what the frame *is* (`workload`), *when* things happen
//! (`accel`), *how often* (`action`), what it *costs* (`energy`), and how it *looks* (`report`).
//! `ARCHITECTURE.md` has the map, `docs/model.md` every modelling assumption.

pub mod accel;
pub mod action;
pub mod analysis;
pub mod cli;
pub mod config;
pub mod display;
pub mod dram;
pub mod energy;
pub mod fovea;
pub mod optimize;
pub mod picture;
pub mod quality;
pub mod quantity;
pub mod raster;
pub mod report;
pub mod scene;
pub mod sim;
pub mod splat;
pub mod sweep;
pub mod trace;
pub mod validate;
pub mod workload;
