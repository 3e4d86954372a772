//! Resident: the pixels of a region stay on chip, and each Gaussian of its list passes once through
//! all of them. Vorion; GCC and GSAcc in part.
//!
//! The image is cut into regions: tiles of any size, bands, or the whole. The front
//! converts Gaussians and writes a list of those that meet each region; order units sort
//! the lists; engines take one Gaussian of a list after the other through the pixels that
//! it covers, as many at a time as there are lanes, whether these pixels have stopped or not. Only
//! the region as a whole may stop (`raster.saturation`). The back of a list may go to a unit that
//! works pixel by pixel and leaves each one when it stops (`tail`); a list may be cut along depth
//! over several engines (`region.slices`), whose pixels are composed. Where the region is the
//! image, there is one list, of Gaussians. Gaussians may be converted late (`front.lazy`): in depth
//! order, as a region takes them, each once for every region.
//!
//! The front ends before the other stages begin; with `front.overlap = "frames"` all begin at once,
//! the front on the next frame, which is taken to be like this one. Within a cycle units act in the
//! order front, order units, engines, each in the order of their number; a list that is in order
//! can be fetched in the same cycle.

mod check;
mod engine;
mod front;
pub mod layout;
mod order;
pub mod stages;
mod tables;
pub mod training;
pub mod work;

use std::ops::Range;
use std::sync::Arc;

use super::{
    Dataflow, FlowDecl, FlowOutcome, FrameTask, Handed, History, Incompatible, RecordKeys,
    SimError, TablesDecl, Work, WorkKey,
};
use crate::flow::over::pixels::{self, PXU, PixelSource, SomeRegions};
use crate::flow::over::{FirstUnit, levels};
use crate::kernel::blocks::{BlockStream, BlockUnit};
use crate::kernel::calibration::{CalibrationRecorder, Recording};
use crate::kernel::ledger::cycles;
use crate::kernel::memory::{Arrival, Memory, Request};
use crate::kernel::stream::{StreamId, Streams};
use crate::kernel::timeline::Observer;
use crate::kernel::{self, Calibration, FrameTiming, Halt, Histogram, Memo, Stall, drive};
use crate::machine::check::Found;
use crate::machine::{BufferSpec, Machine, Reference};
use crate::stage::{
    DRAM_READ, DRAM_WRITE, Measured, StageDecl, sram_read, sram_write, streams, work_id,
};
use powergs_base::config::schema_of;
use powergs_energy::action::{ActionCounts, ActionId, Phase};
use powergs_frame::scene::Eye;

pub use tables::*;

use crate::flow::Task;
use crate::flow::steps::{StepCycles, StepPart};
use engine::{Engine, EngineCounts};
use front::FrontUnit;
use layout::{Layout, Place};
use order::OrderUnit;
use training::Step;
use work::{RegionShape, ResidentFrame};

const KEY: &str = "resident";

/// Its stages, in the order of every report.
pub const STAGES: &[&StageDecl] = &[
    &stages::FRONT_DECL,
    &stages::ORDER_DECL,
    &stages::RASTER_DECL,
    &stages::TAIL_DECL,
    &stages::COMPOSE_DECL,
    &pixels::PIXELS,
    &levels::LEVELS,
];

/// The dataflow with its stages.
pub const FLOW: FlowDecl = FlowDecl { flow: &ResidentFlow, stages: STAGES };

/// Their streams.
pub const STREAMS: Streams = streams(STAGES);

/// The streams by name.
struct StreamIds {
    records: StreamId,
    shades: StreamId,
    results: StreamId,
    lists: StreamId,
    passes_out: StreamId,
    passes_in: StreamId,
    ordered: StreamId,
    entries: StreamId,
    features: StreamId,
    pixels: StreamId,
    slices_out: StreamId,
    slices_in: StreamId,
}

const IDS: StreamIds = StreamIds {
    records: STREAMS.id("records"),
    shades: STREAMS.id("shades"),
    results: STREAMS.id("results"),
    lists: STREAMS.id("lists"),
    passes_out: STREAMS.id("passes-out"),
    passes_in: STREAMS.id("passes-in"),
    ordered: STREAMS.id("ordered"),
    entries: STREAMS.id("entries"),
    features: STREAMS.id("features"),
    pixels: STREAMS.id("pixels"),
    slices_out: STREAMS.id("slices-out"),
    slices_in: STREAMS.id("slices-in"),
};

/// Sources of pixels that know nothing of regions.
const NOT_BY_REGION: [PixelSource; 2] = [PixelSource::Cached, PixelSource::Sampled];

/// Their keys.
const KEYS_NOT_BY_REGION: [&str; 7] = [
    "pixels.ids",
    "pixels.ways",
    "pixels.entry",
    "pixels.region",
    "pixels.stride",
    "pixels.pattern",
    "pixels.filter",
];

/// The dataflow.
pub struct ResidentFlow;

impl Dataflow for ResidentFlow {
    fn key(&self) -> &'static str {
        KEY
    }

    fn means(&self) -> &'static str {
        "the pixels of a region stay on chip, and each Gaussian of its list passes once"
    }

    fn example(&self) -> Option<&'static str> {
        Some("vorion")
    }

    fn stages(&self) -> &'static [&'static StageDecl] {
        FLOW.stages
    }

    fn tables(&self) -> TablesDecl {
        let schema = || {
            let mut schema = schema_of::<Resident>();
            pixels::leave_out(&mut schema, &NOT_BY_REGION, &KEYS_NOT_BY_REGION);
            schema
        };
        TablesDecl { schema, ..TablesDecl::of::<Resident>() }
    }

    fn task(&self, machine: &Machine) -> Task {
        let m = machine.resident();
        Task::new((m.training.interval > 0).then_some(m.training.update), &m.pixels)
    }

    fn check(&self, machine: &Machine, found: &mut Found) {
        check::check(machine.resident(), found);
    }

    fn record(&self) -> Option<RecordKeys> {
        Some(RecordKeys {
            position: "gaussian.position",
            shape: "gaussian.shape",
            colour: "gaussian.colour",
            pitch: "gaussian.colour-pitch",
            extra: None,
            codebook: None,
        })
    }

    fn tile(&self, machine: &Machine, [width, height]: [u32; 2]) -> [u32; 2] {
        let m = machine.resident();
        RegionShape::new(m).region(width, height)
    }

    fn overlaps(&self, machine: &Machine) -> bool {
        machine.resident().front.overlap == FrontOverlap::Frames
    }

    fn under_way(&self, machine: &Machine) -> u64 {
        if self.overlaps(machine) { 2 } else { 1 }
    }

    fn work_key(&self, machine: &Machine) -> WorkKey {
        let m = machine.resident();
        RegionShape::new(m).key()
    }

    fn fits(&self, task: &FrameTask<'_>) -> Result<(), Incompatible> {
        let (frame, machine) = (frame(task)?, task.machine);
        let other = |why: String| Incompatible::Other { machine: machine.name.clone(), why };
        if frame.is_foveated {
            let why = "it is foveated, and no machine with resident pixels shows levels; extract \
                       the trace without a gaze, or take another machine (`gscore`)";
            return Err(other(why.into()));
        }
        if frame.key() != self.work_key(machine) {
            return Err(Incompatible::Work {
                work: frame.key().to_string(),
                machine: machine.name.clone(),
                needed: self.work_key(machine).to_string(),
            });
        }
        let m = machine.resident();
        let most = frame.regions.iter().map(|region| u64::from(region.pixels)).max().unwrap_or(0);
        let (needed, share) = (most * m.raster.pixel_state.0, m.pixel_share());
        if needed > share {
            let capacity = needed.saturating_mul(u64::from(m.raster.engines));
            return Err(other(format!(
                "a region of it has {most} pixels, which take {needed} B of the {share} B that \
                 each engine has: set `stores.pixels.capacity` to at least {capacity} B, or make \
                 `region.width` or `region.height` smaller"
            )));
        }
        m.pixels.counts(&machine.name, frame.regions.len(), "region.width")
    }

    fn takes_over(&self, machine: &Machine) -> Option<Vec<u32>> {
        Some(machine.resident().pixel_filter()?.numbers())
    }

    fn hand_over(
        &self,
        machine: &Machine,
        work: &dyn Work,
        eye: Option<Eye>,
        history: &mut History,
    ) -> Option<Handed> {
        let filter = machine.resident().pixel_filter()?;
        let frame = work.of::<ResidentFrame>()?;
        let tiles = frame.tiles.as_ref()?;
        let side = frame.shape.region(tiles.width, tiles.height);
        let some = SomeRegions::of(filter, tiles, side, eye, history);
        let made = some.wanted.as_ref().map(|wanted| frame.with_some(wanted));
        Some(Box::new(TakenRegions { made, some }))
    }

    fn run(
        &self,
        task: &FrameTask<'_>,
        observer: Option<&mut dyn Observer>,
    ) -> Result<FlowOutcome, SimError> {
        let frame = frame(task)?;
        let taken = task.before.and_then(|before| before.downcast_ref::<TakenRegions>());
        // What others share is of the whole frame.
        let own = Memo::default();
        let made = taken.and_then(|taken| taken.made.as_ref());
        let (frame, memo) = made.map_or((frame, task.memo), |made| (made, &own));
        let task = FrameTask { memo, ..*task };
        let some = taken.map(|taken| &taken.some);
        Ok(match observer {
            None => run(&task, frame, some, &mut ()),
            Some(mut observer) => run(&task, frame, some, &mut observer),
        })
    }
}

/// A frame of which some regions come from the frame before.
pub struct TakenRegions {
    /// The frame with those that are rendered; `None` where that is all.
    pub made: Option<ResidentFrame>,
    /// Where the others come from.
    pub some: SomeRegions,
}

/// The work of machines with resident pixels.
fn frame<'a>(task: &FrameTask<'a>) -> Result<&'a ResidentFrame, Incompatible> {
    task.work.of().ok_or_else(|| Incompatible::Work {
        work: task.work.key().to_string(),
        machine: task.machine.name.clone(),
        needed: ResidentFlow.work_key(task.machine).to_string(),
    })
}

/// The depth slices of a region.
#[derive(Debug, Clone, Copy, Default)]
struct Slices {
    ended: u32,
    written: u32,
    composed: bool,
}

/// What the units of a machine share in a frame.
pub struct RegionShared<'a, O> {
    machine: &'a Resident,
    frame: &'a ResidentFrame,
    memory: Memory<'a, Layout<'a>>,
    streams: &'static StreamIds,
    /// The first record that no unit of the front has.
    next_record: u64,
    /// The first region that no order unit has.
    next_region: u32,
    /// The first region, or slice of one, that no engine has.
    next_job: u32,
    /// Whether the list of each region is in order.
    is_ready: Vec<bool>,
    /// Whether one has become so.
    woken: bool,
    /// What is known of the slices of each region.
    slices: Vec<Slices>,
    /// When the front converted chunks for an engine, one after the other.
    conversions: Vec<[u64; 2]>,
    /// The first pixel of each region in memory.
    first_pixel: Vec<u64>,
    halt: Halt<'a>,
    observer: &'a mut O,
}

impl<'a, O: Observer> RegionShared<'a, O> {
    fn issue(
        &mut self,
        now: u64,
        owner: u32,
        stream: StreamId,
        bytes: u64,
        place: Place,
    ) -> Arrival {
        self.memory.issue(now, Request { owner, stream, bytes }, |_| place, self.observer)
    }

    fn layout(&self) -> &Layout<'a> {
        self.memory.layout()
    }

    fn chunk_bytes(&self, entries: u32) -> u64 {
        self.machine.chunk_bytes(u64::from(entries))
    }

    /// Regions, or slices of them, that no engine has yet.
    fn jobs_left(&self) -> u32 {
        self.frame.regions.len() as u32 * self.machine.region.slices - self.next_job
    }

    /// Says that the list of a region is in order.
    fn ready(&mut self, region: u32) {
        self.is_ready[region as usize] = true;
        self.woken = true;
    }
}

/// The units of a machine: front, order units, engines, what knows pixels, and those that are done
/// before the others begin.
struct Units<'s, 'a, O> {
    front: Vec<FrontUnit>,
    order: Vec<OrderUnit>,
    engines: Vec<Engine>,
    pixels: Option<BlockStream>,
    first: Vec<BlockStream>,
    shared: &'s mut RegionShared<'a, O>,
}

impl<O: Observer> Units<'_, '_, O> {
    /// What had no event before a barrier was idle up to it.
    fn account(&mut self, now: u64) {
        for unit in &mut self.front {
            unit.account.up_to(now, self.shared.observer);
        }
        for unit in &mut self.order {
            unit.account.up_to(now, self.shared.observer);
        }
        for engine in &mut self.engines {
            engine.account(now, self.shared.observer);
        }
        for unit in self.first.iter_mut().chain(&mut self.pixels) {
            unit.account.up_to(now, self.shared.observer);
        }
    }
}

impl<O: Observer> kernel::Agents for Units<'_, '_, O> {
    fn step(&mut self, agent: usize, now: u64) -> u64 {
        let (front, order) = (self.front.len(), self.order.len());
        match agent {
            n if n < front => self.front[n].step(now, self.shared),
            n if n < front + order => self.order[n - front].step(now, self.shared),
            n if n < front + order + self.engines.len() => {
                self.engines[n - front - order].step(now, self.shared)
            }
            n => {
                let RegionShared { memory, observer, .. } = &mut *self.shared;
                let n = n - front - order - self.engines.len();
                let unit = self.pixels.iter_mut().chain(&mut self.first).nth(n);
                let unit = unit.expect("an agent");
                unit.step(now, memory, |_, at| Place::Range(at), *observer)
            }
        }
    }

    fn woken(&mut self) -> Option<Range<usize>> {
        let first = self.front.len() + self.order.len();
        std::mem::take(&mut self.shared.woken).then_some(first..first + self.engines.len())
    }

    fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        self.shared.memory.advance(until)
    }

    fn halt(&self) -> Halt<'_> {
        self.shared.halt
    }
}

/// Makes a machine the one whose run on the device calibrates others: the same requests, by units
/// and buffers that are always the same.
fn refer(reference: &mut Machine) {
    let m = reference.resident_mut();
    // Before the engines are replaced, because each region is sized for one of the machine's own.
    let region = m.stores.pixels.capacity.0 / u64::from(m.raster.engines);
    (m.front.units, m.front.queue, m.front.latency) = (8, 16, 16);
    // Arithmetic that takes no time: only the memory is to be seen.
    m.front.operations_per_cycle = 1 << 20;
    (m.order.units, m.order.keys_per_cycle, m.order.latency) = (8, 4, 4);
    (m.raster.engines, m.raster.latency) = (if m.front.lazy { 1 } else { 8 }, 4);
    let (batch, chunk) = (u64::from(m.front.batch), u64::from(m.raster.chunk));
    let g = &m.gaussian;
    let record = g.position.0 + g.shape.0 + g.colour.0;
    let all = [4 * batch * record, 4 * batch * g.feature.0, 16 << 10, 8 * m.chunk_bytes(chunk)];
    let s = &mut m.stores;
    let stores = [&mut s.records, &mut s.results, &mut s.keys, &mut s.gaussians];
    for (store, bytes) in stores.into_iter().zip(all) {
        store.capacity.0 = 8 * bytes;
    }
    // Two regions for each of eight engines: one is worked on while the other is written.
    s.pixels.capacity.0 = 16 * region;
    s.tail.capacity = s.gaussians.capacity;
    m.pixels.per_cycle = 1 << 10;
    m.levels.operations_per_cycle = 1 << 16;
}

/// What a run on its device says of a machine's memory, where that is `calibrated`.
pub fn calibration(
    machine: &Machine,
    frame: &ResidentFrame,
    some: Option<&SomeRegions>,
    memo: &Memo,
) -> Option<Arc<Calibration>> {
    let run = |reference: &Machine, recorder: &mut CalibrationRecorder| {
        let task = FrameTask { halt: Halt::NEVER, ..FrameTask::first(reference, frame, memo) };
        through(&task, frame, some, None, recorder).1
    };
    Reference::calibration(machine, memo, refer, run, &STREAMS)
}

/// Takes a frame through a machine.
fn run<O: Observer>(
    task: &FrameTask<'_>,
    frame: &ResidentFrame,
    some: Option<&SomeRegions>,
    observer: &mut O,
) -> FlowOutcome {
    let calibration = calibration(task.machine, frame, some, task.memo);
    let mut outcome = through(task, frame, some, calibration.as_deref(), observer).0;
    if let Some(some) = some {
        outcome.measured.extend(some.summary.moved());
    }
    outcome
}

/// What is read and written of pixels that are known.
const KNOWN: [StreamId; 2] = [STREAMS.id("known-in"), STREAMS.id("known-out")];

fn through<O: Observer>(
    task: &FrameTask<'_>,
    frame: &ResidentFrame,
    some: Option<&SomeRegions>,
    calibration: Option<&Calibration>,
    observer: &mut O,
) -> (FlowOutcome, Option<Recording>) {
    let FrameTask { machine, halt, .. } = *task;
    let m = &machine.resident().of_degree(frame.sh_degree);
    let step = Step::new(m, frame);
    let blocks = some.map_or(&[][..], |some| &some.blocks);
    let firsts = FirstUnit::of(machine, frame.counters.points);
    let layout = Layout::new(frame, m, &firsts, BlockStream::bytes(blocks), step.as_ref());
    let (places, first_places) = (layout.known(), layout.first().to_vec());
    let memory = Memory::new(layout, &STREAMS, machine.memory(), calibration);
    let mut next_pixel = 0;
    let first_pixel = frame.regions.iter().map(|region| {
        let first = next_pixel;
        next_pixel += u64::from(region.pixels);
        first
    });
    let mut shared = RegionShared {
        machine: m,
        frame,
        memory,
        streams: &IDS,
        next_record: 0,
        next_region: 0,
        next_job: 0,
        is_ready: vec![false; frame.regions.len()],
        woken: false,
        slices: vec![Slices::default(); frame.regions.len()],
        conversions: Vec::new(),
        first_pixel: first_pixel.collect(),
        halt,
        observer,
    };
    let share = |store: &BufferSpec, owners: u32| store.capacity.0 / u64::from(owners);
    let (fronts, orders, engines) = (m.front.units, m.order.units, m.raster.engines);
    let s = &m.stores;
    let front = |n| FrontUnit::new(n, share(&s.records, fronts), share(&s.results, fronts));
    let order = |n| OrderUnit::new(fronts + n, n, share(&s.keys, orders));
    let stores = [&s.gaussians, &s.tail, &s.pixels].map(|store| share(store, engines));
    let has = [true, m.tail.share > 0.0, m.compose.lanes > 0];
    let engine = |n| Engine::new(fronts + orders + n, n, stores, has);
    let mut units = Units {
        front: (0..fronts).map(front).collect(),
        order: (0..orders).map(order).collect(),
        engines: (0..engines).map(engine).collect(),
        pixels: m.pixel_filter().map(|filter| {
            let unit = BlockUnit {
                stage: PXU,
                owner: fronts + orders + engines,
                rate: filter.spec.per_cycle.into(),
                streams: KNOWN,
                places,
                waits: Stall::of("features"),
            };
            BlockStream::new(unit, blocks)
        }),
        first: {
            let before = fronts + orders + engines + u32::from(m.pixel_filter().is_some());
            let of = |(n, (unit, places)): (u32, (&FirstUnit, [u64; 2]))| {
                unit.stream(before + n, &STREAMS, places)
            };
            (0..).zip(firsts.iter().zip(first_places)).map(of).collect()
        },
        shared: &mut shared,
    };
    let (apart, all) = (fronts as usize, (fronts + orders + engines) as usize);
    let front_end = |units: &Units<O>| units.front.iter().map(|unit| unit.end).max().unwrap_or(0);
    let mut begins = 0;
    for unit in 0..units.first.len() {
        let agent = all + usize::from(units.pixels.is_some()) + unit;
        drive(&mut units, agent..agent + 1, begins);
        begins = begins.max(units.first[unit].end);
        units.account(begins);
    }
    let preprocessing_end = match m.front.overlap {
        FrontOverlap::Frames => {
            drive(&mut units, 0..all, begins);
            front_end(&units).max(begins)
        }
        FrontOverlap::None => {
            if units.pixels.is_some() {
                // Which regions are rendered is known when all pixels have been moved.
                drive(&mut units, all..all + 1, begins);
                begins = units.pixels.as_ref().map_or(0, |unit| unit.end).max(begins);
                units.account(begins);
            }
            drive(&mut units, 0..apart, begins);
            let end = front_end(&units).max(begins);
            units.account(end);
            drive(&mut units, apart..all, end);
            end
        }
    };
    let end = units.engines.iter().map(|engine| engine.end).max().unwrap_or(0);
    // Engines without a region end at 0.
    let end = end.max(preprocessing_end);
    let Units { mut front, mut order, mut engines, mut pixels, mut first, .. } = units;
    // Late conversions came behind the front's own phase, one after the other, and are booked now.
    front.iter_mut().for_each(|unit| unit.convert(&shared.conversions, end, shared.observer));
    let mut after = Measured::default();
    let end = match &step {
        None => end,
        Some(step) => {
            engines.iter_mut().for_each(|engine| engine.account(end, shared.observer));
            let RegionShared { memory, observer, .. } = &mut shared;
            let ends = step.run(end, &mut front, &mut engines, memory, *observer);
            after = StepCycles::between(end, ends).measured();
            ends[StepPart::Update as usize]
        }
    };
    shared.memory.close(end);
    order.iter_mut().for_each(|unit| unit.account.up_to(end, shared.observer));
    engines.iter_mut().for_each(|engine| engine.account(end, shared.observer));
    let mut outcome = outcome(&front, &order, &engines, preprocessing_end, end, &shared);
    for unit in pixels.iter_mut().chain(&mut first) {
        unit.account.up_to(end, shared.observer);
        let ledgers = [&unit.account.ledger].into_iter();
        outcome.timing.units.push(cycles(unit.stage(), 1, ledgers));
    }
    firsts.iter().for_each(|unit| outcome.actions.add(&unit.actions));
    if let Some(some) = some {
        some.charge(&mut outcome.actions);
    }
    if let Some(step) = &step {
        step.charge(&mut outcome.actions);
        outcome.measured = after;
    }
    let recording = shared.observer.wants_times().then(|| shared.memory.recording()).flatten();
    (outcome, recording)
}

fn outcome<O: Observer>(
    front: &[FrontUnit],
    order: &[OrderUnit],
    engines: &[Engine],
    preprocessing_end: u64,
    end: u64,
    shared: &RegionShared<O>,
) -> FlowOutcome {
    let m = shared.machine;
    let of = |part: usize| {
        engines
            .iter()
            .filter_map(move |engine| engine.accounts[part].as_ref().map(|account| &account.ledger))
    };
    let mut units = vec![
        cycles(stages::FRONT, 1, front.iter().map(|unit| &unit.account.ledger)),
        cycles(stages::ORDER, 1, order.iter().map(|unit| &unit.account.ledger)),
        cycles(stages::RASTER, 1, of(0)),
    ];
    if m.tail.share > 0.0 {
        units.push(cycles(stages::TAIL, 1, of(1)));
    }
    if m.compose.lanes > 0 {
        units.push(cycles(stages::COMPOSE, 1, of(2)));
    }
    let mut buffers = FrontUnit::buffers(front).to_vec();
    buffers.push(OrderUnit::buffer(order));
    let [gaussians, tail, pixels] = Engine::buffers(engines);
    buffers.push(gaussians);
    if m.tail.share > 0.0 {
        buffers.push(tail);
    }
    buffers.push(pixels);
    let dram = shared.memory.usage();
    let served = shared.memory.traffic();
    let timing = FrameTiming {
        frame: end,
        preprocessing_end,
        units,
        dram,
        buffers,
        tile_cycles: Histogram::EMPTY,
    };
    let counts: Vec<&EngineCounts> = engines.iter().map(|engine| &engine.counts).collect();
    let moved = order.iter().map(|unit| unit.moved).sum();
    let live = counts.iter().map(|c| c.live).sum();
    let stopped: u64 = counts.iter().map(|c| c.stopped).sum();
    let actions = actions(shared, &counts, moved);
    FlowOutcome {
        executed_evaluations: live + stopped,
        ..FlowOutcome::plain(timing, actions, served, live)
    }
}

const CULL: ActionId = work_id("cull");
const PROJECT: ActionId = work_id("project");
const SHADE: ActionId = work_id("sh-colour");
const ALPHA: ActionId = work_id("alpha");
const STOPPED: ActionId = work_id("stopped-pixel");
const BLEND: ActionId = work_id("blend");
const FINISH: ActionId = work_id("pixel-finish");
const ROW: ActionId = work_id("row");

/// How often everything happened.
fn actions<O>(shared: &RegionShared<O>, engines: &[&EngineCounts], moved: u64) -> ActionCounts {
    use stages::{COMPOSED, GAUSSIANS, KEYS, MERGED_KEY, PIXELS, RECORDS, RESULTS, TAIL_IN};
    let (m, frame) = (shared.machine, shared.frame);
    let (g, c) = (&m.gaussian, &frame.counters);
    let sum = |of: fn(&EngineCounts) -> u64| engines.iter().map(|counts| of(counts)).sum::<u64>();
    let splats = frame.index.len() as u64;
    let mut all = ActionCounts::default();
    let mut charge = |phase: Phase, action: ActionId, n: u64| all.charge(phase, action, n);
    let first = Phase::Preprocessing;
    charge(first, CULL, c.points);
    charge(first, ROW, frame.up_to(c.points).rows);
    let entries = frame.entries.len() as u64 * g.entry.0;
    // What is converted late is charged to rendering below.
    let (read, written) = match m.front.lazy {
        true => (c.points * g.position.0, entries),
        false => {
            charge(first, PROJECT, c.survivors);
            charge(first, SHADE, splats);
            let read = c.points * (g.position.0 + g.shape.0) + splats * g.colour.0;
            (read, splats * g.feature.0 + entries)
        }
    };
    for (buffer, bytes) in [(RECORDS, read), (RESULTS, written)] {
        charge(first, sram_write(buffer), bytes);
        charge(first, sram_read(buffer), bytes);
    }
    charge(first, DRAM_READ, read);
    charge(first, DRAM_WRITE, written);
    charge(Phase::Sorting, MERGED_KEY, moved);
    let share = m.stores.keys.capacity.0 / u64::from(m.order.units);
    let (mut read, mut written) = (0, 0);
    for region in frame.regions.iter().filter(|region| region.entries > 0) {
        let keys = u64::from(region.entries);
        let bytes = keys * g.entry.0;
        // Between passes only: the first takes the list as it is read, and the last is written in
        // order.
        let between = m.order.passes(keys).saturating_sub(1) * (bytes - bytes.min(share));
        (read, written) = (read + bytes + between, written + bytes + between);
    }
    let keys = moved * g.entry.0;
    charge(Phase::Sorting, sram_write(KEYS), keys + entries);
    charge(Phase::Sorting, sram_read(KEYS), keys + entries);
    charge(Phase::Sorting, DRAM_READ, read);
    charge(Phase::Sorting, DRAM_WRITE, written);
    let last = Phase::Rendering;
    let converted = sum(|c| c.converted);
    charge(last, PROJECT, converted);
    charge(last, SHADE, converted);
    charge(last, ALPHA, sum(|c| c.live));
    charge(last, STOPPED, sum(|c| c.stopped));
    charge(last, BLEND, c.blends);
    charge(last, ROW, sum(|c| c.rows));
    let pixels: u64 = frame.regions.iter().map(|region| u64::from(region.pixels)).sum();
    charge(last, FINISH, pixels);
    charge(last, COMPOSED, sum(|c| c.composed));
    let asked = [sum(|c| c.asked[0]), sum(|c| c.asked[1])];
    for (buffer, bytes) in [GAUSSIANS, TAIL_IN].into_iter().zip(asked) {
        charge(last, sram_write(buffer), bytes);
    }
    charge(last, sram_read(GAUSSIANS), sum(|c| c.used));
    charge(last, sram_read(TAIL_IN), asked[1]);
    let slices = u64::from(m.region.slices);
    let state = m.raster.pixel_state.0;
    let touched = sum(|c| c.touched) * state;
    // Every slice is read once more at its end, to be put together or written.
    charge(last, sram_read(PIXELS), touched + pixels * slices * state);
    charge(last, sram_write(PIXELS), touched);
    let sliced = pixels * (slices - 1) * state;
    let sliced = if m.compose.through == ComposePath::Dram { sliced } else { 0 };
    charge(last, DRAM_READ, asked[0] + asked[1] + sliced);
    charge(last, DRAM_WRITE, pixels * g.pixel.0 + sliced);
    all
}
