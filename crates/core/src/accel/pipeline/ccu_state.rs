//! CCU state: the batches that a CCU holds, and its buffers. The agent of preprocessing.

use std::collections::VecDeque;

use super::ledger::Ledger;
use super::{NEVER, Shared};
use crate::accel::Stall;
use crate::accel::batch::Batch;
use crate::accel::buffer::BufferAllocator;
use crate::accel::ccu::Ccu;
use crate::accel::layout::{AccessPattern, Layout};
use crate::accel::machine::Fetch;
use crate::accel::memory::Arrival;
use crate::accel::resolved::ResolvedUnits;
use crate::accel::timeline::{Level, Observer, State};
use crate::accel::unit::Unit;
use crate::action::{Buffer, Stage};

/// A batch that a CCU holds, from its claim until its results have been written.
#[derive(Debug, Clone)]
struct Held {
    index: u32,
    /// Until it enters the unit: whether the read in flight is its last one. After that: whether
    /// its results have been written.
    is_through: bool,
    batch: Batch,
    /// The read or write in flight.
    transfer: Arrival,
    /// Cycle in which its results leave the unit's pipeline.
    until: u64,
}

/// The batch that is entering the unit.
#[derive(Debug, Clone, Copy)]
struct Entering {
    index: u32,
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
    /// How many have issued their last read, those included.
    asked: usize,
    entering: Option<Entering>,
    pub end: u64,
}

impl CcuState {
    pub(crate) fn new(unit: u32, owner: u32, units: &ResolvedUnits) -> Self {
        Self {
            owner,
            ledger: Ledger::new(Ccu::NAME, unit),
            state: State::Idle,
            since: 0,
            input: BufferAllocator::new(units.shares.gaussian_in),
            output: BufferAllocator::new(units.shares.tile_list),
            held: VecDeque::new(),
            writing: 0,
            entered: 0,
            asked: 0,
            entering: None,
            end: 0,
        }
    }

    /// Removes the oldest batch.
    fn pop_oldest(&mut self) {
        self.held.pop_front();
        (self.writing, self.entered, self.asked) =
            (self.writing - 1, self.entered - 1, self.asked - 1);
    }

    /// Frees the results that have been written. Results of no bytes occupy nothing, so it does not
    /// matter when they are found late, behind others that are still being written.
    fn collect<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        let ccu = &shared.units.ccu;
        if shared.in_order {
            while self.writing > 0 && shared.memory.at(self.held[0].transfer) <= now {
                self.output.release(now, ccu.written(&self.held[0].batch));
                self.pop_oldest();
            }
            return;
        }
        for held in self.held.range_mut(..self.writing).filter(|held| !held.is_through) {
            if shared.memory.at(held.transfer) <= now {
                held.is_through = true;
                self.output.release(now, ccu.written(&held.batch));
                shared.lists.complete(held.index, held.batch.splats);
            }
        }
        while self.writing > 0 && self.held[0].is_through {
            self.pop_oldest();
        }
    }

    fn finish<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        self.collect(now, shared);
        while self.writing < self.entered && self.held[self.writing].until <= now {
            let held = &mut self.held[self.writing];
            let (b, bytes) = (held.batch, shared.units.ccu.written(&held.batch));
            let span =
                |layout: &Layout| layout.results(b.first_splat, b.splats, b.first_pair, b.pairs);
            held.transfer = shared.write(now, self.owner, Stage::Preprocessing, bytes, span);
            held.is_through = false;
            self.writing += 1;
            let at = shared.memory.at(held.transfer);
            self.end = if at == NEVER { self.end } else { self.end.max(at) };
        }
        if self.entering.take_if(|e| e.end <= now).is_some() {
            self.input.release(now, shared.units.ccu.reserved());
        }
    }

    /// Issues the second reads of batches whose first ones have arrived.
    fn read_survivors<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        let owner = self.owner;
        let ask = |held: &mut Held, shared: &mut Shared<O>| {
            if held.is_through {
                return true;
            }
            if shared.memory.at(held.transfer) > now {
                return false;
            }
            held.is_through = true;
            let Batch { first, records, survivors, .. } = held.batch;
            let bytes = shared.units.ccu.second_read(&held.batch);
            if bytes > 0 {
                let span = |_: &Layout| AccessPattern::Survivors { first, records, survivors };
                held.transfer = shared.read(now, owner, Stage::Preprocessing, bytes, span);
            }
            true
        };
        while let Some(held) = self.held.get_mut(self.asked)
            && ask(held, shared)
        {
            self.asked += 1;
        }
        if !shared.in_order {
            self.held.range_mut(self.asked..).for_each(|held| _ = ask(held, shared));
        }
    }

    fn enter<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        let ccu = &shared.units.ccu;
        let memory = &shared.memory;
        let is_here = |h: &&mut Held| h.is_through && memory.at(h.transfer) <= now;
        let Some(head) = self.held.get_mut(self.entered).filter(is_here) else { return };
        let bytes = ccu.written(&head.batch);
        if self.entering.is_some() || !self.output.admits(bytes) {
            return;
        }
        let rule = &shared.units.rules.ccu;
        let (cycles, stalls) = rule.times(ccu, &head.batch, &mut shared.rule_check);
        let busy = now + cycles;
        let end = busy + stalls;
        self.output.fill(now, bytes);
        self.entering = Some(Entering { index: head.index, busy, end });
        head.until = end + u64::from(ccu.spec.latency);
        self.entered += 1;
    }

    /// Whether it can take one more batch.
    fn can_claim(&self, ccu: &Ccu) -> bool {
        self.held.len() - self.entered < ccu.spec.queue as usize
            && self.input.admits(ccu.reserved())
    }

    /// Takes the next batch; returns whether it could take one more in the next cycle.
    fn claim<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> bool {
        let ccu = &shared.units.ccu;
        if !self.can_claim(ccu) {
            return false;
        }
        let Some(batch) = shared.batches.next() else { return false };
        self.input.fill(now, ccu.reserved());
        let bytes = ccu.first_read(&batch);
        let span = |layout: &Layout| layout.first_read(batch.first, bytes);
        let transfer = shared.read(now, self.owner, Stage::Preprocessing, bytes, span);
        // The first read of everything is the only one.
        let is_through = ccu.spec.fetch == Fetch::Everything && bytes > 0;
        let index = shared.next_batch;
        self.held.push_back(Held { index, is_through, batch, transfer, until: NEVER });
        shared.next_batch += 1;
        self.can_claim(ccu) && !shared.batches.is_empty()
    }

    fn state<O>(&self, now: u64, shared: &Shared<O>) -> State {
        if let Some(entering) = self.entering {
            return if entering.busy > now {
                State::Busy(entering.index)
            } else {
                State::Stalled(Stall::Bank)
            };
        }
        match self.held.get(self.entered) {
            None => State::Idle,
            Some(head) if head.is_through && shared.memory.at(head.transfer) <= now => {
                State::Stalled(Stall::Output)
            }
            Some(_) => State::Stalled(Stall::Records),
        }
    }

    fn wake<O>(&self, now: u64, shared: &Shared<O>, claims_more: bool) -> u64 {
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let at = |held: &Held| later(shared.memory.at(held.transfer));
        let open = |held: &Held| if held.is_through { NEVER } else { at(held) };
        let mut wake = if claims_more { now + 1 } else { NEVER };
        wake = wake.min(self.held.get(self.asked).map_or(NEVER, open));
        if self.writing < self.entered {
            wake = wake.min(self.held[self.writing].until);
        }
        let head = self.held.get(self.entered);
        let waits = self.entering.is_none() && head.is_some();
        if let Some(entering) = self.entering {
            wake = wake.min(entering.end).min(later(entering.busy));
        } else if let Some(head) = head {
            wake = wake.min(at(head));
        }
        if shared.in_order {
            // Writes free the tile-list buffer.
            return if waits && self.writing > 0 { wake.min(at(&self.held[0])) } else { wake };
        }
        wake = self.held.range(self.asked..).map(open).fold(wake, u64::min);
        if waits || shared.lists.is_watched {
            // Writes also complete lists.
            wake = self.held.range(..self.writing).map(open).fold(wake, u64::min);
        }
        wake
    }

    pub(crate) fn step<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> u64 {
        self.end = self.end.max(now);
        self.finish(now, shared);
        self.read_survivors(now, shared);
        self.enter(now, shared);
        let claims_more = self.claim(now, shared);
        let state = self.state(now, shared);
        if state != self.state {
            self.account(now, shared.observer);
            self.state = state;
        }
        if O::WANTS_LEVELS {
            self.tell(now, shared.observer);
        }
        self.wake(now, shared, claims_more)
    }

    /// Reports the occupancy of its buffers.
    fn tell(&self, from: u64, observer: &mut impl Observer) {
        let instance = self.ledger.instance();
        for (buffer, room) in [(Buffer::GaussianIn, &self.input), (Buffer::TileList, &self.output)]
        {
            observer.level(Level { buffer, instance, from, bytes: room.used() });
        }
    }

    /// Books the cycles up to `now` in the ledger.
    pub(crate) fn account(&mut self, now: u64, observer: &mut impl Observer) {
        self.ledger.book(self.state, self.since, now, observer);
        self.since = now;
    }

    /// Closes the accounts of its buffers at the end of the frame.
    pub(crate) fn close(&mut self, now: u64, written: impl Fn(&Batch) -> u64) {
        let left = self.held.drain(..).filter(|held| !held.is_through);
        left.for_each(|held| self.output.release(now, written(&held.batch)));
    }
}
