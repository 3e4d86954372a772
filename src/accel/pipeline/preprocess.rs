//! A CCU with its buffers: the agent of preprocessing.

use std::collections::VecDeque;

use super::ledger::Ledger;
use super::{NEVER, Shared};
use crate::accel::Stall;
use crate::accel::batch::Batch;
use crate::accel::buffer::Room;
use crate::accel::ccu::Ccu;
use crate::accel::design::Design;
use crate::accel::layout::Span;
use crate::accel::machine::Fetch;
use crate::accel::memory::Arrival;
use crate::accel::timeline::{Observer, State};
use crate::accel::unit::Unit;
use crate::action::Stage;

/// A batch in the input buffer.
#[derive(Debug)]
struct Claim {
    index: u32,
    batch: Batch,
    /// The read that is under way.
    read: Arrival,
    /// Whether that is the last one.
    complete: bool,
}

/// A batch that enters.
#[derive(Debug, Clone, Copy)]
struct Entering {
    index: u32,
    /// When its last record would have entered if no bank were in the way.
    busy: u64,
    /// When it has.
    end: u64,
}

/// Results of a batch: in the pipeline until a cycle, or under way to DRAM.
#[derive(Debug, Clone, Copy)]
struct Results<T> {
    until: T,
    index: u32,
    batch: Batch,
}

/// One CCU.
#[derive(Debug)]
pub(super) struct Converter {
    owner: u32,
    pub ledger: Ledger,
    state: State,
    since: u64,
    pub input: Room,
    pub output: Room,
    claims: VecDeque<Claim>,
    entering: Option<Entering>,
    draining: VecDeque<Results<u64>>,
    writing: Vec<Results<Arrival>>,
    pub end: u64,
}

impl Converter {
    pub fn new(unit: u32, owner: u32, design: &Design) -> Self {
        Self {
            owner,
            ledger: Ledger::new(Ccu::NAME, unit),
            state: State::Idle,
            since: 0,
            input: Room::new(design.shares.gaussian_in),
            output: Room::new(design.shares.tile_list),
            claims: VecDeque::new(),
            entering: None,
            draining: VecDeque::new(),
            writing: Vec::new(),
            end: 0,
        }
    }

    fn finish<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        let ccu = &shared.design.ccu;
        self.writing.retain(|w| {
            let is_left = shared.memory.at(w.until) > now;
            if !is_left {
                self.output.release(now, ccu.written(&w.batch));
                shared.binned.complete(w.index, w.batch.splats);
            }
            is_left
        });
        while let Some(d) = self.draining.pop_front_if(|d| d.until <= now) {
            let (b, bytes) = (&d.batch, ccu.written(&d.batch));
            let layout = shared.memory.layout();
            let span = layout.results(b.first_splat, b.splats, b.first_pair, b.pairs);
            let left = shared.write(now, self.owner, Stage::Preprocessing, bytes, span);
            self.writing.push(Results { until: left, index: d.index, batch: d.batch });
            let at = shared.memory.at(left);
            self.end = if at == NEVER { self.end } else { self.end.max(at) };
        }
        if self.entering.take_if(|e| e.end <= now).is_some() {
            self.input.release(now, ccu.reserved());
        }
    }

    fn read_survivors<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        for claim in self.claims.iter_mut().filter(|c| !c.complete) {
            if shared.memory.at(claim.read) > now {
                continue;
            }
            let bytes = shared.design.ccu.second_read(&claim.batch);
            claim.complete = true;
            if bytes > 0 {
                let Batch { first, records, survivors, .. } = claim.batch;
                let span = Span::Survivors { first, records, survivors };
                claim.read = shared.read(now, self.owner, Stage::Preprocessing, bytes, span);
            }
        }
    }

    fn enter<O>(&mut self, now: u64, shared: &Shared<O>) {
        let ccu = &shared.design.ccu;
        let is_here = |c: &&Claim| c.complete && shared.memory.at(c.read) <= now;
        let Some(head) = self.claims.front().filter(is_here) else { return };
        let bytes = ccu.written(&head.batch);
        if self.entering.is_some() || !self.output.admits(bytes) {
            return;
        }
        let busy = now + ccu.cycles(&head.batch);
        let end = busy + ccu.bank_stalls(&head.batch);
        self.output.fill(now, bytes);
        let (index, batch) = (head.index, head.batch);
        self.entering = Some(Entering { index, busy, end });
        self.draining.push_back(Results { until: end + u64::from(ccu.spec.latency), index, batch });
        self.claims.pop_front();
    }

    /// Whether there is room for one more batch.
    fn has_room(&self, ccu: &Ccu) -> bool {
        self.claims.len() < ccu.spec.queue as usize && self.input.admits(ccu.reserved())
    }

    /// Takes the next batch; says whether it could take one more in the next cycle.
    fn claim<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> bool {
        let ccu = &shared.design.ccu;
        if !self.has_room(ccu) {
            return false;
        }
        let Some(batch) = shared.batches.next() else { return false };
        self.input.fill(now, ccu.reserved());
        let bytes = ccu.first_read(&batch);
        let span = shared.memory.layout().first_read(batch.first, bytes);
        let read = shared.read(now, self.owner, Stage::Preprocessing, bytes, span);
        // The first read of everything is the only one.
        let complete = ccu.spec.fetch == Fetch::Everything && bytes > 0;
        self.claims.push_back(Claim { index: shared.next_batch, batch, read, complete });
        shared.next_batch += 1;
        self.has_room(ccu) && !shared.batches.is_empty()
    }

    fn state<O>(&self, now: u64, shared: &Shared<O>) -> State {
        if let Some(entering) = self.entering {
            return if entering.busy > now {
                State::Busy(entering.index)
            } else {
                State::Stalled(Stall::Bank)
            };
        }
        match self.claims.front() {
            None => State::Idle,
            Some(head) if head.complete && shared.memory.at(head.read) <= now => {
                State::Stalled(Stall::Output)
            }
            Some(_) => State::Stalled(Stall::Records),
        }
    }

    fn wake<O>(&self, now: u64, shared: &Shared<O>, claims_more: bool) -> u64 {
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let at = |arrival: Arrival| later(shared.memory.at(arrival));
        let mut wake = if claims_more { now + 1 } else { NEVER };
        if let Some(entering) = self.entering {
            wake = wake.min(entering.end).min(later(entering.busy));
        } else if let Some(head) = self.claims.front() {
            wake = wake.min(at(head.read));
        }
        // Writes give room back, and complete lists.
        if self.entering.is_none() && !self.claims.is_empty() || shared.binned.is_watched {
            wake = self.writing.iter().map(|w| at(w.until)).fold(wake, u64::min);
        }
        let reading = self.claims.iter().filter(|c| !c.complete);
        wake = reading.map(|c| at(c.read)).fold(wake, u64::min);
        wake.min(self.draining.front().map_or(NEVER, |d| d.until))
    }

    pub fn step<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> u64 {
        self.end = self.end.max(now);
        self.finish(now, shared);
        self.read_survivors(now, shared);
        self.enter(now, shared);
        let claims_more = self.claim(now, shared);
        self.state = self.state(now, shared);
        self.wake(now, shared, claims_more)
    }

    pub fn account(&mut self, now: u64, observer: &mut impl Observer) {
        self.ledger.book(self.state, self.since, now, observer);
        self.since = now;
    }

    /// Ends the accounts of its buffers.
    pub fn close(&mut self, now: u64, written: impl Fn(&Batch) -> u64) {
        self.writing.drain(..).for_each(|w| self.output.release(now, written(&w.batch)));
    }
}
