//! Where what happened, when, and what it cost meet: one frame on one machine gives one
//! [`FrameReport`].

pub mod check;
pub mod contract;
pub mod cost;
mod pair;
pub mod paper;
pub mod regions;
pub mod report;
pub mod statistics;
mod timed;

use crate::flow::{FrameTask, Work};
use crate::kernel::Memo;
use crate::machine::Machine;
use powergs_base::build;
use powergs_energy::Prices;

pub use crate::flow::{FoveaSummary, Foveal, Incompatible, InvariantViolated, SimError};
pub use pair::Periods;
pub use regions::RegionReport;
pub use report::{CycleReport, FrameReport, Label, ModelReport, PaperReport, StageBytes};
pub use timed::{Timed, priced, time};

/// Version of the models. Raised whenever the same inputs give other numbers.
pub const MODEL_VERSION: u32 = 15;

/// Says in a record which build made it: versions of the program, of the models and of the traces
/// that it writes, and the commit.
pub fn made_by(record: &mut toml::Table) {
    let (major, minor) = powergs_frame::trace::VERSION;
    record.insert("tool-version".into(), build::TOOL_VERSION.into());
    record.insert("model-version".into(), i64::from(MODEL_VERSION).into());
    record.insert("trace-version".into(), format!("{major}.{minor}").into());
    record.insert("commit".into(), build::commit().into());
}

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
    work: &dyn Work,
    machine: &Machine,
    prices: &Prices,
) -> Result<FrameReport, SimError> {
    let memo = Memo::default();
    let timed = time(&FrameTask { frame: label.frame, ..FrameTask::first(machine, work, &memo) })?;
    Ok(priced(label, &timed, prices)?)
}
