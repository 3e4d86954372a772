//! `powergs-sim`: a cycle-approximate simulator of GSCore-like accelerators for 3D Gaussian
//! Splatting (3DGS), with the PowerGS optimiser on top.
//!
//! A trace on a machine, in ten lines:
//!
//! ```
//! use powergs_sim::run::{Session, System, TraceFile};
//!
//! # fn main() -> Result<(), powergs_sim::run::RunError> {
//! let gscore = System::named("gscore")?;
//! let larger = gscore.with(&["vru.cores=8".parse().expect("KEY=VALUE")])?;
//! let mut trace = TraceFile::open("traces/demo.bin".as_ref())?;
//! let reports = Session::new(&mut trace, &()).reports(&[gscore, larger])?;
//! for (four, eight) in reports[0].iter().zip(&reports[1]) {
//!     let fps = |report: &powergs_sim::sim::FrameReport| report.achieved_fps().unwrap_or(0.0);
//!     println!("{}: {:.0} FPS with 4 cores, {:.0} with 8", four.name, fps(four), fps(eight));
//! }
//! # Ok(())
//! # }
//! ```
//!
//! | to | start at |
//! |---|---|
//! | run machines on frames | [`run`]: [`run::System`], [`run::Session`], [`run::TraceFile`] |
//! | make frames of a scene | [`scene`], [`views::RenderedViews`], [`raster`] |
//! | read or write traces | [`trace`] |
//! | find what limits a machine, and what doubling a resource buys | [`replay::Replay`] |
//! | find what keys and assumptions move | [`sensitivity`] |
//! | try thousands of machines | [`sweep::run::Sweep`], [`analysis`] |
//! | change how a unit counts cycles | [`flow::tile_wise::rules`] |
//! | find the fewest watts at a given quality | [`optimize::campaign::Campaign`] |
//! | find a model and a machine together | [`codesign::Codesign`] |
//! | write tables, pages and charts | [`report`] |
//!
//! Every part is a crate of its own under `crates/`; this one hands them on and adds the command
//! line ([`cli`]). Without its default features (`default-features = false`) it is the library
//! alone: no argument parser, no terminal, no charts.
//!
//! Five kinds of thing are never mixed: what the frame *is* ([`workload`]), *when* things happen
//! ([`flow`]), *how often* ([`action`]), what it *costs* ([`energy`]), and how it *looks*
//! ([`report`]). `ARCHITECTURE.md` has the map, `docs/model.md` every modelling assumption.

#[cfg(feature = "cli")]
#[allow(clippy::missing_errors_doc)] // commands fail with `Failure`, which has the exit code
pub mod cli;

pub use powergs_base::{budget, config, picture, quantity};
pub use powergs_core::{flow, kernel, machine, run, sim, stage, workload};
pub use powergs_energy::action;
pub use powergs_frame::{display, fovea, splat, trace};
#[cfg(feature = "cli")]
pub use powergs_report as report;
pub use powergs_study::{
    analysis, extract, findings, replay, run_record, sensitivity, slurm, sweep, validate,
};
pub use {
    powergs_codesign as codesign, powergs_dram as dram, powergs_energy as energy,
    powergs_optimize as optimize, powergs_quality as quality, powergs_raster as raster,
    powergs_scene as scene, powergs_views as views,
};
