//! Where what happened, when, and what it cost meet: one frame on one machine gives one
//! [`FrameReport`].

pub mod check;
pub mod cost;
pub mod measured;
mod pair;
pub mod paper;
pub mod regions;
pub mod report;
pub mod statistics;
mod timed;

use crate::machine::Machine;
use crate::workload::FrameWorkload;
use powergs_energy::Prices;

pub use check::{Incompatible, InvariantViolated, SimError};
pub use measured::{Lists, Measured, observed};
pub use pair::Periods;
pub use regions::RegionReport;
pub use report::{
    CacheSummary, CycleReport, FoveaSummary, Foveal, FrameReport, Label, ListOrder, ModelReport,
    OrderSummary, PaperReport, StageBytes,
};
pub use timed::{Timed, priced, time, time_again};

/// Version of the models. Raised whenever the same inputs give other numbers.
pub const MODEL_VERSION: u32 = 11;

/// Which model produced a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Closed-form counts of the published PowerGS model; has no time.
    Paper,
    /// The simulated machine.
    Cycle,
}

impl Model {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Model::Paper => "paper",
            Model::Cycle => "cycle",
        }
    }
}

/// Simulates one frame on one machine (`cycle` model) as if it were the first of its trace, and
/// checks that every account closes.
///
/// # Errors
/// [`SimError`]: a frame that the machine cannot run, or a defect of the simulator.
pub fn simulate(
    label: Label,
    workload: &FrameWorkload,
    machine: &Machine,
    prices: &Prices,
) -> Result<FrameReport, SimError> {
    check::fits(workload, machine)?;
    simulate_measured(label, workload, &Measured::needed(workload, machine), machine, prices)
}

/// As [`simulate`], with what was measured of the frame before.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_measured(
    label: Label,
    workload: &FrameWorkload,
    measured: &Measured,
    machine: &Machine,
    prices: &Prices,
) -> Result<FrameReport, SimError> {
    let timed = time(label.frame, workload, measured, machine)?;
    Ok(priced(label, &timed, prices)?)
}
