//! The machine once more, cycle by cycle, written from the rules in words (module documentation of
//! `flow::tile_wise::pipeline` and its parts) and not from the recurrences: nothing is predicted,
//! every unit counts down, the memory moves tick by tick. Only the cost of a piece of work is
//! shared.

mod converter;
mod core;
mod gradients;
pub mod subtiles;

use std::collections::BTreeMap;

use powergs_core::flow::over::FirstUnit;
use powergs_core::flow::steps::StepPart;
use powergs_core::flow::tile_wise::layout::{AccessPattern, Layout};
use powergs_core::flow::tile_wise::schedule::Plan;
use powergs_core::flow::tile_wise::subtiles::ChunkRun;
use powergs_core::flow::tile_wise::{Fetch, Overlap, PixelSource, VruImpl};
use powergs_core::flow::tile_wise::{FrameContext, ResolvedUnits, STREAMS};
use powergs_core::machine::Machine;
use powergs_core::workload::FrameWorkload;
use powergs_dram::AddressRange;

use self::converter::{Converter, Work};
use self::core::Core;
use self::gradients::{Gru, Step};
use super::lanes;
use crate::oracle_blocks::{Block, Mover, levels};
use crate::oracle_memory;

/// The memory of a frame.
type Memory<'a> = oracle_memory::Memory<Layout<'a>>;

/// Units with cycles, in the order of timelines.
pub const UNITS: [&str; 8] = ["ccu", "qsu", "bsu", "vru", "pxu", "gru", "colour", "ltu"];
const PXU: usize = 4;
const GRU: usize = 5;
const COLOUR: usize = 6;
const LTU: usize = 7;

/// What the oracle saw.
#[derive(Debug, Default)]
pub struct Seen {
    /// One character per cycle by unit and instance, as `Timeline::draw`.
    pub rows: BTreeMap<(usize, usize), String>,
    /// Whether a unit traverses levels.
    has_levels: bool,
    pub preprocessing_end: u64,
    /// When the frame was rendered, and when each part of a step behind it ended.
    pub rendered: u64,
    pub step: Option<[u64; 4]>,
    pub frame: u64,
    pub requests: u64,
    pub read: [u64; 3],
    pub write: [u64; 3],
}

impl Seen {
    pub fn draw(&self) -> String {
        let rows = self.rows.iter();
        rows.map(|((u, i), row)| format!("{}{i} |{row}\n", UNITS[*u])).collect()
    }

    fn put(&mut self, unit: usize, instance: usize, symbol: char) {
        self.rows.entry((unit, instance)).or_default().push(symbol);
    }

    fn put_core(&mut self, machine: &Machine, core: usize, symbols: [char; 4]) {
        for (unit, symbol) in [1, 2, 3, COLOUR].into_iter().zip(symbols) {
            if unit != COLOUR || machine.tiles().ccu.fetch == Fetch::LazyColour {
                self.put(unit, core, symbol);
            }
        }
    }

    /// A cycle in which neither CCUs nor cores work.
    fn put_others(&mut self, machine: &Machine) {
        self.put_idle(0, machine.tiles().ccu.units as usize);
        for core in 0..machine.tiles().vru.cores as usize {
            self.put_core(machine, core, ['.'; 4]);
        }
        let source = machine.tiles().pixels.source;
        if source == PixelSource::Cached {
            self.put(PXU, 0, '.');
        }
        self.put_levels('.');
    }

    fn put_levels(&mut self, symbol: char) {
        if self.has_levels {
            self.put(LTU, 0, symbol);
        }
    }

    fn put_idle(&mut self, unit: usize, instances: usize) {
        (0..instances).for_each(|instance| self.put(unit, instance, '.'));
    }

    /// Cycles of all instances of a unit with this symbol.
    pub fn cycles(&self, unit: usize, symbol: impl Fn(char) -> bool) -> u64 {
        let rows = self.rows.iter().filter(|((u, _), _)| *u == unit);
        rows.map(|(_, row)| row.chars().filter(|&c| symbol(c)).count() as u64).sum()
    }
}

/// What does not change from cycle to cycle, and which batches have been written.
pub struct Frame<'a> {
    pub machine: &'a Machine,
    pub design: &'a ResolvedUnits,
    pub workload: &'a FrameWorkload,
    pub plan: &'a Plan,
    pub given: FrameContext<'a>,
    /// What the CCUs do.
    work: Work,
    waits_for_lists: bool,
    /// What chunks take, by tile, where units are followed through sub-tiles.
    runs: Option<Vec<Vec<ChunkRun>>>,
    written: BTreeMap<usize, u64>,
    /// Cycle from which on a second pass over the records may begin.
    second_pass: u64,
}

impl Frame<'_> {
    /// Whether the first `splats` splats have been written, in batches without a gap.
    fn is_binned(&self, splats: u32) -> bool {
        let gapless = (0..).map_while(|batch| self.written.get(&batch));
        !self.waits_for_lists || gapless.sum::<u64>() >= u64::from(splats)
    }
}

/// No frame of these tests takes so many cycles: what does waits for something that never comes.
const LONGEST: u64 = 1 << 21;

/// Steps through a frame.
pub fn run(workload: &FrameWorkload, machine: &Machine, given: FrameContext) -> Seen {
    let mut design = ResolvedUnits::for_frame(machine, workload);
    if let Some(calibration) = given.calibration {
        design.dram = calibration.dram();
    }
    let points = workload.counters.points;
    let first = if given.derived { Vec::new() } else { FirstUnit::of(machine, points) };
    let given = FrameContext { first: &first, ..given };
    let plan = Plan::new(workload, machine, &design, &given);
    let waits_for_lists = machine.tiles().schedule.overlap == Overlap::Tiles;
    let (written, second_pass) = (BTreeMap::new(), u64::MAX);
    let vru = &machine.tiles().vru;
    let runs = (vru.implementation != VruImpl::Serial || vru.stop_latency > 0).then(|| {
        let tiles = 0..workload.tiles.len();
        let of = |tile| match vru.implementation.needs_pixels() {
            true => lanes::runs(workload, vru, tile),
            false => subtiles::runs(workload, &design, tile),
        };
        tiles.map(of).collect()
    });
    let mut frame = Frame {
        machine,
        design: &design,
        workload,
        plan: &plan,
        given,
        work: Work::new(workload, &design.ccu, &given),
        waits_for_lists,
        runs,
        written,
        second_pass,
    };
    let layout = Layout::new(workload, &design, &plan, &given);
    let step = Step::new(machine, &design, workload, &plan, given.sums);
    let is_behind = step.as_ref().is_some_and(Step::is_behind);
    let n_cores = vru.cores as usize;
    let unit_of = |step, core| Gru::new(step, core, &layout);
    let mut grus: Vec<Gru> =
        step.iter().flat_map(|step| (0..n_cores).map(move |core| unit_of(step, core))).collect();
    let mut known = known(machine, &frame, &layout);
    let places = layout.first().first().copied();
    let mut traversal = places
        .and_then(|places| levels(&machine.tiles().levels, points, places, AccessPattern::Run));
    let mut memory = oracle_memory::Memory::new(layout, &STREAMS, machine, design.dram);
    let mut seen = Seen { has_levels: traversal.is_some(), ..Seen::default() };
    let mut converters: Vec<Converter> =
        (0..machine.tiles().ccu.units).map(|_| Converter::new()).collect();
    let mut cores: Vec<Core> = (0..n_cores).map(Core::new).collect();
    let (mut next_batch, mut next_job, mut now) = (0, 0, 0);
    // Which Gaussians there are is not known before the levels have been traversed.
    while let Some(unit) = &mut traversal {
        unit.step(now, &mut memory);
        if unit.is_done() {
            break;
        }
        seen.put_others(machine);
        if machine.tiles().pixels.source == PixelSource::Warped {
            seen.put(PXU, 0, '.');
        }
        // In place of what others say of it.
        seen.rows.entry((LTU, 0)).or_default().pop();
        seen.put_levels(unit.symbol());
        seen.put_idle(GRU, grus.len());
        unit.tick();
        memory.tick(now);
        now += 1;
    }
    // What has to be rendered is not known before all pixels have been moved.
    if machine.tiles().pixels.source == PixelSource::Warped
        && let Some(unit) = &mut known
    {
        loop {
            unit.step(now, &mut memory);
            if unit.is_done() {
                break;
            }
            seen.put_others(machine);
            seen.put(PXU, 0, unit.symbol());
            seen.put_idle(GRU, grus.len());
            unit.tick();
            memory.tick(now);
            now += 1;
        }
    }
    let overlaps = machine.tiles().schedule.overlap != Overlap::None;
    let (mut is_binned, mut can_render, mut rendered) = (false, overlaps, None);
    loop {
        for converter in &mut converters {
            converter.step(now, &mut frame, &mut next_batch, &mut memory);
        }
        let is_counted = next_batch == frame.work.first_pass;
        if is_counted && frame.second_pass == u64::MAX && converters.iter().all(Converter::is_done)
        {
            frame.second_pass = now + (workload.tiles.len() as u64).max(1);
        }
        let is_over = next_batch == frame.work.batches.len();
        if !is_binned && is_over && converters.iter().all(Converter::is_done) {
            (is_binned, can_render) = (true, true);
            seen.preprocessing_end = now;
        }
        if can_render {
            let mut behind = grus.iter_mut().filter(|_| is_behind);
            for core in &mut cores {
                core.step(now, &frame, &mut next_job, &mut memory, behind.next());
            }
            if let Some(unit) = &mut known {
                unit.step(now, &mut memory);
            }
            for unit in grus.iter_mut().filter(|_| is_behind) {
                unit.step(now, &mut memory);
            }
            let done = grus.iter().map(Gru::done).sum::<usize>();
            let waits = is_behind && done < workload.tiles.len();
            grus.iter_mut().for_each(|unit| unit.waits_for_tiles = waits);
        }
        let cores_done = cores.iter().all(|core| core.is_done(now, &frame, next_job, &memory));
        if is_binned && cores_done && known.as_ref().is_none_or(Mover::is_done) {
            rendered.get_or_insert(now);
            if grus.iter().all(|unit| !is_behind || unit.is_done()) {
                break;
            }
        }
        for (i, converter) in converters.iter_mut().enumerate() {
            seen.put(0, i, converter.symbol());
            converter.tick();
        }
        for (i, core) in cores.iter_mut().enumerate() {
            let symbols = if can_render { core.symbols(now, &frame, &memory) } else { ['.'; 4] };
            seen.put_core(machine, i, symbols);
            core.tick(machine);
        }
        if let Some(unit) = &mut known {
            seen.put(PXU, 0, unit.symbol());
            unit.tick();
        }
        seen.put_levels('.');
        for (i, unit) in grus.iter_mut().enumerate() {
            seen.put(GRU, i, unit.symbol());
            unit.tick();
        }
        memory.tick(now);
        now += 1;
        assert!(now < LONGEST, "nothing goes on: {next_batch} batches, {next_job} jobs");
    }
    seen.rendered = rendered.expect("it was rendered");
    seen.step = step.as_ref().map(|_| {
        StepPart::ALL.map(|part| match (is_behind, part) {
            (true, StepPart::Loss) => seen.rendered,
            (true, StepPart::Reverse) => now,
            _ => {
                behind_frame(part, &mut grus, machine, &mut memory, &mut seen, &mut now);
                now
            }
        })
    });
    seen.frame = now;
    (seen.requests, seen.read, seen.write) = (memory.requests, memory.read, memory.written);
    seen
}

/// A part of a step behind its frame, in which only gradient units work.
fn behind_frame(
    part: StepPart,
    grus: &mut [Gru],
    machine: &Machine,
    memory: &mut Memory,
    seen: &mut Seen,
    now: &mut u64,
) {
    grus.iter_mut().for_each(|unit| unit.begin(part, &memory.layout));
    loop {
        grus.iter_mut().for_each(|unit| unit.step(*now, memory));
        if grus.iter().all(Gru::is_done) {
            return;
        }
        seen.put_others(machine);
        for (i, unit) in grus.iter_mut().enumerate() {
            seen.put(GRU, i, unit.symbol());
            unit.tick();
        }
        memory.tick(*now);
        *now += 1;
        assert!(*now < LONGEST, "no end of {part:?}");
    }
}

/// The unit that knows pixels, with what it has to move: block by block, one behind the other.
fn known(machine: &Machine, frame: &Frame, layout: &Layout) -> Option<Mover<AccessPattern>> {
    let spec = &machine.tiles().pixels;
    if !matches!(spec.source, PixelSource::Warped | PixelSource::Cached) {
        return None;
    }
    let mut unit = Mover::new(["known-in", "known-out"], spec.per_cycle.into());
    let mut places = layout.known();
    for block in frame.given.pixels.map_or(&[][..], |pixels| &pixels.blocks) {
        let bytes = [block.read, block.write];
        let [read, write] = [0, 1].map(|way| {
            let address = places[way];
            places[way] += bytes[way];
            (bytes[way], AccessPattern::Run(AddressRange { address, bytes: bytes[way] }))
        });
        unit.push(Block { items: block.items, read, write });
    }
    Some(unit)
}

/// The last digit of an item.
fn digit(item: usize) -> char {
    char::from(b'0' + (item % 10) as u8)
}
