//! Why a frame has no results.

use crate::workload::Geometry;
use crate::workload::demand::Unbinnable;
use powergs_base::budget::OverBudget;

/// A frame that the machine cannot run, although nothing is wrong with either.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Incompatible {
    /// A workload on a machine of another geometry.
    #[error(
        "frame was binned for {workload:?}, the machine has {machine:?}; bin it again for this \
         machine"
    )]
    Geometry {
        /// Of the workload.
        workload: Geometry,
        /// Of the machine.
        machine: Geometry,
    },
    /// A foveated frame on a machine that cannot show it.
    #[error(
        "the frame is foveated, and machine `{machine}` has no accumulators for levels: set \
         `fovea.accumulators = 1` (two levels one after the other) or 2, take another machine \
         (`gscore`), or extract the trace without a gaze"
    )]
    Foveated {
        /// Name of the machine.
        machine: String,
    },
    /// A frame that the machine cannot show as half of a pair.
    #[error("machine `{machine}` has `stereo.impl` = \"{way}\": {because}; or set \"separate\"")]
    Stereo {
        /// Name of the machine.
        machine: String,
        /// `stereo.impl`.
        way: &'static str,
        /// Why.
        because: String,
    },
    /// More splats than the numbers in list entries can tell apart.
    #[error(
        "the frame has {splats} splats with a tile, and the lists of machine `{machine}` number \
         them with {bits} bits: set `record.id-bits` = {needed}, or `record.id-check` = false to \
         keep a published count of bytes",
        needed = 64 - (splats.max(&2) - 1).leading_zeros()
    )]
    Ids {
        /// Name of the machine.
        machine: String,
        /// Splats with at least one tile.
        splats: u64,
        /// `record.id-bits`.
        bits: u32,
    },
    /// Making the tile lists takes too much host memory.
    #[error(
        "the frame with the tile lists of machine `{machine}`, move by move, {over}, or set \
         `binning.impl` = \"free\""
    )]
    Lists {
        /// Name of the machine.
        machine: String,
        /// What it takes.
        over: OverBudget,
    },
    /// A unit rule from outside of the crate broke its contract.
    #[error("{0}")]
    Rule(String),
    /// A frame that was prepared for another dataflow, or for other machines of it.
    #[error("the frame was prepared for {work}, machine `{machine}` needs {needed}")]
    Work {
        /// What the frame was prepared for.
        work: String,
        /// Name of the machine.
        machine: String,
        /// What it needs.
        needed: String,
    },
    /// What only the dataflow of the machine knows.
    #[error("machine `{machine}` cannot run the frame: {why}")]
    Other {
        /// Name of the machine.
        machine: String,
        /// Why, and what to do.
        why: String,
    },
}

/// An account that did not close: a defect of the simulator.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InvariantViolated {
    /// Cycles of a unit do not add up.
    #[error(
        "internal error: frame {frame}: the {unit} accounts for {accounted} cycles of {expected}; \
         please report this"
    )]
    Cycles {
        /// The frame.
        frame: usize,
        /// The unit.
        unit: &'static str,
        /// Busy, stalled and idle cycles.
        accounted: u64,
        /// Instances x frame.
        expected: u64,
    },
    /// Bytes that the frame needs and bytes that the DRAM served differ.
    #[error(
        "internal error: frame {frame}: {stage} needs {charged} DRAM bytes (read, written), the \
         DRAM served {served}; please report this"
    )]
    Traffic {
        /// The frame.
        frame: usize,
        /// The stage, or `total`.
        stage: &'static str,
        /// Charged bytes, `read, written`.
        charged: String,
        /// Served bytes, `read, written`.
        served: String,
    },
    /// Requests were lost.
    #[error(
        "internal error: frame {frame}: {issued} DRAM requests issued, {served} served; please \
         report this"
    )]
    Requests {
        /// The frame.
        frame: usize,
        /// Issued.
        issued: u64,
        /// Served.
        served: u64,
    },
    /// The DRAM was faster than it can be.
    #[error(
        "internal error: frame {frame}: the DRAM moved {bytes} bytes in {seconds:.9} s, more than \
         its {rate:.3e} B/s; please report this"
    )]
    Bandwidth {
        /// The frame.
        frame: usize,
        /// Bytes moved.
        bytes: u64,
        /// Time of the frame.
        seconds: f64,
        /// Peak x efficiency, or the peak of the device, bytes per second.
        rate: f64,
    },
    /// Something was counted that no stage of the machine does, so that nobody would pay for it.
    #[error(
        "internal error: frame {frame}: {count} of `{action}` are counted, and nothing in the \
         machine `{machine}` does that; please report this"
    )]
    Undone {
        /// The frame.
        frame: usize,
        /// The key of the action.
        action: String,
        /// How often.
        count: u64,
        /// The machine.
        machine: String,
    },
    /// More was read of a region than was written to it.
    #[error(
        "internal error: frame {frame}: {read} bytes of {region} are read and {written} were \
         written; please report this"
    )]
    Unwritten {
        /// The frame.
        frame: usize,
        /// The region of the memory.
        region: &'static str,
        /// Distinct bytes read.
        read: u64,
        /// Bytes written.
        written: u64,
    },
    /// Parts of the energy do not add up to the total.
    #[error(
        "internal error: frame {frame}: energy parts sum to {parts} pJ, the total is {total} pJ; \
         please report this"
    )]
    Energy {
        /// The frame.
        frame: usize,
        /// Actions x prices and time x watts.
        parts: f64,
        /// The total of the breakdown.
        total: f64,
    },
}

/// Why a frame has no report.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimError {
    /// The machine cannot run the frame.
    #[error(transparent)]
    Incompatible(#[from] Incompatible),
    /// A frame whose lists take more memory than is allowed.
    #[error(transparent)]
    Unbinnable(#[from] Unbinnable),
    /// A defect of the simulator.
    #[error(transparent)]
    Invariant(#[from] InvariantViolated),
}
