//! `powergs-sim`: a cycle-approximate simulator of GSCore-like accelerators for 3D Gaussian
//! Splatting (3DGS), with the PowerGS optimiser on top.
//!
//! A trace on a machine, in ten lines:
//!
//! ```
//! use powergs_sim::run::{FrameReport, RunError, Session, System, TraceFile};
//!
//! # fn main() -> Result<(), RunError> {
//! let gscore = System::named("gscore")?;
//! let larger = gscore.with(&["vru.cores=8".parse().expect("KEY=VALUE")])?;
//! let mut trace = TraceFile::open("traces/demo.bin".as_ref())?;
//! let reports = Session::new(&mut trace, &()).reports(&[gscore, larger])?;
//! for (four, eight) in reports[0].iter().zip(&reports[1]) {
//!     let fps = |report: &FrameReport| report.achieved_fps().unwrap_or(0.0);
//!     println!("{}: {:.0} FPS with 4 cores, {:.0} with 8", four.name, fps(four), fps(eight));
//! }
//! # Ok(())
//! # }
//! ```
//!
//! | to | start at |
//! |---|---|
//! | run machines on frames | [`run`]: [`run::System`], [`run::Session`], [`run::TraceFile`] |
//! | make frames of a scene | [`model`]: [`model::scene`], [`model::RenderedViews`] |
//! | read or write traces | [`model::trace`] |
//! | find what limits a machine, and what doubling a resource buys | [`study::replay::Replay`] |
//! | find what keys and assumptions move | [`study::sensitivity`] |
//! | try thousands of machines | [`study::sweep::run::Sweep`], [`study::analysis`] |
//! | change how a unit counts cycles | [`extend::tile_wise`] |
//! | add a dataflow | [`extend::flow`], [`extend::kernel`], [`extend::stage`] |
//! | find the fewest watts at a given quality | [`study::optimize::campaign::Campaign`] |
//! | find a model and a machine together | [`study::codesign::Codesign`] |
//! | write tables, pages and charts | [`report`] |
//!
//! These five modules are the library; `docs/api.txt` lists what is in them. Every part is a crate
//! of its own under `crates/`; this one hands them on and adds the command line. Without its
//! default features (`default-features = false`) it is the library alone: no argument parser, no
//! terminal, no charts, and no [`report`]. What is hidden here is for the programs of this
//! repository, and may change with any version.
//!
//! Five kinds of thing are never mixed: what the frame *is* ([`model`]), *when* things happen
//! ([`extend::flow`]), *how often* ([`extend::action`]), what it *costs* ([`run::EnergyTable`]),
//! and how it *looks* ([`report`]). `ARCHITECTURE.md` has the map, `docs/model.md` every modelling
//! assumption.

#[cfg(feature = "cli")]
#[doc(hidden)]
#[allow(clippy::missing_errors_doc)] // commands fail with `Failure`, which has the exit code
pub mod cli;

/// Machines on frames: systems, sessions, what frames come from, and the reports of frames.
pub mod run {
    pub use powergs_base::budget::Budget;
    pub use powergs_base::config::{ConfigError, KeyDoc, key_docs};
    pub use powergs_base::quantity;
    pub use powergs_core::machine::Machine;
    pub use powergs_core::run::*;
    pub use powergs_core::sim::statistics;
    pub use powergs_core::sim::{
        CycleReport, FrameReport, MODEL_VERSION, ModelReport, PaperReport,
    };
    pub use powergs_core::stage::EnergyTable;
    pub use powergs_dram::Device;
    pub use powergs_energy::{EnergyBreakdown, Prices};
    pub use powergs_frame::display::Display;
}

/// What is rendered: scenes and cameras, traces of frames, pictures and their quality.
pub mod model {
    pub use powergs_base::picture;
    pub use powergs_frame::{fovea, trace};
    pub use powergs_quality as quality;
    pub use powergs_raster as raster;
    pub use powergs_scene as scene;
    pub use powergs_views::{RenderedViews, statistics};
}

/// What dataflows, stages and rules of units from outside are made of.
pub mod extend {
    pub use powergs_base::quantity;
    pub use powergs_core::machine::check::Found;
    pub use powergs_core::machine::{
        BufferSpec, Exclusion, External, KeyValues, Machine, Optional, Reference,
    };
    pub use powergs_core::sim::contract;
    pub use powergs_core::stage;
    pub use powergs_energy::action;

    /// A dataflow: what it declares, and what it is asked for.
    pub mod flow {
        pub use powergs_core::flow::{
            Dataflow, FlowOutcome, FlowTables, FrameTask, Incompatible, InvariantViolated,
            SimError, Tables, TablesDecl, Work, WorkKey, WorkKind, flow_tables, register,
        };
    }

    /// The parts of every machine: agents in time, memory, buffers, streams, accounts, timelines.
    pub mod kernel {
        pub use powergs_core::kernel::{
            Agents, Calibration, FrameTiming, Halt, Halted, Histogram, Memo, MemoKey, Unit, buffer,
            calibration, drive, ledger, memory, stream, timeline,
        };
    }

    /// Units of tile-wise machines, and rules that take their place.
    pub mod tile_wise {
        pub use powergs_core::flow::tile_wise::{
            RuleError, RuledUnit, UnitRule, bsu, ccu, qsu, register, vru,
        };
    }

    /// The work of machines whose pixels stay on chip.
    pub mod resident {
        pub use powergs_core::flow::resident::Cut;
        pub use powergs_core::flow::resident::work::{RegionShape, ResidentFrame};
    }
}

/// Many runs: replay with what-if, sweeps and their analysis, sensitivity, published numbers,
/// the optimiser, and models and machines together.
pub mod study {
    pub use powergs_codesign as codesign;
    pub use powergs_study::{analysis, extract, findings, replay, sensitivity, sweep, validate};

    /// The optimiser: a request becomes a campaign, and a campaign results.
    pub mod optimize {
        pub use powergs_optimize::{
            campaign, fit, oracle, outcome, photos, references, request, results, role, schedule,
            settings, target, train, tune, views, watch,
        };
    }
}

#[cfg(feature = "cli")]
pub use powergs_report as report;

#[doc(hidden)]
pub use powergs_base::{budget, config, picture, quantity};
#[doc(hidden)]
pub use powergs_core::{flow, kernel, machine, sim, stage, workload};
#[doc(hidden)]
pub use powergs_energy::action;
#[doc(hidden)]
pub use powergs_frame::{display, fovea, splat, trace};
#[doc(hidden)]
pub use powergs_study::{
    analysis, extract, findings, replay, run_record, sensitivity, slurm, sweep, validate,
};
#[doc(hidden)]
pub use {
    powergs_codesign as codesign, powergs_dram as dram, powergs_energy as energy,
    powergs_optimize as optimize, powergs_quality as quality, powergs_raster as raster,
    powergs_scene as scene, powergs_views as views,
};
