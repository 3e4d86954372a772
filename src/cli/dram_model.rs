//! `--dram-model` of commands that simulate many machines.

use super::Failure;
use powergs_core::run::System;

/// The DRAM models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum DramModelArg {
    /// One server with a latency and a rate.
    Bandwidth,
    /// One server with rates and latencies as a banked run of the frame has them.
    Calibrated,
    /// The device, with its banks, rows, queues and timings.
    Banked,
}

/// Said where many machines have another model than their file says.
pub const NOTE: &str = "DRAM model `calibrated`, from one `banked` run of each frame, in place of \
                        `banked`; --dram-model banked simulates every machine with that";

impl DramModelArg {
    /// The value of `dram.model`.
    pub const fn key(self) -> &'static str {
        match self {
            DramModelArg::Bandwidth => "bandwidth",
            DramModelArg::Calibrated => "calibrated",
            DramModelArg::Banked => "banked",
        }
    }

    /// The `--set` value of the model that is asked for.
    pub fn set(asked: Option<DramModelArg>) -> Option<String> {
        asked.map(|model| format!("dram.model={}", model.key()))
    }
}

/// A system as many variants of it are simulated, and whether that is another one: with the
/// `calibrated` model in place of `banked`, unless a model was asked for.
///
/// # Errors
/// Exit code 2: the system does not fit together.
pub fn for_many(system: System, asked: Option<DramModelArg>) -> Result<(System, bool), Failure> {
    match asked {
        Some(_) => Ok((system, false)),
        None => Ok(match system.calibrated()? {
            Some(calibrated) => (calibrated, true),
            None => (system, false),
        }),
    }
}
