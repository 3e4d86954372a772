//! Decides when: finite buffers between the units, several cores, one shared DRAM.
//!
//! **Preprocessing.** Batches wait in storage order. A CCU takes the next batch when it has fewer
//! than `ccu.queue` and its share of the input buffer has room for a full one, at most one a
//! cycle, and issues its first read at once; when that has arrived it issues the second. The CCU
//! works on its batches in order. A batch enters when all its data is there and the tile-list
//! buffer has room for what it will write; the input room is free again when the last record has
//! entered. `latency` cycles later the batch is written to DRAM, and its tile-list room is free
//! when the write has left. Preprocessing ends when all writes have left.
//!
//! **Tiles.** Jobs (`schedule`) wait in their order. Every core is a chain of three places for
//! jobs, and one queue of chunks (`core`): its front takes the next job as soon as it has place,
//! reads the list and runs the QSU passes; its middle sends the chunks of one job, in order, into
//! the feature buffer; its VRU renders the chunks in order and writes the pixels.
//!
//! **Overlap.** A tile's list is complete only when its last Gaussian has been binned and written,
//! so with `schedule.overlap = "none"` cores begin when preprocessing has ended (A28). With `tiles`
//! a list is read as soon as it is complete itself. With `frames` cores begin at once: they work on
//! this frame while the CCUs work on the next, which is taken to be like this one (A81).
//!
//! **Ties.** Within a cycle, CCUs and then cores act in the order of their number, which decides
//! who gets the next batch or job, and whose DRAM request is first.
//!
//! Events are batches and chunks, never cycles or splats. `tests/it/pipeline/oracle.rs` steps
//! through the same rules cycle by cycle.

mod binned;
mod core;
mod front;
mod ledger;
pub mod memo;
mod middle;
mod preprocess;
mod turns;

use std::ops::Range;

use self::binned::Binned;
use self::core::Core;
use self::ledger::Ledger;
use self::memo::Memo;
use self::preprocess::Converter;
use self::turns::Turns;
use super::batch::Batches;
use super::buffer::{Room, usage};
use super::design::Design;
use super::layout::{Layout, Span};
use super::machine::Overlap;
use super::memory::{Arrival, Memory, NEVER, Request};
use super::schedule::{Job, Plan};
use super::timeline::Observer;
use super::traffic::{Traffic, pairs_written};
use super::{BufferUse, FrameTiming, Given, Histogram, Machine, Stall, UnitCycles};
use crate::action::{ActionCounts, Buffer, Stage, UnitKind};
use crate::workload::FrameWorkload;

/// What CCUs and cores share.
struct Shared<'a, O> {
    design: &'a Design,
    workload: &'a FrameWorkload,
    plan: &'a Plan,
    given: Given<'a>,
    memory: Memory<'a>,
    /// Whether the requests of a CCU are done in order, and nobody waits for their cycles.
    in_order: bool,
    batches: Batches<'a>,
    next_batch: u32,
    next_job: u32,
    binned: Binned,
    observer: &'a mut O,
}

impl<O: Observer> Shared<'_, O> {
    #[inline]
    fn read(
        &mut self,
        now: u64,
        owner: u32,
        stage: Stage,
        bytes: u64,
        span: impl FnOnce(&Layout) -> Span,
    ) -> Arrival {
        let request = Request { owner, stage, write: false, bytes };
        self.memory.issue(now, request, span, self.observer)
    }

    #[inline]
    fn write(
        &mut self,
        now: u64,
        owner: u32,
        stage: Stage,
        bytes: u64,
        span: impl FnOnce(&Layout) -> Span,
    ) -> Arrival {
        let request = Request { owner, stage, write: true, bytes };
        self.memory.issue(now, request, span, self.observer)
    }
}

impl<O> Shared<'_, O> {
    /// Whether the pipeline of a VRU drains behind this tile: behind the last one of a job that has
    /// chunks at all.
    fn drains(&self, job: &Job, tile: u32) -> bool {
        let tiles = self.plan.tiles_of(job);
        let is_filled = |t: &&u32| self.workload.tiles[**t as usize].chunks > 0;
        !self.design.vru.spec.tile_overlap && tiles.iter().rfind(is_filled) == Some(&tile)
    }
}

/// Everybody who acts at events: CCUs, then cores.
struct Agents {
    converters: Vec<Converter>,
    cores: Vec<Core>,
}

impl Agents {
    fn new(design: &Design) -> Self {
        let units = design.ccu.spec.units;
        let cores = 0..design.vru.spec.cores;
        Self {
            converters: (0..units).map(|unit| Converter::new(unit, unit, design)).collect(),
            cores: cores.map(|core| Core::new(core, units + core, design)).collect(),
        }
    }

    /// Lets `agents` act from cycle `start` on, until nobody has anything to do.
    fn drive<O: Observer>(&mut self, agents: Range<usize>, start: u64, shared: &mut Shared<O>) {
        let mut turns = Turns::new(&agents, start);
        let mut now = start;
        while now != NEVER {
            while turns.soonest() == now {
                let agent = turns.next();
                let wake = self.step(agent, now, shared);
                debug_assert!(wake > now, "no event after cycle {now}");
                turns.set(agent, wake);
                if shared.binned.take_news() {
                    // Cores act after CCUs in the same cycle.
                    (self.converters.len()..agents.end).for_each(|core| turns.set(core, now));
                }
            }
            while let Some((cycle, owner)) = shared.memory.advance(turns.soonest()) {
                turns.hasten(owner as usize, cycle.max(now + 1));
            }
            now = turns.soonest();
        }
    }

    #[inline]
    fn step<O: Observer>(&mut self, agent: usize, now: u64, shared: &mut Shared<O>) -> u64 {
        let units = self.converters.len();
        match self.converters.get_mut(agent) {
            Some(converter) => converter.step(now, shared),
            None => {
                let core = &mut self.cores[agent - units];
                core.account(now, shared.observer);
                core.step(now, shared)
            }
        }
    }

    fn account(&mut self, now: u64, observer: &mut impl Observer) {
        self.converters.iter_mut().for_each(|c| c.account(now, observer));
        self.cores.iter_mut().for_each(|c| c.account(now, observer));
    }

    fn rooms(&self) -> Vec<BufferUse> {
        let of = |c: &'_ Core, buffer| -> Room {
            match buffer {
                Buffer::Sorting => c.front.keys.clone(),
                Buffer::Feature => c.features.clone(),
                _ => c.pixels.clone(),
            }
        };
        let cores = |buffer| {
            let rooms: Vec<Room> = self.cores.iter().map(|c| of(c, buffer)).collect();
            usage(buffer, rooms.iter())
        };
        vec![
            usage(Buffer::GaussianIn, self.converters.iter().map(|c| &c.input)),
            usage(Buffer::TileList, self.converters.iter().map(|c| &c.output)),
            cores(Buffer::Sorting),
            cores(Buffer::Feature),
            cores(Buffer::PixelOut),
        ]
    }
}

/// What a frame did.
#[derive(Debug)]
pub struct Outcome {
    /// When.
    pub timing: FrameTiming,
    /// DRAM bytes, speculation included.
    pub traffic: Traffic,
    /// What was done that nobody needed.
    pub speculation: ActionCounts,
}

/// Takes a frame through the pipeline. `memo` is of this frame, and never given together with an
/// observer who wants to see preprocessing.
pub fn run<O: Observer>(
    workload: &FrameWorkload,
    machine: &Machine,
    design: &Design,
    plan: &Plan,
    given: Given,
    memo: Option<&Memo>,
    observer: &mut O,
) -> Outcome {
    let overlap = machine.schedule.overlap;
    let memory = Memory::new(workload, Layout::new(workload, design), machine, design.dram);
    let mut shared = Shared {
        design,
        workload,
        plan,
        given,
        in_order: memory.keeps_order() && overlap != Overlap::Tiles,
        memory,
        batches: Batches::new(workload, design.ccu.batch, pairs_written(workload, &given)),
        next_batch: 0,
        next_job: 0,
        binned: Binned::new(overlap == Overlap::Tiles),
        observer,
    };
    let mut agents = Agents::new(design);
    let (units, all) = (agents.converters.len(), agents.converters.len() + agents.cores.len());
    let preprocessing_end = match overlap {
        Overlap::None => {
            let memo = memo.filter(|_| memo::is_apart(machine, &shared));
            memo::preprocess(&mut agents, &mut shared, memo);
            let end = agents.converters.iter().map(|c| c.end).max().unwrap_or(0);
            agents.cores.iter_mut().for_each(|core| core.account(end, shared.observer));
            agents.drive(units..all, end, &mut shared);
            end
        }
        Overlap::Tiles | Overlap::Frames => {
            agents.drive(0..all, 0, &mut shared);
            agents.converters.iter().map(|c| c.end).max().unwrap_or(0)
        }
    };
    let frame = agents.cores.iter().map(|c| c.end).fold(preprocessing_end, u64::max);
    let shared = finish(&mut agents, frame, shared);
    outcome(&agents, preprocessing_end, frame, &shared)
}

/// Closes all accounts at the end of the frame.
fn finish<'a, O: Observer>(
    agents: &mut Agents,
    frame: u64,
    shared: Shared<'a, O>,
) -> Shared<'a, O> {
    agents.account(frame, shared.observer);
    let ccu = &shared.design.ccu;
    agents.converters.iter_mut().for_each(|c| c.close(frame, |batch| ccu.written(batch)));
    agents.cores.iter_mut().for_each(|core| core.close(frame));
    shared
}

fn outcome<O>(agents: &Agents, preprocessing_end: u64, frame: u64, shared: &Shared<O>) -> Outcome {
    let (design, cores) = (shared.design, &agents.cores);
    let units = [
        sum(UnitKind::Ccu, 1, agents.converters.iter().map(|c| &c.ledger)),
        sum(UnitKind::Qsu, design.qsu.spec.qsu_per_core, cores.iter().map(|c| &c.qsu)),
        sum(UnitKind::Bsu, design.bsu.spec.bsu_per_core, cores.iter().map(|c| &c.bsu)),
        sum(UnitKind::Vru, design.vru.spec.units_per_core, cores.iter().map(|c| &c.vru)),
    ];
    let mut speculation = ActionCounts::default();
    let mut tile_cycles = Histogram::EMPTY;
    for core in cores {
        speculation.add(&core.speculation);
        tile_cycles.add(&core.tile_cycles);
    }
    let (dram, buffers) = (shared.memory.usage(), agents.rooms());
    let timing = FrameTiming { frame, preprocessing_end, units, dram, buffers, tile_cycles };
    Outcome { timing, traffic: shared.memory.traffic(), speculation }
}

/// Adds the ledgers of gangs of `gang` units each.
fn sum<'a>(unit: UnitKind, gang: u32, ledgers: impl Iterator<Item = &'a Ledger>) -> UnitCycles {
    let stalls = [0; Stall::ALL.len()];
    let mut sum = UnitCycles { unit, instances: 0, busy: 0, stalls, idle: 0 };
    for ledger in ledgers {
        sum.instances += gang;
        sum.busy += ledger.busy * u64::from(gang);
        sum.idle += ledger.idle * u64::from(gang);
        for (total, cycles) in sum.stalls.iter_mut().zip(ledger.stalls) {
            *total += cycles * u64::from(gang);
        }
    }
    sum
}
