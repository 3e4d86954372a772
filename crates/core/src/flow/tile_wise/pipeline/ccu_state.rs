//! CCU state: the batches that a CCU holds, and its buffers. The agent of preprocessing.

use std::collections::VecDeque;

use super::TileMemory;
use crate::flow::tile_wise::STREAMS;
use crate::flow::tile_wise::batch::Batch;
use crate::flow::tile_wise::ccu::{Ccu, GAUSSIAN_IN, READS, RECORDS, TILE_LIST};
use crate::flow::tile_wise::layout::Layout;
use crate::flow::tile_wise::pipeline::{NEVER, Shared};
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::kernel::buffer::BufferAllocator;
use crate::kernel::ledger::Ledger;
use crate::kernel::memory::Arrival;
use crate::kernel::stream::StreamId;
use crate::kernel::timeline::{Level, Observer, State};
use crate::kernel::unit::Unit;
use crate::stage::Stall;

const READ_BACK: StreamId = STREAMS.id("read-back");
const RESULTS: StreamId = STREAMS.id("results");

/// The reads of a batch, in their order.
const READ_STREAMS: [StreamId; READS] =
    [STREAMS.id("records"), STREAMS.id("survivors"), STREAMS.id("colours")];

/// A batch that a CCU holds, from its claim until its results have been written.
#[derive(Debug, Clone)]
struct Held {
    index: u32,
    batch: Batch,
    /// Reads that it has issued; the last of them, or its write, is `transfer`.
    reads: usize,
    transfer: Arrival,
    /// Bytes that it has in the input buffer.
    room: u64,
    /// Whether it has asked for what it reads before it writes; `transfer` then is that.
    reads_back: bool,
    /// Whether its results have been written.
    is_written: bool,
    /// Cycle in which its results leave the unit's pipeline.
    until: u64,
}

/// The memory in a cycle.
struct Now<'a, 'm> {
    now: u64,
    memory: &'a TileMemory<'m>,
}

impl Held {
    /// Bytes that its further reads may bring, as is known now.
    fn rest(&self, ccu: &Ccu, at: &Now<'_, '_>) -> u64 {
        let is_here = at.memory.at(self.transfer) <= at.now;
        // Who survives, or has a tile, is known only when the read that decides it has arrived.
        let known = if is_here { self.reads } else { self.reads - 1 };
        ccu.may_read(&self.batch, known, self.reads)
    }
}

/// The batch that is entering the unit.
#[derive(Debug, Clone, Copy)]
struct Entering {
    index: u32,
    /// Bytes that it has in the input buffer.
    room: u64,
    /// Cycle in which its last record would have entered if no bank were in conflict.
    busy: u64,
    /// Cycle in which it has entered.
    end: u64,
}

/// One CCU.
#[derive(Debug, Clone)]
pub(super) struct CcuState {
    owner: u32,
    pub ledger: Ledger,
    state: State,
    since: u64,
    pub input: BufferAllocator,
    pub output: BufferAllocator,
    /// In the order of their claims: batches whose results are being written to DRAM, then those in
    /// the unit's pipeline, then those in the input buffer.
    held: VecDeque<Held>,
    /// How many of these are being written to DRAM.
    writing: usize,
    /// How many have entered the unit, those included.
    entered: usize,
    entering: Option<Entering>,
    pub end: u64,
}

impl CcuState {
    pub(crate) fn new(unit: u32, owner: u32, units: &ResolvedUnits) -> Self {
        Self {
            owner,
            ledger: Ledger::new(Ccu::STAGE, unit),
            state: State::Idle,
            since: 0,
            input: BufferAllocator::new(units.shares.gaussian_in),
            output: BufferAllocator::new(units.shares.tile_list),
            held: VecDeque::new(),
            writing: 0,
            entered: 0,
            entering: None,
            end: 0,
        }
    }

    /// Removes the oldest batch.
    fn pop_oldest(&mut self) {
        self.held.pop_front();
        (self.writing, self.entered) = (self.writing - 1, self.entered - 1);
    }

    /// Frees the results that have been written. In order, results of no bytes occupy nothing, so
    /// it does not matter when they are found late, behind others that are still being written.
    fn collect<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        let ccu = &shared.units.ccu;
        if shared.in_order {
            while self.writing > 0 && shared.memory.at(self.held[0].transfer) <= now {
                self.output.release(now, ccu.held(&self.held[0].batch));
                self.pop_oldest();
            }
            return;
        }
        for held in self.held.range_mut(..self.writing).filter(|held| !held.is_written) {
            if shared.memory.at(held.transfer) <= now {
                held.is_written = true;
                self.output.release(now, ccu.held(&held.batch));
                shared.lists.complete(held.index, held.batch.splats);
            }
        }
        // `writing` counts the front of `held`, so that a batch leaves with all before it or not at
        // all.
        while self.writing > 0 && self.held[0].is_written {
            self.pop_oldest();
        }
    }

    fn finish<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        self.collect(now, shared);
        while self.writing < self.entered && self.held[self.writing].until <= now {
            let (held, ccu) = (&mut self.held[self.writing], &shared.units.ccu);
            let (b, bytes, back) =
                (held.batch, ccu.written(&held.batch), ccu.read_back(&held.batch));
            // What is written may depend on it: pointers that are not on chip, the rest of a line
            // (A90).
            if back > 0 && !held.reads_back {
                let span = |layout: &Layout| layout.read_back(&b);
                held.transfer = shared.issue(now, self.owner, READ_BACK, back, span);
                held.reads_back = true;
            }
            // Younger batches wait too, because results leave in the order of batches.
            if held.reads_back && shared.memory.at(held.transfer) > now {
                break;
            }
            let span = |layout: &Layout| layout.results(&b);
            held.transfer = shared.issue(now, self.owner, RESULTS, bytes, span);
            self.writing += 1;
            let at = shared.memory.at(held.transfer);
            // On the device the end is not known yet; the memory wakes this unit when the write is
            // done.
            self.end = if at == NEVER { self.end } else { self.end.max(at) };
        }
        if let Some(entered) = self.entering.take_if(|e| e.end <= now) {
            self.input.release(now, entered.room);
        }
    }

    /// Whether `bytes` more for the batch at `place` leave room for what it and older batches may
    /// yet need, each when those before it are gone. `rest`: what it may need after these bytes.
    fn admits(&self, ccu: &Ccu, place: usize, bytes: u64, rest: u64, now: &Now<'_, '_>) -> bool {
        // What is larger than the share enters an empty buffer alone (A32), or the unit would never
        // go on.
        if self.input.used() == 0 {
            return true;
        }
        let Some(mut free) = self.input.free_with(bytes) else {
            // What is larger than the buffer streams through it alone.
            let own = self.held.get(place).map_or(0, |held| held.room);
            return self.input.used() == own;
        };
        // The batch in the unit gives its room back without asking for more.
        free += self.entering.map_or(0, |entering| entering.room);
        // Each older batch must be able to end with what those before it leave (A36): else it could
        // wait for this one, which waits for it.
        for held in self.held.range(self.entered..).take(place.saturating_sub(self.entered)) {
            if held.rest(ccu, now) > free {
                return false;
            }
            free += held.room;
        }
        rest <= free || self.input.used() == self.held.get(place).map_or(0, |held| held.room)
    }

    /// Issues the further reads of batches of which one has arrived.
    fn read_on<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        // Oldest first: room goes to the batch that enters the unit next.
        for place in self.entered..self.held.len() {
            while let Some(held) = self.held.get(place)
                && held.reads < READS
                && shared.memory.at(held.transfer) <= now
            {
                let ccu = &shared.units.ccu;
                let (batch, read) = (held.batch, held.reads);
                let bytes = ccu.read(&batch, read);
                if bytes > 0 {
                    let rest = ccu.may_read(&batch, read, read + 1);
                    let clock = Now { now, memory: &shared.memory };
                    if !self.admits(ccu, place, bytes, rest, &clock) {
                        break;
                    }
                    let span = |layout: &Layout| layout.batch_read(&batch, read, bytes);
                    let stream = READ_STREAMS[read];
                    let transfer = shared.issue(now, self.owner, stream, bytes, span);
                    self.input.fill(now, bytes);
                    let held = &mut self.held[place];
                    (held.transfer, held.room) = (transfer, held.room + bytes);
                }
                self.held[place].reads += 1;
            }
        }
    }

    fn enter<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        let ccu = &shared.units.ccu;
        let memory = &shared.memory;
        let is_here = |h: &&mut Held| h.reads == READS && memory.at(h.transfer) <= now;
        let Some(head) = self.held.get_mut(self.entered).filter(is_here) else { return };
        let bytes = ccu.held(&head.batch);
        if self.entering.is_some() || !self.output.admits(bytes) {
            return;
        }
        let rule = &shared.units.rules.ccu;
        let (cycles, stalls) = rule.times(ccu, &head.batch, &mut shared.rule_check);
        let busy = now + cycles;
        let end = busy + stalls;
        self.output.fill(now, bytes);
        // Its room is kept until the last record has entered, conflicts of banks included.
        self.entering = Some(Entering { index: head.index, room: head.room, busy, end });
        head.until = end + u64::from(ccu.spec.latency);
        self.entered += 1;
    }

    /// Whether it can take one more batch: all are thought to be as large as the largest.
    fn can_claim<O>(&self, now: u64, shared: &Shared<O>) -> bool {
        let ccu = &shared.units.ccu;
        let clock = Now { now, memory: &shared.memory };
        let batch = ccu.largest(shared.batches.pass());
        let (bytes, rest) = (ccu.read(&batch, 0), ccu.may_read(&batch, 0, 1));
        self.held.len() - self.entered < ccu.spec.queue as usize
            && self.admits(ccu, self.held.len(), bytes, rest, &clock)
    }

    /// Takes the next batch; returns whether there is more to do in the next cycle.
    fn claim<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> bool {
        if !self.can_claim(now, shared) {
            return false;
        }
        let Some(batch) = shared.batches.next() else { return false };
        let bytes = shared.units.ccu.read(&batch, 0);
        self.input.fill(now, bytes);
        let span = |layout: &Layout| layout.batch_read(&batch, 0, bytes);
        let transfer = shared.issue(now, self.owner, READ_STREAMS[0], bytes, span);
        let index = shared.next_batch;
        let (reads, room, until) = (1, bytes, NEVER);
        let (reads_back, is_written) = (false, false);
        let held = Held { index, batch, reads, transfer, room, reads_back, is_written, until };
        self.held.push_back(held);
        shared.next_batch += 1;
        let is_here = shared.memory.at(transfer) <= now;
        is_here || !shared.batches.is_empty() && self.can_claim(now, shared)
    }

    fn state<O>(&self, now: u64, shared: &Shared<O>) -> State {
        if let Some(entering) = self.entering {
            return if entering.busy > now {
                State::Busy(entering.index)
            } else {
                State::Stalled(Stall::BANK)
            };
        }
        match self.held.get(self.entered) {
            None => State::Idle,
            Some(head) if head.reads == READS && shared.memory.at(head.transfer) <= now => {
                State::Stalled(Stall::OUTPUT)
            }
            Some(_) => State::Stalled(RECORDS),
        }
    }

    fn wake<O>(&self, now: u64, shared: &Shared<O>, claims_more: bool) -> u64 {
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let at = |held: &Held| later(shared.memory.at(held.transfer));
        let open = |held: &Held| if held.is_written { NEVER } else { at(held) };
        let mut wake = if claims_more { now + 1 } else { NEVER };
        // Reads that have arrived bring further ones, or the batch into the unit.
        wake = self.held.range(self.entered..).map(at).fold(wake, u64::min);
        if self.writing < self.entered {
            let next = &self.held[self.writing];
            wake = wake.min(if next.reads_back { at(next) } else { next.until });
        }
        if let Some(entering) = self.entering {
            wake = wake.min(entering.end).min(later(entering.busy));
        }
        let waits = self.entering.is_none() && self.entered < self.held.len();
        if shared.in_order {
            // Writes free the tile-list buffer.
            return if waits && self.writing > 0 { wake.min(at(&self.held[0])) } else { wake };
        }
        if waits || shared.lists.is_watched {
            // Writes also complete lists.
            wake = self.held.range(..self.writing).map(open).fold(wake, u64::min);
        }
        wake
    }

    pub(crate) fn step<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> u64 {
        self.end = self.end.max(now);
        self.finish(now, shared);
        self.read_on(now, shared);
        self.enter(now, shared);
        let claims_more = self.claim(now, shared);
        let state = self.state(now, shared);
        if state != self.state {
            self.account(now, shared.observer);
            self.state = state;
        }
        if shared.observer.wants_levels() {
            self.tell(now, shared.observer);
        }
        self.wake(now, shared, claims_more)
    }

    /// Reports the occupancy of its buffers.
    fn tell(&self, from: u64, observer: &mut impl Observer) {
        let instance = self.ledger.instance();
        for (buffer, room) in [(GAUSSIAN_IN, &self.input), (TILE_LIST, &self.output)] {
            observer.level(Level { buffer, instance, from, bytes: room.used() });
        }
    }

    /// Books the cycles up to `now` in the ledger.
    pub(crate) fn account(&mut self, now: u64, observer: &mut impl Observer) {
        self.ledger.book(self.state, self.since, now, observer);
        self.since = now;
    }

    /// Closes the accounts of its buffers at the end of the frame.
    pub(crate) fn close(&mut self, now: u64, results: impl Fn(&Batch) -> u64) {
        // Nothing waited for the last writes, so that no step has collected them.
        let left = self.held.drain(..).filter(|held| !held.is_written);
        left.for_each(|held| self.output.release(now, results(&held.batch)));
    }
}
