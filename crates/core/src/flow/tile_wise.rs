//! Tile-wise: the pairs of Gaussians and tiles are put into a list for each tile, a list is sorted
//! by depth and blended tile by tile. GSCore, Neo, GS-TG, FLICKER, MetaSapiens and GBU.
//!
//! Units say how long and how often, the pipeline says when. Nothing here knows a joule or a file.
//! [`replay`] takes a binned frame through one machine.

mod accounts;
pub mod batch;
pub mod blended;
pub mod bsu;
pub mod cache;
pub mod ccu;
mod check;
pub mod colour;
pub mod gradients;
mod gsu;
pub mod layout;
pub mod lists;
pub mod measures;
pub mod pipeline;
pub mod qsu;
mod reference;
mod resolved;
pub mod rules;
pub mod schedule;
pub mod stereo;
pub mod subtiles;
mod tables;
pub mod traffic;
pub mod vru;

use std::sync::Arc;

use super::{
    Dataflow, FlowDecl, FlowOutcome, FoveaSummary, Foveal, FrameTask, Handed, History,
    Incompatible, RecordKeys, RegionWork, SimError, TablesDecl, Work, WorkKey,
};
use crate::flow::Task;
use crate::flow::over::kept_order::{KeptOrder, TableUse};
use crate::flow::over::pixels::{self, SomePixels};
use crate::flow::over::{FirstUnit, levels};
use crate::kernel::calibration::CalibrationRecorder;
use crate::kernel::stream::Streams;
use crate::kernel::timeline::Observer;
use crate::kernel::traffic::Traffic;
use crate::kernel::{Calibration, FrameTiming, Halt, Memo};
use crate::machine::check::Found;
use crate::machine::{Machine, Reference};
use crate::stage::{Measured, StageDecl, streams};
use crate::workload::FrameWorkload;
use crate::workload::binning::ListWrites;
use crate::workload::reuse::{ListReuse, Reuse};
use powergs_base::config::schema_of;
use powergs_base::number::NumberFormat;
use powergs_energy::action::ActionCounts;
use powergs_frame::fovea::LEVELS;
use powergs_frame::scene::Eye;

pub use resolved::ResolvedUnits;
pub use rules::{Rule, RuleError, RuledUnit, UnitRule, UnitRules, register};
pub use tables::*;

use gradients::{FrameSums, GradientWork, SumKey};
use measures::CacheKey;
use schedule::Plan;
use stereo::EyeWork;
use subtiles::{ChunkRun, Discipline};
use vru::{ALPHA, STOPPED_PIXEL};

const KEY: &str = "tile-wise";

/// Its stages, in the order of every report.
pub const STAGES: &[&StageDecl] = &[
    &ccu::CCU,
    &qsu::QSU,
    &bsu::BSU,
    &vru::VRU,
    &vru::FRONTS,
    &stereo::STEREO,
    &pixels::PIXELS,
    &gradients::GRADIENTS,
    &cache::CACHE,
    &lists::LISTS,
    &colour::CODEBOOK,
    &colour::COLOUR,
    &levels::LEVELS,
];

/// The dataflow with its stages.
pub const FLOW: FlowDecl = FlowDecl { flow: &TileWiseFlow, stages: STAGES };

/// Their streams.
pub const STREAMS: Streams = streams(STAGES);

/// The dataflow.
pub struct TileWiseFlow;

impl Dataflow for TileWiseFlow {
    fn key(&self) -> &'static str {
        KEY
    }

    fn means(&self) -> &'static str {
        "a list for each tile of the Gaussians that touch it, sorted by depth, blended tile by tile"
    }

    fn example(&self) -> Option<&'static str> {
        Some("gscore")
    }

    fn stages(&self) -> &'static [&'static StageDecl] {
        FLOW.stages
    }

    fn tables(&self) -> TablesDecl {
        let schema = || {
            let mut schema = schema_of::<TileWise>();
            let tables = schema["properties"].as_object_mut();
            if let Some(tables) = tables.filter(|_| !rules::any_registered()) {
                tables.remove("rules");
            }
            schema
        };
        TablesDecl { schema, ..TablesDecl::of::<TileWise>() }
    }

    fn check(&self, machine: &Machine, found: &mut Found) {
        check::check(machine.tiles(), found);
    }

    fn record(&self) -> Option<RecordKeys> {
        Some(RecordKeys {
            position: "record.position",
            shape: "record.geometry",
            colour: "record.colour",
            pitch: "record.colour-pitch",
            extra: Some("record.colour-extra"),
            codebook: Some("codebook"),
        })
    }

    fn numbers(&self, machine: &Machine) -> Option<NumberFormat> {
        machine.tiles().record.numbers
    }

    fn tile(&self, machine: &Machine, _: [u32; 2]) -> [u32; 2] {
        [machine.tiles().geometry.tile; 2]
    }

    fn overlaps(&self, machine: &Machine) -> bool {
        machine.tiles().schedule.overlap != Overlap::None
    }

    /// With `frames`, A81.
    fn under_way(&self, machine: &Machine) -> u64 {
        if machine.tiles().schedule.overlap == Overlap::Frames { 2 } else { 1 }
    }

    fn work_key(&self, machine: &Machine) -> WorkKey {
        crate::flow::lists::work_key_for(machine.tiles().geometry, machine.tiles().detail())
    }

    fn fits(&self, task: &FrameTask<'_>) -> Result<(), Incompatible> {
        accounts::fits(workload(task)?, task)
    }

    fn task(&self, machine: &Machine) -> Task {
        let m = machine.tiles();
        Task::new((m.training.interval > 0).then_some(m.training.update), &m.pixels)
    }

    fn takes_over(&self, machine: &Machine) -> Option<Vec<u32>> {
        let (gsu, stereo) = (&machine.tiles().gsu, &machine.tiles().stereo);
        let period = gsu.period();
        let pixels = machine.tiles().pixel_filter().map(|filter| filter.numbers());
        if gsu.keeps_lists() {
            let kept = vec![gsu.implementation as u32, gsu.reuse_period, gsu.margin];
            return Some([kept, pixels.unwrap_or_default()].concat());
        }
        if pixels.is_some() {
            return pixels;
        }
        // Orders and second views exclude each other.
        match stereo.implementation {
            StereoImpl::Separate => (period > 1).then(|| vec![period]),
            way => Some(vec![way as u32, stereo.lag]),
        }
    }

    fn hand_over(
        &self,
        machine: &Machine,
        work: &dyn Work,
        eye: Option<Eye>,
        history: &mut History,
    ) -> Option<Handed> {
        self.takes_over(machine)?;
        if let Some(pair) = EyeWork::of(machine.tiles(), work.of()?, eye, history) {
            return Some(Box::new(pair));
        }
        let (gsu, workload) = (&machine.tiles().gsu, work.of::<FrameWorkload>()?);
        let keeping = gsu.keeping();
        let kept = keeping.map(|keeping| KeptOrder::of(keeping, workload, eye, history));
        let made = kept.as_ref().and_then(|kept| kept.made.as_deref());
        let of = |filter| SomePixels::of(filter, made.unwrap_or(workload), eye, history, false);
        let pixels = machine.tiles().pixel_filter().map(of);
        if kept.is_some() || pixels.is_some() {
            return Some(Box::new(TakenOver { kept, pixels }));
        }
        let reuse = measures::reuse(workload, eye, machine.tiles().gsu.period(), history)?;
        Some(Box::new(reuse))
    }

    fn shared(&self, machine: &Machine) -> Option<String> {
        pipeline::memo::shared_by(machine)
    }

    fn run(
        &self,
        task: &FrameTask<'_>,
        observer: Option<&mut dyn Observer>,
    ) -> Result<FlowOutcome, SimError> {
        let workload = workload(task)?;
        match observer {
            None => run(task, workload, &mut ()),
            Some(mut observer) => run(task, workload, &mut observer),
        }
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
    /// Lists of frames before that this one goes through, and those that it leaves.
    pub table: Option<&'a TableUse>,
    /// How pairs get into the lists of tiles; `None` where entries are written back to back.
    /// [`replay`] and its kin measure it themselves.
    pub lists: Option<&'a ListWrites>,
    /// What each chunk takes where units have to be followed through the sub-tiles; [`replay`] and
    /// its kin measure it themselves.
    pub runs: Option<&'a [ChunkRun]>,
    /// What of the frame is rendered, where that is not all.
    pub pixels: Option<&'a SomePixels>,
    /// Units that are done before anything else begins; [`replay`] and its kin find them.
    pub first: &'a [FirstUnit],
    /// Sums of the gradients of the frame, where it is trained on; [`replay`] and its kin measure
    /// them themselves.
    pub sums: Option<&'a FrameSums>,
    /// Whether it is the second eye of a pair, whose lists come from the first one on chip.
    pub derived: bool,
    /// What the `calibrated` model of the memory knows of the frame; [`replay`] and its kin measure
    /// it themselves.
    pub calibration: Option<&'a Calibration>,
    /// Whether the frame is still wanted.
    pub halt: Halt<'a>,
}

impl FrameContext<'_> {
    /// Whether the lists that are read are those that this frame writes, and no others.
    fn has_own_lists(&self) -> bool {
        self.reuse.is_none() && self.table.is_none()
    }

    /// What a chunk takes, by its position in [`FrameWorkload::chunks`].
    pub(crate) fn run(&self, chunk: usize) -> Option<ChunkRun> {
        self.runs.map(|runs| runs[chunk])
    }
}

/// One frame on one machine: when, how often, and what crossed the DRAM interface.
#[derive(Debug, Clone, PartialEq)]
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
    /// α evaluations of pixels that have not stopped, of the entries that units look at there.
    pub live_evaluations: u64,
    /// What follows the frame, where it is trained on.
    pub step: Measured,
    /// α that are evaluated again for it.
    pub evaluated_again: u64,
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
    replay_with(workload, machine, FrameContext::default(), &Memo::default(), &mut ())
}

/// As [`replay`], in a frame context, and tells `observer` what every unit did when. `memo` belongs
/// to this frame; the result is the same with any, and is there sooner if an earlier machine
/// prepared the same.
pub fn replay_with(
    workload: &FrameWorkload,
    machine: &Machine,
    context: FrameContext,
    memo: &Memo,
    observer: &mut impl Observer,
) -> FrameReplay {
    assert_eq!(
        workload.geometry,
        machine.tiles().geometry,
        "a workload runs on machines of its geometry"
    );
    assert_eq!(workload.detail, machine.tiles().detail(), "and of what else they need");
    let mut units = ResolvedUnits::for_frame(machine, workload);
    let first = first_units(workload, machine, &context);
    let context = FrameContext { first: &first, ..context };
    let lists = machine.tiles().list_shape().filter(|_| !context.derived);
    let lists = lists.map(|shape| memo.get(shape, |shape| ListWrites::new(workload, *shape)));
    let sums =
        SumKey::of(machine.tiles()).map(|key| memo.get(key, |k| FrameSums::new(workload, k)));
    let context = FrameContext { lists: lists.as_deref(), sums: sums.as_deref(), ..context };
    let calibration = calibration(workload, machine, &context, memo);
    if let Some(calibration) = &calibration {
        units.dram = calibration.dram();
    }
    let context = FrameContext { calibration: calibration.as_deref(), ..context };
    let make = |discipline: &Discipline| subtiles::runs(workload, discipline);
    let runs = units.vru.discipline.map(|discipline| memo.get(discipline, make));
    let context = FrameContext { runs: runs.as_ref().map(|runs| runs.as_slice()), ..context };
    let plan = Plan::new(workload, machine, &units, &context);
    let outcome = pipeline::run(workload, machine, &units, &plan, context, memo, observer);
    let mut check = outcome.rule_check;
    let tiles = traffic::tile_work(workload, &units, &plan, &context, &mut check);
    let mut actions = traffic::actions(workload, &units, &tiles, &context, &mut check);
    actions.add(&outcome.speculation);
    let live = match (&units.vru.discipline, context.runs) {
        (Some(discipline), Some(runs)) if discipline.counts_pixels() => {
            runs.iter().filter_map(|run| run.reach).map(|reach| reach.live).sum()
        }
        _ => workload.chunks.iter().map(|c| u64::from(c.skipping.live_evaluations)).sum(),
    };
    FrameReplay {
        live_evaluations: live,
        step: outcome.step,
        evaluated_again: GradientWork::new(workload, &units, &context)
            .map_or(0, |work| work.again()),
        timing: outcome.timing,
        actions,
        speculation: outcome.speculation,
        served: outcome.traffic,
        unwritten: traffic::unwritten(workload, &units, &context),
        regions: workload.fovea.as_ref().map(|_| tiles),
        rule_error: check.error,
    }
}

/// Units that are done before anything else of a frame begins. A second eye that is made of the
/// first one has the Gaussians of its frame.
fn first_units(
    workload: &FrameWorkload,
    machine: &Machine,
    context: &FrameContext,
) -> Vec<FirstUnit> {
    match context.derived {
        true => Vec::new(),
        false => FirstUnit::of(machine, workload.counters.points),
    }
}

/// What the `calibrated` model of the memory of a machine knows of a frame; `None` with another
/// model. The context has the lists of the frame, where the machine makes them.
pub fn calibration(
    workload: &FrameWorkload,
    machine: &Machine,
    context: &FrameContext,
    memo: &Memo,
) -> Option<Arc<Calibration>> {
    let run = |reference: &Machine, recorder: &mut CalibrationRecorder| {
        // Its own, whose arithmetic takes no time.
        let first = first_units(workload, reference, context);
        let context = FrameContext { first: &first, ..*context };
        reference::measure(workload, reference, &context, memo, recorder)
    };
    Reference::calibration(machine, memo, reference::refer, run, &STREAMS)
}

/// Takes a frame through a machine, with what is measured of it.
fn run(
    task: &FrameTask<'_>,
    workload: &FrameWorkload,
    observer: &mut impl Observer,
) -> Result<FlowOutcome, SimError> {
    if let Some(pair) = task.before.and_then(|before| before.downcast_ref::<EyeWork>()) {
        return pair_frame(task, workload, pair, observer);
    }
    if let Some(taken) = task.before.and_then(|before| before.downcast_ref::<TakenOver>()) {
        return taken_frame(task, workload, taken, observer);
    }
    let reuse = task.before.and_then(|before| before.downcast_ref::<Reuse>());
    let reuse = reuse.map(|reuse| reuse.lists.as_slice());
    run_in(task, workload, FrameContext { reuse, ..FrameContext::default() }, observer)
}

/// Takes a frame through a machine in a context, with its cache.
fn run_in(
    task: &FrameTask<'_>,
    workload: &FrameWorkload,
    context: FrameContext<'_>,
    observer: &mut impl Observer,
) -> Result<FlowOutcome, SimError> {
    let FrameTask { machine, memo, .. } = *task;
    let cache = CacheKey::of(machine).map(|key| memo.get(key, |key| key.replay(workload)));
    let hits = cache.as_ref().map(|cache| cache.hits.as_slice());
    let context = FrameContext { hits, halt: task.halt, ..context };
    let replay = replay_with(workload, machine, context, memo, observer);
    let mut outcome = outcome_of(task, workload, replay, context)?;
    if let Some(cache) = &cache {
        outcome.measured.extend(cache::measured(cache));
    }
    Ok(outcome)
}

/// What a frame takes over whose lists, or some of whose pixels, come from frames before.
struct TakenOver {
    kept: Option<KeptOrder>,
    pixels: Option<SomePixels>,
}

/// A frame that goes through lists of frames before, or leaves its own, or of which not all pixels
/// are rendered.
fn taken_frame(
    task: &FrameTask<'_>,
    workload: &FrameWorkload,
    TakenOver { kept, pixels }: &TakenOver,
    observer: &mut impl Observer,
) -> Result<FlowOutcome, SimError> {
    // What others share is of the frame's own lists.
    let own = Memo::default();
    let (kept, pixels) = (kept.as_ref(), pixels.as_ref());
    let made = pixels.and_then(|pixels| pixels.made.as_deref());
    let made = made.or_else(|| kept.and_then(|kept| kept.made.as_deref()));
    let (workload, memo) = made.map_or((workload, task.memo), |made| (made, &own));
    let table = kept.map(|kept| &kept.lists);
    let context = FrameContext { table, pixels, ..FrameContext::default() };
    let mut outcome = run_in(&FrameTask { memo, ..*task }, workload, context, observer)?;
    if let Some(summary) = kept.and_then(|kept| kept.summary.as_ref()) {
        outcome.measured.extend(measures::measured(summary));
    }
    if let Some(pixels) = pixels {
        outcome.measured.extend(pixels.summary.measured());
    }
    Ok(outcome)
}

/// What comes of a frame that has run, without its cache.
fn outcome_of(
    task: &FrameTask<'_>,
    workload: &FrameWorkload,
    replay: FrameReplay,
    context: FrameContext<'_>,
) -> Result<FlowOutcome, SimError> {
    let FrameTask { machine, memo, .. } = *task;
    if let Some(error) = &replay.rule_error {
        return Err(Incompatible::Rule(error.to_string()).into());
    }
    accounts::written(task.frame, workload, machine, &replay, !context.has_own_lists())?;
    let reuse = task.before.and_then(|before| before.downcast_ref::<Reuse>());
    let mut measured = replay.step;
    let is_new = context.table.is_none() && !context.derived && machine.tiles().gsu.sorts();
    if let Some(reuse) = reuse {
        measured.extend(measures::measured(&reuse.summary));
    } else if task.checks_order && is_new {
        let order = memo.get(measures::sorter(machine), |by| measures::order(workload, *by));
        measured.extend(Measured::clone(&order));
    }
    Ok(FlowOutcome {
        timing: replay.timing,
        executed_evaluations: replay.actions.total(ALPHA) + replay.actions.total(STOPPED_PIXEL)
            - replay.evaluated_again,
        live_evaluations: replay.live_evaluations,
        actions: replay.actions,
        served: replay.served,
        unwritten_bytes: replay.unwritten,
        measured,
        fovea: FoveaSummary::of(workload)
            .zip(replay.regions)
            .map(|(summary, regions)| Foveal { summary, regions }),
    })
}

/// A frame of a pair on a machine whose eyes share something.
fn pair_frame(
    task: &FrameTask<'_>,
    workload: &FrameWorkload,
    pair: &EyeWork,
    observer: &mut impl Observer,
) -> Result<FlowOutcome, SimError> {
    let machine = task.machine;
    if let Some(refused) = pair.refusal(machine) {
        return Err(refused.into());
    }
    let (separate, own) = (FrameTask { before: None, ..*task }, Memo::default());
    let mut outcome = match pair {
        EyeWork::Second(made, Some(_)) => {
            let hits: Vec<u32> = made.chunks.iter().map(|chunk| chunk.entries).collect();
            let context = FrameContext {
                hits: Some(&hits),
                derived: true,
                halt: task.halt,
                ..FrameContext::default()
            };
            let replay = replay_with(made, machine, context, &own, observer);
            outcome_of(&separate, made, replay, context)?
        }
        // What is kept of the frame is of its own lists.
        EyeWork::Second(made, None) => run(&FrameTask { memo: &own, ..separate }, made, observer)?,
        _ => run(&separate, workload, observer)?,
    };
    pair.charge(machine, &mut outcome.actions);
    if let EyeWork::Second(_, Some(summary)) = pair {
        outcome.measured.extend(summary.measured());
    }
    Ok(outcome)
}

/// The work of tile-wise machines.
///
/// # Errors
/// [`Incompatible::Work`]: the work of another dataflow.
fn workload<'a>(task: &FrameTask<'a>) -> Result<&'a FrameWorkload, Incompatible> {
    task.work.of().ok_or_else(|| Incompatible::Work {
        work: task.work.key().to_string(),
        machine: task.machine.name.clone(),
        needed: TileWiseFlow.work_key(task.machine).to_string(),
    })
}
