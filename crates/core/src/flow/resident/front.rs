//! The units of the front.
//!
//! Batches are taken in storage order. In a cycle a unit does this, in this order: it frees the
//! room of results that have been written; it ends the batch that it works on, whose records then
//! leave their buffer; it begins to write the results of batches that it ended `latency` cycles
//! ago; it asks for the colours of batches whose records are there, oldest first; it begins the
//! oldest batch that it has not begun, if all of that is there and the results have room; and it
//! asks for the next batch, if it has fewer than `queue` and there is room for all of its records,
//! colours too, however few are needed.
//!
//! Where Gaussians are converted late (`front.lazy`), a batch is only culled: positions are read,
//! and list entries written. Behind that the units convert, all together, the chunks of the
//! [engine](super::engine).

use std::collections::VecDeque;

use super::RegionShared;
use super::layout::Place;
use super::stages::{FRONT, RECORDS, RESULTS, WAITS_RECORDS};
use super::work::RecordCounts;
use crate::kernel::BufferUse;
use crate::kernel::buffer::{BufferAllocator, usage};
use crate::kernel::ledger::Account;
use crate::kernel::memory::{Arrival, NEVER};
use crate::kernel::timeline::{Observer, State};
use crate::stage::Stall;

/// What a unit has to do for a batch.
#[derive(Debug, Clone, Copy)]
struct FrontBatch {
    first: u64,
    records: u64,
    before: RecordCounts,
    counts: RecordCounts,
}

/// Where a batch is.
#[derive(Debug, Clone, Copy)]
enum BatchAt {
    /// Its records, or its colours, are on their way.
    Read { arrival: Arrival, colours: bool },
    /// It is worked on until this cycle.
    Work(u64),
    /// Its results come out in this cycle.
    Leaves(u64),
    /// They are on their way.
    Write(Arrival),
}

#[derive(Debug)]
struct Held {
    batch: FrontBatch,
    at: BatchAt,
    /// Bytes of records in the buffer.
    input: u64,
    /// Bytes of results.
    output: u64,
}

/// A unit.
#[derive(Debug)]
pub struct FrontUnit {
    owner: u32,
    held: VecDeque<Held>,
    input: BufferAllocator,
    output: BufferAllocator,
    pub account: Account,
    pub end: u64,
}

impl FrontUnit {
    pub fn new(owner: u32, input: u64, output: u64) -> FrontUnit {
        FrontUnit {
            owner,
            held: VecDeque::new(),
            input: BufferAllocator::new(input),
            output: BufferAllocator::new(output),
            account: Account::new(FRONT, owner),
            end: 0,
        }
    }

    /// The buffers of all units.
    pub fn buffers(all: &[FrontUnit]) -> [BufferUse; 2] {
        [
            usage(RECORDS, all.iter().map(|unit| &unit.input)),
            usage(RESULTS, all.iter().map(|unit| &unit.output)),
        ]
    }

    /// The same where chunks were converted behind the front's own phase.
    pub fn convert(&mut self, chunks: &[[u64; 2]], end: u64, observer: &mut impl Observer) {
        for (&[from, to], n) in chunks.iter().zip(0..) {
            self.account.up_to(from, observer);
            self.account.is(State::Busy(n));
            self.account.up_to(to, observer);
            self.account.is(State::Idle);
        }
        self.account.up_to(end, observer);
    }

    pub fn step<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> u64 {
        self.account.up_to(now, shared.observer);
        self.finish(now, shared);
        self.read_on(now, shared);
        self.begin(now, shared);
        let asked = self.ask(now, shared);
        let state = self.state(now, shared);
        self.account.is(state);
        if self.held.is_empty() && shared.next_record >= shared.frame.counters.points {
            return NEVER;
        }
        if asked { now + 1 } else { self.wake(now, shared) }
    }

    fn finish<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) {
        let FrontUnit { held, output, end, .. } = self;
        held.retain(|one| match one.at {
            BatchAt::Write(arrival) if shared.memory.at(arrival) <= now => {
                output.release(now, one.output);
                *end = (*end).max(now);
                false
            }
            _ => true,
        });
        for one in &mut self.held {
            if let BatchAt::Work(until) = one.at
                && until <= now
            {
                self.input.release(now, one.input);
                one.at = BatchAt::Leaves(until + u64::from(shared.machine.front.latency));
            }
            // Behind the end of the batch, because with a latency of 0 both are in one cycle.
            if let BatchAt::Leaves(cycle) = one.at
                && cycle <= now
            {
                let FrontBatch { before, counts, .. } = one.batch;
                let lazy = shared.machine.front.lazy;
                let place = Place::Results {
                    first: before.splats,
                    splats: if lazy { 0 } else { counts.splats },
                    entry: before.entries,
                    entries: counts.entries,
                };
                one.at = BatchAt::Write(shared.issue(
                    now,
                    self.owner,
                    shared.streams.results,
                    one.output,
                    place,
                ));
            }
        }
    }

    /// Asks for colours.
    fn read_on<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) {
        for one in &mut self.held {
            let BatchAt::Read { arrival, colours: false } = one.at else { continue };
            // Colours are asked for in the order of batches, or a younger one could be served
            // first.
            if shared.memory.at(arrival) > now {
                break;
            }
            let FrontBatch { before, counts, .. } = one.batch;
            let bytes = match shared.machine.front.lazy {
                true => 0,
                false => counts.splats * shared.machine.gaussian.colour.0,
            };
            let place = Place::Shades { first: before.splats, splats: counts.splats };
            let arrival = match bytes {
                0 => Arrival::NOW,
                _ => shared.issue(now, self.owner, shared.streams.shades, bytes, place),
            };
            one.at = BatchAt::Read { arrival, colours: true };
        }
    }

    fn begin<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) {
        if self.held.iter().any(|one| matches!(one.at, BatchAt::Work(_))) {
            return;
        }
        let next = self.held.iter_mut().find(|one| matches!(one.at, BatchAt::Read { .. }));
        let Some(one) = next else { return };
        let BatchAt::Read { arrival, colours: true } = one.at else { return };
        if shared.memory.at(arrival) > now || !self.output.admits(one.output) {
            return;
        }
        self.output.fill(now, one.output);
        let FrontBatch { records, counts, .. } = one.batch;
        let spec = &shared.machine.front;
        let cycles = match spec.lazy {
            false => spec.cycles(records, &counts),
            true => spec.cycles(records, &RecordCounts { survivors: 0, splats: 0, ..counts }),
        };
        one.at = BatchAt::Work(now + cycles);
    }

    /// Asks for the next batch; whether it did.
    fn ask<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let (machine, points) = (shared.machine, shared.frame.counters.points);
        let first = shared.next_record;
        if first >= points || self.held.len() >= machine.front.queue as usize {
            return false;
        }
        let records = u64::from(machine.front.batch).min(points - first);
        let g = &machine.gaussian;
        let each = g.position.0 + if machine.front.lazy { 0 } else { g.shape.0 };
        let bytes = records * each;
        // Room for all colours: how many are needed is known only when positions are there.
        let input = bytes + if machine.front.lazy { 0 } else { records * g.colour.0 };
        if !self.input.admits(input) {
            return false;
        }
        shared.next_record += records;
        let (before, after) = (shared.frame.up_to(first), shared.frame.up_to(first + records));
        let counts = RecordCounts {
            survivors: after.survivors - before.survivors,
            splats: after.splats - before.splats,
            entries: after.entries - before.entries,
            rows: after.rows - before.rows,
        };
        let features = if machine.front.lazy { 0 } else { counts.splats * g.feature.0 };
        let output = features + counts.entries * g.entry.0;
        let batch = FrontBatch { first, records, before, counts };
        let place = Place::Batch { first: batch.first, records };
        let arrival = shared.issue(now, self.owner, shared.streams.records, bytes, place);
        self.input.fill(now, input);
        let at = BatchAt::Read { arrival, colours: false };
        self.held.push_back(Held { batch, at, input, output });
        true
    }

    fn state<O: Observer>(&self, now: u64, shared: &RegionShared<O>) -> State {
        for one in &self.held {
            match one.at {
                BatchAt::Work(_) => {
                    let batch = one.batch.first / u64::from(shared.machine.front.batch);
                    return State::Busy(batch as u32);
                }
                BatchAt::Read { arrival, colours } => {
                    let is_here = colours && shared.memory.at(arrival) <= now;
                    return State::Stalled(if is_here { Stall::OUTPUT } else { WAITS_RECORDS });
                }
                BatchAt::Leaves(_) | BatchAt::Write(_) => {}
            }
        }
        State::Idle
    }

    fn wake<O: Observer>(&self, now: u64, shared: &RegionShared<O>) -> u64 {
        let next = |one: &Held| match one.at {
            BatchAt::Read { arrival, .. } | BatchAt::Write(arrival) => shared.memory.at(arrival),
            BatchAt::Work(cycle) | BatchAt::Leaves(cycle) => cycle,
        };
        self.held.iter().map(next).filter(|&cycle| cycle > now).min().unwrap_or(NEVER)
    }
}
