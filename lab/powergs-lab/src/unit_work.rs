//! Real work of the hardware units: lists of a trace, Gaussians and splats of a scene.
//! `characterise` runs it through gates, `vectors` writes it for test benches.

pub mod lists;
pub mod netlist;
pub mod views;
