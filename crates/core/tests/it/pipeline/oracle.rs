//! The machine once more, cycle by cycle, written from the rules in words (module documentation of
//! `flow::tile_wise::pipeline` and its parts) and not from the recurrences: nothing is predicted,
//! every unit counts down, the memory moves tick by tick. Only the cost of a piece of work is
//! shared.

mod converter;
mod core;
pub mod subtiles;

use std::collections::BTreeMap;

use powergs_core::flow::tile_wise::layout::Layout;
use powergs_core::flow::tile_wise::schedule::Plan;
use powergs_core::flow::tile_wise::subtiles::ChunkRun;
use powergs_core::flow::tile_wise::{Fetch, Overlap, VruImpl};
use powergs_core::flow::tile_wise::{FrameContext, ResolvedUnits, STREAMS};
use powergs_core::machine::Machine;
use powergs_core::workload::FrameWorkload;

use self::converter::Converter;
use self::core::Core;
use crate::oracle_memory;

/// The memory of a frame.
type Memory<'a> = oracle_memory::Memory<Layout<'a>>;

/// What the oracle saw.
#[derive(Debug, Default)]
pub struct Seen {
    /// One character per cycle by unit and instance, as `Timeline::draw`.
    pub rows: BTreeMap<(usize, usize), String>,
    pub preprocessing_end: u64,
    pub frame: u64,
    pub requests: u64,
    pub read: [u64; 3],
    pub write: [u64; 3],
}

impl Seen {
    pub fn draw(&self) -> String {
        let names = ["ccu", "qsu", "bsu", "vru", "colour"];
        self.rows.iter().map(|((u, i), row)| format!("{}{i} |{row}\n", names[*u])).collect()
    }

    fn put(&mut self, unit: usize, instance: usize, symbol: char) {
        self.rows.entry((unit, instance)).or_default().push(symbol);
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

/// Steps through a frame.
pub fn run(workload: &FrameWorkload, machine: &Machine, given: FrameContext) -> Seen {
    let mut design = ResolvedUnits::for_frame(machine, workload);
    if let Some(calibration) = given.calibration {
        design.dram = calibration.dram();
    }
    let plan = Plan::new(workload, machine, &design, &given);
    let waits_for_lists = machine.tiles().schedule.overlap == Overlap::Tiles;
    let (written, second_pass) = (BTreeMap::new(), u64::MAX);
    let vru = &machine.tiles().vru;
    let runs = (vru.implementation != VruImpl::Serial || vru.stop_latency > 0).then(|| {
        let tiles = 0..workload.tiles.len();
        tiles.map(|tile| subtiles::runs(workload, &design, tile)).collect()
    });
    let mut frame = Frame {
        machine,
        design: &design,
        workload,
        plan: &plan,
        given,
        waits_for_lists,
        runs,
        written,
        second_pass,
    };
    let layout = Layout::new(workload, &design, &plan, &given);
    let mut memory = oracle_memory::Memory::new(layout, &STREAMS, machine, design.dram);
    let mut seen = Seen::default();
    let mut converters: Vec<Converter> =
        (0..machine.tiles().ccu.units).map(|_| Converter::new()).collect();
    let mut cores: Vec<Core> = (0..machine.tiles().vru.cores as usize).map(Core::new).collect();
    let (mut next_batch, mut next_job, mut now) = (0, 0, 0);
    let (mut is_binned, mut can_render) =
        (false, machine.tiles().schedule.overlap != Overlap::None);
    loop {
        for converter in &mut converters {
            converter.step(now, &mut frame, &mut next_batch, &mut memory);
        }
        let is_counted = next_batch == converter::batches(&frame) / 2;
        if is_counted && frame.second_pass == u64::MAX && converters.iter().all(Converter::is_done)
        {
            frame.second_pass = now + (workload.tiles.len() as u64).max(1);
        }
        let is_over = next_batch == converter::batches(&frame);
        if !is_binned && is_over && converters.iter().all(Converter::is_done) {
            (is_binned, can_render) = (true, true);
            seen.preprocessing_end = now;
        }
        if can_render {
            for core in &mut cores {
                core.step(now, &frame, &mut next_job, &mut memory);
            }
        }
        if is_binned && cores.iter().all(|core| core.is_done(now, &frame, next_job, &memory)) {
            break;
        }
        for (i, converter) in converters.iter_mut().enumerate() {
            seen.put(0, i, converter.symbol());
            converter.tick();
        }
        for (i, core) in cores.iter_mut().enumerate() {
            let symbols = if can_render { core.symbols(now, &frame, &memory) } else { ['.'; 4] };
            let units = 1..if machine.tiles().ccu.fetch == Fetch::LazyColour { 5 } else { 4 };
            units.for_each(|unit| seen.put(unit, i, symbols[unit - 1]));
            core.tick(machine);
        }
        memory.tick(now);
        now += 1;
    }
    seen.frame = now;
    (seen.requests, seen.read, seen.write) = (memory.requests, memory.read, memory.written);
    seen
}

/// The last digit of an item.
fn digit(item: usize) -> char {
    char::from(b'0' + (item % 10) as u8)
}
