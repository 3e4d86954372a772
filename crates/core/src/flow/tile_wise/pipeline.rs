//! The pipeline: when each unit works, with finite buffers, several cores and one shared DRAM.
//!
//! **Preprocessing.** Batches are taken in storage order. A CCU takes the next batch when it holds
//! fewer than `ccu.queue` and its share of the input buffer admits a full one, at most one a cycle.
//! It issues the first read of the batch at once, and the second when the first has arrived. It
//! processes its batches in order: a batch enters the unit when all its data has arrived and the
//! tile-list buffer admits its results, and frees its input buffer when its last record has
//! entered. `latency` cycles later its results are written to DRAM; the tile-list buffer is freed
//! when the write is complete. Preprocessing ends when all writes are complete.
//!
//! **Tiles.** Jobs are taken in the order of the schedule (`schedule`). Every core is a pipeline of
//! three stages (`core`): the list-fetch stage takes the next job when it has a free slot, reads
//! the job's list and runs the QSU passes; the chunk-issue stage sends the chunks of one job, in
//! order, into the feature buffer and to the BSU; the VRU renders the chunks in order and writes
//! the pixels. A chunk that reads colours passes the colour unit first (`colour`).
//!
//! **Overlap.** A tile's list is complete only when its last Gaussian has been binned and written,
//! so with `schedule.overlap = "none"` cores begin when preprocessing has ended (A28). With `tiles`
//! each list is read as soon as it is complete. With `frames` cores begin at once: they render this
//! frame while the CCUs preprocess the next one, which is taken to be like this one (A81).
//!
//! **Pixels that are known** (`pixels.source`; A141, A142). Where pixels are moved from the frame
//! before, CCUs begin when all are: what is rendered is known then. Colours that are found are
//! fetched beside the cores.
//!
//! **Gradients** (`training`; A146). Where tiles are taken in reverse as soon as they are rendered,
//! a gradient unit is behind each core; rendering units do not begin a tile while two wait for it.
//! What else belongs to a step follows the frame, part by part.
//!
//! **Ties.** Within a cycle, CCUs act before cores, each in the order of their number; this decides
//! which one gets the next batch or job, and whose DRAM request is issued first.
//!
//! Events are batches and chunks, never cycles or splats. A test oracle steps through the same
//! rules cycle by cycle (`pipeline/oracle.rs` of the tests).

mod ccu_state;
mod chunk_issue;
mod colour_stage;
mod core;
mod feature_queue;
mod gradient_stage;
mod list_completion;
mod list_fetch;
pub mod memo;
mod render;

use std::ops::Range;

use crate::flow::over::FirstUnit;
use crate::flow::over::pixels::PXU;
use crate::flow::steps::{StepCycles, StepPart};
use crate::flow::tile_wise::FrameContext;
use crate::flow::tile_wise::STREAMS;
use crate::flow::tile_wise::batch::{Batches, Pass};
use crate::flow::tile_wise::bsu::Bsu;
use crate::flow::tile_wise::ccu::{Ccu, GAUSSIAN_IN, TILE_LIST};
use crate::flow::tile_wise::colour;
use crate::flow::tile_wise::gradients::{GRU, GradientWork};
use crate::flow::tile_wise::layout::{AccessPattern, Layout};
use crate::flow::tile_wise::pipeline::ccu_state::CcuState;
use crate::flow::tile_wise::pipeline::core::Core;
use crate::flow::tile_wise::pipeline::gradient_stage::{GradientUnit, HandedTiles, LooksAgain};
use crate::flow::tile_wise::pipeline::list_completion::ListCompletion;
use crate::flow::tile_wise::qsu::{Qsu, SORTING};
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::rules::RuleCheck;
use crate::flow::tile_wise::schedule::{Job, Plan};
use crate::flow::tile_wise::traffic::pairs_written;
use crate::flow::tile_wise::vru::{FEATURE, FEATURES, PIXEL_OUT, Vru};
use crate::flow::tile_wise::{Overlap, PixelsSpec};
use crate::kernel::Memo;
use crate::kernel::blocks::{BlockStream, BlockUnit};
use crate::kernel::buffer::usage;
use crate::kernel::calibration::Recording;
use crate::kernel::ledger::cycles;
use crate::kernel::memory::{Arrival, Memory, NEVER, Request};
use crate::kernel::stream::StreamId;
use crate::kernel::timeline::Observer;
use crate::kernel::traffic::Traffic;
use crate::kernel::unit::Unit;
use crate::kernel::{self, BufferUse, FrameTiming, Histogram, drive};
use crate::machine::Machine;
use crate::stage::Measured;
use crate::workload::FrameWorkload;
use powergs_energy::action::ActionCounts;

/// What is read and written of pixels that are known.
const KNOWN: [StreamId; 2] = [STREAMS.id("known-in"), STREAMS.id("known-out")];

/// The memory, with the layout of tile-wise frames.
type TileMemory<'a> = Memory<'a, Layout<'a>>;

/// State that CCUs and cores share.
struct Shared<'a, O> {
    units: &'a ResolvedUnits,
    workload: &'a FrameWorkload,
    plan: &'a Plan,
    context: FrameContext<'a>,
    memory: TileMemory<'a>,
    /// Whether the results of a CCU are written in the order of its batches: requests complete in
    /// order, no core waits for list completion, and no batch leaves its entries in lines on chip,
    /// so that it has nothing to write.
    in_order: bool,
    batches: Batches<'a>,
    next_batch: u32,
    next_job: u32,
    lists: ListCompletion,
    /// Cycle in which the last spilled keys are written, as far as it is known.
    spilled: u64,
    /// Tiles between rendering units and gradient units, where these take them at once.
    handed: Option<HandedTiles>,
    /// Checks the results of unit rules from outside the crate.
    rule_check: RuleCheck,
    observer: &'a mut O,
}

impl<O: Observer> Shared<'_, O> {
    #[inline]
    fn issue(
        &mut self,
        now: u64,
        owner: u32,
        stream: StreamId,
        bytes: u64,
        span: impl FnOnce(&Layout) -> AccessPattern,
    ) -> Arrival {
        self.memory.issue(now, Request { owner, stream, bytes }, span, self.observer)
    }
}

impl<O> Shared<'_, O> {
    /// Starts again with the first record, if the records were only counted so far.
    fn begin_second_pass(&mut self) -> bool {
        let is_counted = first_pass(&self.context) == Pass::Count;
        if is_counted {
            // The counting pass wrote no entry: the second one reads what was converted, not the
            // scene (A90).
            let (workload, batch) = (self.workload, self.units.ccu.batch);
            let batches = Batches::new(workload, batch, pairs_written(workload, &self.context));
            let ccu = &self.units.ccu;
            self.batches = batches.with_lists(Pass::Scatter, self.context.lists).with_clusters(
                workload,
                ccu.spec.clusters,
                ccu.cluster_tests(),
            );
        }
        is_counted
    }

    /// Whether the pipeline of a VRU drains behind this tile: it does behind the last tile of a job
    /// that has chunks.
    fn drains(&self, job: &Job, tile: u32) -> bool {
        // Tiles without chunks leave nothing in the pipeline, so that the last one with chunks
        // drains it (A27).
        let tiles = self.plan.tiles_of(job);
        let is_filled = |t: &&u32| self.workload.tiles[**t as usize].chunks > 0;
        !self.units.vru.spec.tile_overlap && tiles.iter().rfind(is_filled) == Some(&tile)
    }
}

/// The agents of the event queue: CCUs, then cores, then what knows pixels, then gradient units,
/// then those that are done before the others begin.
struct Agents<'a> {
    ccus: Vec<CcuState>,
    cores: Vec<Core>,
    pixels: Option<BlockStream>,
    gradients: Vec<GradientUnit>,
    first: Vec<BlockStream>,
    work: Option<GradientWork<'a>>,
}

impl<'a> Agents<'a> {
    fn new(
        units: &ResolvedUnits,
        spec: &PixelsSpec,
        context: &FrameContext<'a>,
        layout: &Layout,
        work: Option<GradientWork<'a>>,
    ) -> Self {
        let ccus = units.ccu.spec.units;
        let cores = units.vru.spec.cores;
        let unit = BlockUnit {
            stage: PXU,
            owner: ccus + cores,
            rate: spec.per_cycle.into(),
            streams: KNOWN,
            places: layout.known(),
            waits: FEATURES,
        };
        // Numbers are the order within a cycle: gradient units act behind the cores whose tiles
        // they take.
        let before = ccus + cores + u32::from(spec.source.has_unit());
        let units_of = |work: &GradientWork| {
            (0..cores).map(|core| GradientUnit::new(work, core, before + core, layout)).collect()
        };
        Self {
            ccus: (0..ccus).map(|ccu| CcuState::new(ccu, ccu, units)).collect(),
            cores: (0..cores).map(|core| Core::new(core, ccus + core, units)).collect(),
            pixels: spec.source.has_unit().then(|| {
                BlockStream::new(unit, context.pixels.map_or(&[], |some| some.blocks.as_slice()))
            }),
            first: {
                let gradients = if work.is_some() { cores } else { 0 };
                let of = |(n, (unit, places)): (u32, (&FirstUnit, &[u64; 2]))| {
                    unit.stream(before + gradients + n, &STREAMS, *places)
                };
                (0..).zip(context.first.iter().zip(layout.first())).map(of).collect()
            },
            gradients: work.as_ref().map(units_of).unwrap_or_default(),
            work,
        }
    }

    /// CCUs and cores.
    fn rendering(&self) -> usize {
        self.ccus.len() + self.cores.len()
    }

    /// All but gradient units.
    fn of_frame(&self) -> usize {
        self.rendering() + usize::from(self.pixels.is_some())
    }

    fn all(&self) -> usize {
        self.of_frame() + self.gradients.len()
    }

    /// Runs some of them from cycle `start` until none has an event left.
    fn drive<O: Observer>(&mut self, which: Range<usize>, start: u64, shared: &mut Shared<'a, O>) {
        drive(&mut Acting { agents: self, shared }, which, start);
    }

    fn account(&mut self, now: u64, observer: &mut impl Observer) {
        self.ccus.iter_mut().for_each(|c| c.account(now, observer));
        self.cores.iter_mut().for_each(|c| c.account(now, observer));
        if let Some(pixels) = &mut self.pixels {
            pixels.account.up_to(now, observer);
        }
        self.gradients.iter_mut().for_each(|unit| unit.account(now, observer));
        self.first.iter_mut().for_each(|unit| unit.account.up_to(now, observer));
    }

    fn buffers(&self) -> Vec<BufferUse> {
        let cores = &self.cores;
        vec![
            usage(GAUSSIAN_IN, self.ccus.iter().map(|c| &c.input)),
            usage(TILE_LIST, self.ccus.iter().map(|c| &c.output)),
            usage(SORTING, cores.iter().map(|c| &c.list_fetch.keys)),
            usage(FEATURE, cores.iter().map(|c| &c.features.buffer)),
            usage(PIXEL_OUT, cores.iter().map(|c| &c.render.pixels)),
        ]
    }
}

/// Agents with what they share.
struct Acting<'s, 'a, O> {
    agents: &'s mut Agents<'a>,
    shared: &'s mut Shared<'a, O>,
}

impl<O: Observer> kernel::Agents for Acting<'_, '_, O> {
    #[inline]
    fn step(&mut self, agent: usize, now: u64) -> u64 {
        let (ccus, shared) = (self.agents.ccus.len(), &mut *self.shared);
        if let Some(ccu) = self.agents.ccus.get_mut(agent) {
            return ccu.step(now, shared);
        }
        if let Some(core) = self.agents.cores.get_mut(agent - ccus) {
            // States that the last step found hold until now; they are booked before anything
            // changes.
            core.account(now, shared.observer);
            return core.step(now, shared);
        }
        let (rendering, of_frame) = (self.agents.rendering(), self.agents.of_frame());
        let all = self.agents.all();
        if let Some(unit) = agent.checked_sub(all) {
            let Shared { memory, observer, .. } = shared;
            let span = |_, at| AccessPattern::Run(at);
            return self.agents.first[unit].step(now, memory, span, *observer);
        }
        if let Some(pixels) = self.agents.pixels.as_mut().filter(|_| agent == rendering) {
            let Shared { memory, observer, .. } = shared;
            return pixels.step(now, memory, |_, at| AccessPattern::Run(at), *observer);
        }
        let Agents { gradients, work, .. } = &mut *self.agents;
        let work = work.as_ref().expect("units have something to do");
        let next = gradients[agent - of_frame].step(now, work, shared);
        if shared.handed.as_ref().is_some_and(HandedTiles::is_over) {
            gradients.iter_mut().for_each(|unit| unit.rest(now, shared.observer));
        }
        next
    }

    /// Cores act after CCUs in the same cycle.
    #[inline]
    fn woken(&mut self) -> Option<Range<usize>> {
        let (ccus, rendering) = (self.agents.ccus.len(), self.agents.rendering());
        if let Some(again) = self.shared.handed.as_mut().and_then(HandedTiles::take_change) {
            let units = self.agents.of_frame();
            return match again {
                LooksAgain::Unit(core) => Some(units + core..units + core + 1),
                LooksAgain::Core(core) => {
                    self.agents.cores[core].has_chunks().then_some(ccus + core..ccus + core + 1)
                }
            };
        }
        self.shared.lists.take_growth().then_some(ccus..rendering)
    }

    #[inline]
    fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        self.shared.memory.advance(until)
    }

    fn halt(&self) -> kernel::Halt<'_> {
        self.shared.context.halt
    }
}

/// The results of the pipeline for a frame.
#[derive(Debug)]
pub struct Outcome {
    /// When.
    pub timing: FrameTiming,
    /// DRAM bytes, speculation included.
    pub traffic: Traffic,
    /// What follows the frame, where it is trained on.
    pub step: Measured,
    /// Actions of speculative work that was not used.
    pub speculation: ActionCounts,
    /// Whether unit rules from outside of the crate kept to their contract.
    pub(super) rule_check: RuleCheck,
    /// Requests to a device with their times, for an observer that wants them.
    pub(super) recording: Option<Recording>,
}

/// Runs a frame through the pipeline. `memo` must belong to this frame.
pub(crate) fn run<O: Observer>(
    workload: &FrameWorkload,
    machine: &Machine,
    units: &ResolvedUnits,
    plan: &Plan,
    context: FrameContext,
    memo: &Memo,
    observer: &mut O,
) -> Outcome {
    let overlap = machine.tiles().schedule.overlap;
    let work = GradientWork::new(workload, units, &context);
    let layout = Layout::new(workload, units, plan, &context);
    let memory = TileMemory::new(layout, &STREAMS, machine.memory(), context.calibration);
    let mut shared = Shared {
        units,
        workload,
        plan,
        context,
        in_order: memory.keeps_order() && overlap != Overlap::Tiles && context.lists.is_none(),
        memory,
        batches: Batches::new(workload, units.ccu.batch, pairs_written(workload, &context))
            .with_lists(first_pass(&context), context.lists)
            .with_clusters(workload, units.ccu.spec.clusters, units.ccu.cluster_tests()),
        next_batch: 0,
        next_job: 0,
        lists: ListCompletion::new(overlap == Overlap::Tiles),
        spilled: 0,
        handed: work
            .as_ref()
            .filter(|work| work.is_behind())
            .map(|w| HandedTiles::new(w.cores(), workload.tiles.len())),
        rule_check: RuleCheck::new(instances(units)),
        observer,
    };
    let spec = &machine.tiles().pixels;
    let mut agents = Agents::new(units, spec, &context, shared.memory.layout(), work);
    let (ccus, all) = (agents.ccus.len(), agents.all());
    let mut begins = 0;
    for unit in 0..agents.first.len() {
        agents.drive(all + unit..all + unit + 1, begins, &mut shared);
        begins = begins.max(agents.first[unit].end);
        agents.account(begins, shared.observer);
    }
    // What has to be rendered is known when all pixels of the frame before have been moved (A141).
    let (begins, all) = match agents.pixels.is_some() && machine.tiles().pixels.source.is_first() {
        true => {
            let unit = agents.rendering();
            agents.drive(unit..unit + 1, begins, &mut shared);
            let begins = agents.pixels.as_ref().map_or(0, |pixels| pixels.end).max(begins);
            agents.account(begins, shared.observer);
            (begins, unit)
        }
        false => (begins, all),
    };
    let preprocessing_end = match overlap {
        Overlap::None => {
            // Only this barrier makes preprocessing independent of the cores, so that machines can
            // share it.
            let memo = memo::is_apart(machine, &shared).then_some(memo);
            memo::preprocess(&mut agents, &mut shared, machine, memo, begins);
            let end = agents.ccus.iter().map(|c| c.end).max().unwrap_or(0).max(begins);
            // Cores have had no event so far, and their idle cycles must be booked before the first
            // one.
            agents.cores.iter_mut().for_each(|core| core.account(end, shared.observer));
            agents.drive(ccus..all, end, &mut shared);
            end
        }
        Overlap::Tiles | Overlap::Frames => {
            agents.drive(0..all, begins, &mut shared);
            agents.ccus.iter().map(|c| c.end).max().unwrap_or(0).max(begins)
        }
    };
    let known = agents.pixels.as_ref().map_or(0, |pixels| pixels.end);
    let before = preprocessing_end.max(known).max(shared.spilled);
    let frame = agents.cores.iter().map(|c| c.end).fold(before, u64::max);
    let (mut end, mut step) = (frame, Measured::default());
    if agents.work.is_some() {
        agents.account(frame, shared.observer);
        let ends = gradient_stage::follow(&mut agents, frame, &mut shared);
        end = ends[StepPart::Update as usize];
        step = StepCycles::between(frame, ends).measured();
        if let (true, Some(sums)) = (machine.tiles().gradients.has_cache(), context.sums) {
            step.extend(sums.measured());
        }
    }
    let shared = finish(&mut agents, end, shared);
    Outcome { step, ..outcome(&agents, preprocessing_end, end, shared) }
}

/// What CCUs do with the records at first.
fn first_pass(context: &FrameContext) -> Pass {
    let counts = context.lists.is_some_and(|lists| lists.counts_first());
    if counts { Pass::Count } else { Pass::Whole }
}

/// Closes all accounts at the end of the frame.
fn finish<'a, O: Observer>(
    agents: &mut Agents<'_>,
    frame: u64,
    mut shared: Shared<'a, O>,
) -> Shared<'a, O> {
    shared.memory.close(frame);
    agents.account(frame, shared.observer);
    let ccu = &shared.units.ccu;
    agents.ccus.iter_mut().for_each(|c| c.close(frame, |batch| ccu.held(batch)));
    agents.cores.iter_mut().for_each(|core| core.close(frame));
    shared
}

fn outcome<O: Observer>(
    agents: &Agents<'_>,
    preprocessing_end: u64,
    frame: u64,
    mut shared: Shared<O>,
) -> Outcome {
    let (units, cores) = (shared.units, &agents.cores);
    let (gsu, vru) = (&units.qsu.spec, &units.vru.spec);
    let mut unit_cycles = vec![cycles(Ccu::STAGE, 1, agents.ccus.iter().map(|c| &c.ledger))];
    if gsu.sorts() {
        unit_cycles.extend([
            cycles(Qsu::STAGE, gsu.qsu_per_core, cores.iter().map(|c| &c.qsu)),
            cycles(Bsu::STAGE, gsu.bsu_per_core, cores.iter().map(|c| &c.issue.ledger)),
        ]);
    }
    unit_cycles.push(cycles(
        Vru::STAGE,
        vru.units_per_core,
        cores.iter().map(|c| &c.render.ledger),
    ));
    if let Some(pixels) = &agents.pixels {
        unit_cycles.push(cycles(PXU, 1, [&pixels.account.ledger].into_iter()));
    }
    if agents.work.is_some() {
        let accounts = agents.gradients.iter().map(|unit| &unit.booked().ledger);
        unit_cycles.push(cycles(GRU, 1, accounts));
    }
    if units.colour.is_some() {
        unit_cycles.push(cycles(colour::UNITS, 1, cores.iter().map(|c| &c.colour.ledger)));
    }
    let of = |unit: &BlockStream| cycles(unit.stage(), 1, [&unit.account.ledger].into_iter());
    unit_cycles.extend(agents.first.iter().map(of));
    let mut speculation = ActionCounts::default();
    let mut tile_cycles = Histogram::EMPTY;
    for core in cores {
        speculation.add(&core.issue.speculation);
        tile_cycles.add(&core.render.tile_cycles);
    }
    let (dram, buffers) = (shared.memory.usage(), agents.buffers());
    let timing =
        FrameTiming { frame, preprocessing_end, units: unit_cycles, dram, buffers, tile_cycles };
    let traffic = shared.memory.traffic();
    let recording = if shared.observer.wants_times() { shared.memory.recording() } else { None };
    let rule_check = shared.rule_check;
    Outcome { timing, traffic, step: Measured::default(), speculation, rule_check, recording }
}

/// Units of all kinds in the machine.
fn instances(units: &ResolvedUnits) -> u64 {
    let (gsu, vru) = (&units.qsu.spec, &units.vru.spec);
    let sorters = |n: u32| if gsu.sorts() { n } else { 0 };
    let per_core = [sorters(gsu.qsu_per_core), sorters(gsu.bsu_per_core), vru.units_per_core];
    let per_core = per_core.map(u64::from);
    u64::from(units.ccu.spec.units) + u64::from(vru.cores) * per_core.iter().sum::<u64>()
}
