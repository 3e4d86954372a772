//! Tile-wise: the pairs of Gaussians and tiles are put into a list for each tile, a list is sorted
//! by depth and blended tile by tile. GSCore, Neo, GS-TG, FLICKER, MetaSapiens and GBU.
//!
//! Units say how long and how often, the pipeline says when. Nothing here knows a joule or a file.
//! [`replay`] takes a binned frame through one machine.

pub mod batch;
pub mod bsu;
pub mod cache;
pub mod ccu;
mod check;
pub mod colour;
pub mod layout;
pub mod lists;
mod optional;
pub mod pipeline;
pub mod qsu;
mod reference;
pub mod regions;
mod resolved;
pub mod rules;
pub mod schedule;
pub mod subtiles;
mod tables;
pub mod traffic;
pub mod vru;

use std::sync::Arc;

use serde::Deserialize;
use serde_json::Value;
use toml::Spanned;
use toml::de::DeTable;

use super::{Dataflow, Tables};
use crate::kernel::timeline::Observer;
use crate::kernel::traffic::Traffic;
use crate::kernel::{Calibration, FrameTiming};
use crate::machine::check::Contradiction;
use crate::machine::{DramModel, Machine, Optional};
use crate::stage::StageDecl;
use crate::workload::FrameWorkload;
use crate::workload::binning::ListWrites;
use crate::workload::reuse::ListReuse;
use powergs_base::config::schema_of;
use powergs_energy::action::ActionCounts;
use powergs_frame::fovea::LEVELS;

pub use pipeline::memo::Memo;
pub use resolved::ResolvedUnits;
pub use rules::{Rule, RuleError, UnitRule, UnitRules};
pub use tables::*;

use regions::RegionWork;
use schedule::Plan;
use subtiles::ChunkRun;

/// The dataflow.
pub struct TileWiseFlow;

impl Dataflow for TileWiseFlow {
    fn key(&self) -> &'static str {
        "tile-wise"
    }

    fn means(&self) -> &'static str {
        "a list for each tile of the Gaussians that touch it, sorted by depth, blended tile by tile"
    }

    fn stages(&self) -> &'static [&'static StageDecl] {
        const STAGES: [&StageDecl; 8] = [
            &ccu::CCU,
            &qsu::QSU,
            &bsu::BSU,
            &vru::VRU,
            &cache::CACHE,
            &lists::LISTS,
            &colour::CODEBOOK,
            &colour::COLOUR,
        ];
        &STAGES
    }

    fn schema(&self) -> Value {
        schema_of::<TileWise>()
    }

    fn read(&self, tables: Spanned<DeTable<'_>>) -> Result<Tables, toml::de::Error> {
        TileWise::deserialize(toml::Deserializer::from(tables)).map(Tables::new)
    }

    fn from_table(&self, tables: toml::Table) -> Result<Tables, toml::de::Error> {
        TileWise::deserialize(toml::Value::Table(tables)).map(Tables::new)
    }

    fn optional(&self) -> &'static [Optional] {
        &optional::OPTIONAL
    }

    fn contradictions(&self, machine: &Machine) -> Vec<Contradiction> {
        check::problems(machine.tiles())
    }

    /// Keys that cannot move anything are left out: those of a cache that is not there
    /// (`inert.toml`).
    fn timing(&self, machine: &Machine) -> Vec<u8> {
        machine.tiles().timing(machine.clock)
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
    assert_eq!(
        workload.geometry,
        machine.tiles().geometry,
        "a workload runs on machines of its geometry"
    );
    let mut units = ResolvedUnits::for_frame(machine, workload);
    let lists = machine.tiles().list_shape().map(|shape| match memo {
        Some(memo) => memo.lists(workload, &shape),
        None => Arc::new(ListWrites::new(workload, shape)),
    });
    let context = FrameContext { lists: lists.as_deref(), ..context };
    let calibration = (machine.dram.model == DramModel::Calibrated).then(|| {
        let reference = reference::machine(machine);
        match memo {
            Some(memo) => memo.calibration(workload, reference, &context),
            None => Arc::new(reference::measure(workload, &reference, &context)),
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
