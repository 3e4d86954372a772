//! The accelerator: units say how long and how often, the pipeline says when.
//!
//! Nothing here knows a joule or a file. [`replay`] takes a binned frame through one machine.

pub mod bank;
pub mod batch;
pub mod bsu;
pub mod buffer;
pub mod cache;
pub mod calibration;
pub mod ccu;
pub mod colour;
pub mod divide;
pub mod dram;
pub mod layout;
pub mod lists;
pub mod machine;
pub mod memory;
pub mod pipeline;
pub mod qsu;
pub mod regions;
mod resolved;
pub mod rules;
pub mod schedule;
mod second_master;
pub mod stream;
pub mod subtiles;
pub mod timeline;
pub mod traffic;
pub mod unit;
pub mod vru;

use std::sync::Arc;

use crate::workload::FrameWorkload;
use crate::workload::binning::ListWrites;
use crate::workload::reuse::ListReuse;
use powergs_dram::DramCommands;
use powergs_energy::action::{ActionCounts, BufferId, StageId};
use powergs_frame::fovea::LEVELS;

pub use crate::stage::Stall;
pub use calibration::Calibration;
pub use machine::Machine;
pub use pipeline::memo::Memo;
pub use resolved::ResolvedUnits;
pub use rules::{Rule, RuleError, UnitRule, UnitRules};
pub use traffic::Traffic;
pub use unit::Unit;

use machine::DramModel;
use regions::RegionWork;
use schedule::Plan;
use subtiles::ChunkRun;
use timeline::Observer;

/// Where the cycles of one kind of unit went, summed over its instances:
/// `busy + stalls + idle = instances * frame`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnitCycles {
    /// Which kind.
    pub unit: StageId,
    /// How many of them the machine has.
    pub instances: u32,
    /// Cycles with work.
    pub busy: u64,
    /// Cycles with work that could not proceed, by [`Stall::index`].
    pub stalls: [u64; Stall::MOST],
    /// Cycles without work: before its phase, after its last item.
    pub idle: u64,
}

/// Activity of the shared DRAM in one frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DramUse {
    /// Bytes read.
    pub read_bytes: u64,
    /// Bytes written.
    pub write_bytes: u64,
    /// Requests issued by the units.
    pub requests_issued: u64,
    /// Requests served.
    pub requests_served: u64,
    /// Time for which the data bus moved data, in whole cycles (rounded up), for the second master
    /// too.
    pub busy_cycles: u64,
    /// Bytes that the second master asked for and that were served: not among the others.
    pub second_master_bytes: u64,
    /// Commands of the device; `None` in the `bandwidth` model, which knows none.
    pub commands: Option<DramCommands>,
}

impl DramUse {
    /// Bytes that the units asked for, read and written.
    pub fn requested_bytes(&self) -> u64 {
        self.read_bytes + self.write_bytes
    }
}

/// Occupancy and throughput of one buffer, all its shares together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferUse {
    /// Which.
    pub buffer: BufferId,
    /// Its size, bytes.
    pub capacity: u64,
    /// The most that it held, bytes.
    pub peak: u64,
    /// Sum over the cycles of the frame of the bytes that it held.
    pub byte_cycles: u128,
    /// Bytes that entered.
    pub filled: u64,
    /// Bytes that left because they had been used.
    pub consumed: u64,
    /// Bytes that left unused.
    pub discarded: u64,
}

/// A histogram with two bins an octave: bin 0 counts zeros, bin `k` values from `2^((k-1)/2)` up to
/// `2^(k/2)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Histogram {
    /// Counts.
    pub bins: [u32; Histogram::BINS],
}

impl Histogram {
    /// Bins: the last one holds everything from 2^31.5.
    pub const BINS: usize = 64;

    /// An empty histogram.
    pub const EMPTY: Histogram = Histogram { bins: [0; Self::BINS] };

    /// Adds one to the bin of `value`.
    pub fn count(&mut self, value: u64) {
        self.bins[Self::bin(value)] += 1;
    }

    /// The bin of a value: found with integers, so that no rounding of a logarithm moves it.
    pub fn bin(value: u64) -> usize {
        if value == 0 {
            return 0;
        }
        let octave = value.ilog2();
        // At or above 2^(octave + 1/2), that is value^2 >= 2^(2 octave + 1).
        let upper = u128::from(value) * u128::from(value) >= 1u128 << (2 * octave + 1);
        (1 + 2 * octave as usize + usize::from(upper)).min(Self::BINS - 1)
    }

    /// Adds the counts of `other`.
    pub(crate) fn add(&mut self, other: &Histogram) {
        self.bins.iter_mut().zip(other.bins).for_each(|(n, m)| *n += m);
    }

    /// The least value of a bin.
    pub fn least(bin: usize) -> f64 {
        if bin == 0 { 0.0 } else { ((bin - 1) as f64 * 0.5).exp2() }
    }
}

/// When everything in one frame happened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameTiming {
    /// Length of the frame, cycles.
    pub frame: u64,
    /// Cycles until the last CCU was done.
    pub preprocessing_end: u64,
    /// Units of each kind that the machine has, in the order of their numbers.
    pub units: Vec<UnitCycles>,
    /// The DRAM.
    pub dram: DramUse,
    /// Buffers that fill and empty.
    pub buffers: Vec<BufferUse>,
    /// Cycles for which tiles (or merged tiles, or sort groups) held a core's renderer, from the
    /// first of their chunks to the last of their pixels.
    pub tile_cycles: Histogram,
}

impl FrameTiming {
    /// A buffer; `None` where the machine has no such buffer.
    pub fn buffer(&self, buffer: BufferId) -> Option<&BufferUse> {
        self.buffers.iter().find(|b| b.buffer == buffer)
    }

    /// Share of the frame in which the DRAM's data bus moved data, 0 to 1.
    pub fn dram_busy_frac(&self) -> f64 {
        if self.frame == 0 { 0.0 } else { self.dram.busy_cycles as f64 / self.frame as f64 }
    }

    /// The units of one kind; `None` where the machine has none.
    pub fn unit(&self, kind: StageId) -> Option<&UnitCycles> {
        self.units.iter().find(|units| units.unit == kind)
    }
}

/// Frame context: what the feature cache and the frame before contribute. Both are measured once
/// for a geometry, outside of the pipeline.
#[derive(Debug, Clone, Copy, Default)]
pub struct FrameContext<'a> {
    /// Feature records of each chunk that hit the feature cache; `None` without a cache.
    pub hits: Option<&'a [u32]>,
    /// What each list (of a tile, or of a sort group) reuses of the frame before; `None` where
    /// lists are sorted from scratch.
    pub reuse: Option<&'a [ListReuse]>,
    /// How pairs get into the lists of tiles; `None` where entries are written back to back.
    /// [`replay`] and its kin measure it themselves.
    pub lists: Option<&'a ListWrites>,
    /// What each chunk takes where units have to be followed through the sub-tiles; [`replay`] and
    /// its kin measure it themselves.
    pub runs: Option<&'a [ChunkRun]>,
    /// What the `calibrated` model of the memory knows of the frame; [`replay`] and its kin measure
    /// it themselves.
    pub calibration: Option<&'a Calibration>,
}

impl FrameContext<'_> {
    /// What a chunk takes, by its position in [`FrameWorkload::chunks`].
    pub(crate) fn run(&self, chunk: usize) -> Option<ChunkRun> {
        self.runs.map(|runs| runs[chunk])
    }
}

/// One frame on one machine: when, how often, and what crossed the DRAM interface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameReplay {
    /// When everything happened.
    pub timing: FrameTiming,
    /// How often everything happened: counted from the totals of the frame, and the speculative
    /// work, which depends on timing.
    pub actions: ActionCounts,
    /// The part of `actions` that is speculative work whose result was not used.
    pub speculation: ActionCounts,
    /// DRAM bytes served.
    pub served: Traffic,
    /// DRAM bytes read that nobody wrote (`record.feature-source = "nobody"`).
    pub unwritten: u64,
    /// The regions of a foveated frame.
    pub regions: Option<[RegionWork; LEVELS]>,
    /// How a unit rule from outside of the crate broke its contract. The rest then means nothing;
    /// [`sim`](crate::sim) refuses to report it.
    pub rule_error: Option<RuleError>,
}

/// Replays `workload` on `machine`, as the first frame of its trace.
///
/// # Panics
/// When the workload was binned with another geometry than the machine's, or when the machine is
/// one that no check lets through (a unit count, width or interval of zero).
pub fn replay(workload: &FrameWorkload, machine: &Machine) -> FrameReplay {
    replay_with(workload, machine, FrameContext::default(), &mut ())
}

/// As [`replay`], in a frame context, and tells `observer` what every unit did when.
pub fn replay_with(
    workload: &FrameWorkload,
    machine: &Machine,
    context: FrameContext,
    observer: &mut impl Observer,
) -> FrameReplay {
    through(workload, machine, context, None, observer)
}

/// As [`replay`], in a frame context, for many machines on one frame: `memo` belongs to this frame.
/// The result is the same, and is there sooner if an earlier machine preprocessed alike.
pub fn replay_again(
    workload: &FrameWorkload,
    machine: &Machine,
    context: FrameContext,
    memo: &Memo,
) -> FrameReplay {
    through(workload, machine, context, Some(memo), &mut ())
}

fn through(
    workload: &FrameWorkload,
    machine: &Machine,
    context: FrameContext,
    memo: Option<&Memo>,
    observer: &mut impl Observer,
) -> FrameReplay {
    assert_eq!(workload.geometry, machine.geometry, "a workload runs on machines of its geometry");
    let mut units = ResolvedUnits::for_frame(machine, workload);
    let lists = machine.list_shape().map(|shape| match memo {
        Some(memo) => memo.lists(workload, &shape),
        None => Arc::new(ListWrites::new(workload, shape)),
    });
    let context = FrameContext { lists: lists.as_deref(), ..context };
    let calibration = (machine.dram.model == DramModel::Calibrated).then(|| {
        let reference = calibration::reference(machine);
        match memo {
            Some(memo) => memo.calibration(workload, reference, &context),
            None => Arc::new(Calibration::measure(workload, &reference, &context)),
        }
    });
    if let Some(calibration) = &calibration {
        units.dram = calibration.dram();
    }
    let context = FrameContext { calibration: calibration.as_deref(), ..context };
    let runs = units.vru.discipline.map(|discipline| match memo {
        Some(memo) => memo.runs(workload, &discipline),
        None => Arc::new(subtiles::runs(workload, &discipline)),
    });
    let context = FrameContext { runs: runs.as_ref().map(|runs| runs.as_slice()), ..context };
    let plan = Plan::new(workload, machine, &units, &context);
    let outcome = pipeline::run(workload, machine, &units, &plan, context, memo, observer);
    let mut check = outcome.rule_check;
    let mut actions = traffic::actions(workload, &units, &plan, &context, &mut check);
    actions.add(&outcome.speculation);
    FrameReplay {
        timing: outcome.timing,
        actions,
        speculation: outcome.speculation,
        served: outcome.traffic,
        unwritten: traffic::unwritten(workload, &units, &context),
        regions: regions::regions(workload, machine, &units, &plan, &context, &mut check),
        rule_error: check.error,
    }
}
