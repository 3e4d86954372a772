//! Decides when: finite buffers between the units, several cores, one shared DRAM.
//!
//! The frame has two phases with a barrier between them, because a tile's list is complete only
//! when the last Gaussian has been binned and written (A28).
//!
//! **Preprocessing.** Batches wait in storage order. A CCU takes the next batch when its share of
//! the input buffer has room for a full one, at most one a cycle, and issues its first read at
//! once; when that has arrived it issues the second. The CCU works on its batches in order. A batch
//! enters when all its data is there and the tile-list buffer has room for what it will write; the
//! input room is free again when the last record has entered. `latency` cycles later the batch is
//! written to DRAM, and its tile-list room is free when the write has left. The phase ends when all
//! writes have left.
//!
//! **Tiles.** Tiles wait in raster order. Every core is a chain of three places for tiles, and one
//! queue of chunks (`core`): its front takes the next tile as soon as it is empty, reads the list
//! and runs the QSU passes; its middle sends the chunks of one tile, in order, into the feature
//! buffer; its VRU renders the chunks in order and writes the pixels.
//!
//! **Ties.** Within a cycle, CCUs or cores act in the order of their number, which decides who gets
//! the next batch or tile, and whose DRAM request is first.
//!
//! Events are batches and chunks, never cycles or splats. `tests/it/pipeline/oracle.rs` steps
//! through the same rules cycle by cycle.

mod core;
mod front;
mod ledger;
mod preprocess;

use self::core::Core;
use self::ledger::Ledger;
use self::preprocess::Converter;
use super::batch::Batches;
use super::bsu::Bsu;
use super::ccu::Ccu;
use super::design::Design;
use super::dram::Channel;
use super::qsu::Qsu;
use super::timeline::Observer;
use super::traffic::Traffic;
use super::vru::Vru;
use super::{FrameTiming, Histogram, Stall, Unit, UnitCycles};
use crate::workload::FrameWorkload;

/// No event is pending.
const NEVER: u64 = u64::MAX;

/// What CCUs or cores share.
struct Shared<'a, O> {
    design: &'a Design,
    workload: &'a FrameWorkload,
    channel: Channel,
    batches: Batches,
    next_batch: u32,
    next_tile: u32,
    observer: &'a mut O,
}

/// Something that acts at events.
trait Agent<O> {
    /// Does everything that can be done in cycle `now`; returns when there may be more to do.
    fn step(&mut self, now: u64, shared: &mut Shared<O>) -> u64;
    /// Accounts for the cycles up to `now`, in which nothing changed.
    fn account(&mut self, now: u64, observer: &mut O);
    /// The cycle in which everything that it has started is done.
    fn end(&self) -> u64;
}

/// Runs a phase from cycle `start` until nobody has anything to do; returns its end.
fn drive<O, A: Agent<O>>(agents: &mut [A], start: u64, shared: &mut Shared<O>) -> u64 {
    let mut next = vec![start; agents.len()];
    let mut now = start;
    while now != NEVER {
        let mut soonest = NEVER;
        for (agent, wake) in agents.iter_mut().zip(&mut next) {
            if *wake == now {
                agent.account(now, shared.observer);
                *wake = agent.step(now, shared);
                debug_assert!(*wake > now, "an event at {wake} after cycle {now}");
            }
            soonest = soonest.min(*wake);
        }
        now = soonest;
    }
    agents.iter().map(A::end).max().unwrap_or(start).max(start)
}

/// Takes a frame through the pipeline.
pub fn run<O: Observer>(
    workload: &FrameWorkload,
    design: &Design,
    observer: &mut O,
) -> (FrameTiming, Traffic) {
    let mut shared = Shared {
        design,
        workload,
        channel: Channel::new(design.dram),
        batches: Batches::new(workload, design.ccu.batch),
        next_batch: 0,
        next_tile: 0,
        observer,
    };
    let mut converters: Vec<Converter> =
        (0..design.ccu.spec.units).map(|unit| Converter::new(unit, design)).collect();
    let preprocessing_end = drive(&mut converters, 0, &mut shared);
    let mut cores: Vec<Core> =
        (0..design.vru.spec.cores).map(|core| Core::new(core, design)).collect();
    for core in &mut cores {
        core.account(preprocessing_end, shared.observer);
    }
    let frame = drive(&mut cores, preprocessing_end, &mut shared);
    for converter in &mut converters {
        converter.account(frame, shared.observer);
    }
    for core in &mut cores {
        core.account(frame, shared.observer);
    }
    let units = vec![
        sum(Ccu::NAME, 1, converters.iter().map(|c| &c.ledger)),
        sum(Qsu::NAME, design.qsu.spec.qsu_per_core, cores.iter().map(|c| &c.qsu)),
        sum(Bsu::NAME, design.bsu.spec.bsu_per_core, cores.iter().map(|c| &c.bsu)),
        sum(Vru::NAME, design.vru.spec.units_per_core, cores.iter().map(|c| &c.vru)),
    ];
    let timing = FrameTiming {
        frame,
        preprocessing_end,
        units,
        dram: shared.channel.usage(),
        buffers: Vec::new(),
        tile_cycles: Histogram::EMPTY,
    };
    (timing, shared.channel.traffic())
}

/// Adds the ledgers of gangs of `gang` units each.
fn sum<'a>(unit: &'static str, gang: u32, ledgers: impl Iterator<Item = &'a Ledger>) -> UnitCycles {
    let mut sum =
        UnitCycles { unit, instances: 0, busy: 0, stalls: [0; Stall::ALL.len()], idle: 0 };
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
