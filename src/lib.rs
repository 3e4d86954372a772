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

pub mod cli;

pub use powergs_base::{config, picture, quantity};
pub use powergs_core::{accel, action, dram, energy, run, sim, workload};
pub use powergs_frame::{display, fovea, splat, trace};
pub use powergs_study::{analysis, sweep, validate};
pub use {
    powergs_optimize as optimize, powergs_quality as quality, powergs_raster as raster,
    powergs_report as report, powergs_scene as scene,
};
