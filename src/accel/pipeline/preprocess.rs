//! A CCU with its buffers: the agent of the preprocessing phase.

use std::collections::VecDeque;

use super::ledger::Ledger;
use super::{Agent, NEVER, Shared};
use crate::accel::Stall;
use crate::accel::batch::Batch;
use crate::accel::buffer::Room;
use crate::accel::ccu::Ccu;
use crate::accel::design::Design;
use crate::accel::timeline::{Observer, State};
use crate::accel::unit::Unit;
use crate::action::Stage;

/// A batch in the input buffer.
#[derive(Debug)]
struct Claim {
    index: u32,
    batch: Batch,
    /// When the read that is under way arrives.
    arrival: u64,
    /// Whether that is the last one.
    complete: bool,
}

/// One CCU.
#[derive(Debug)]
pub(super) struct Converter {
    pub ledger: Ledger,
    state: State,
    since: u64,
    input: Room,
    output: Room,
    claims: VecDeque<Claim>,
    /// Batch that enters, and the cycle in which it has entered.
    entering: Option<(u32, u64)>,
    /// Results on their way through the pipeline: when they come out, bytes.
    draining: VecDeque<(u64, u64)>,
    /// Writes under way: when they have left, bytes.
    writing: VecDeque<(u64, u64)>,
    end: u64,
}

impl Converter {
    pub fn new(unit: u32, design: &Design) -> Self {
        Self {
            ledger: Ledger::new(Ccu::NAME, unit),
            state: State::Idle,
            since: 0,
            input: Room::new(design.shares.gaussian_in),
            output: Room::new(design.shares.tile_list),
            claims: VecDeque::new(),
            entering: None,
            draining: VecDeque::new(),
            writing: VecDeque::new(),
            end: 0,
        }
    }

    fn finish<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        while let Some((_, bytes)) = self.writing.pop_front_if(|w| w.0 <= now) {
            self.output.release(bytes);
        }
        while let Some((_, bytes)) = self.draining.pop_front_if(|d| d.0 <= now) {
            let left = shared.channel.write(now, Stage::Preprocessing, bytes);
            self.writing.push_back((left, bytes));
            self.end = self.end.max(left);
        }
        if self.entering.take_if(|e| e.1 <= now).is_some() {
            self.input.release(shared.design.ccu.reserved());
        }
    }

    fn read_survivors<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        for claim in self.claims.iter_mut().filter(|c| !c.complete && c.arrival <= now) {
            let bytes = shared.design.ccu.second_read(&claim.batch);
            claim.complete = true;
            if bytes > 0 {
                claim.arrival = shared.channel.read(now, Stage::Preprocessing, bytes);
            }
        }
    }

    fn enter<O>(&mut self, now: u64, shared: &Shared<O>) {
        let ccu = &shared.design.ccu;
        let Some(head) = self.claims.front().filter(|c| c.complete && c.arrival <= now) else {
            return;
        };
        let bytes = ccu.written(&head.batch);
        if self.entering.is_some() || !self.output.admits(bytes) {
            return;
        }
        let end = now + ccu.cycles(&head.batch);
        self.output.fill(bytes);
        self.entering = Some((head.index, end));
        self.draining.push_back((end + u64::from(ccu.spec.latency), bytes));
        self.claims.pop_front();
    }

    /// Takes the next batch; says whether it could take one more in the next cycle.
    fn claim<O>(&mut self, now: u64, shared: &mut Shared<O>) -> bool {
        let ccu = &shared.design.ccu;
        if !self.input.admits(ccu.reserved()) {
            return false;
        }
        let Some(batch) = shared.batches.next() else { return false };
        self.input.fill(ccu.reserved());
        let arrival = shared.channel.read(now, Stage::Preprocessing, ccu.first_read(&batch));
        self.claims.push_back(Claim { index: shared.next_batch, batch, arrival, complete: false });
        shared.next_batch += 1;
        self.input.admits(ccu.reserved()) && !shared.batches.is_empty()
    }

    fn state(&self, now: u64) -> State {
        if let Some((batch, _)) = self.entering {
            return State::Busy(batch);
        }
        match self.claims.front() {
            None => State::Idle,
            Some(head) if head.complete && head.arrival <= now => State::Stalled(Stall::Output),
            Some(_) => State::Stalled(Stall::Records),
        }
    }

    fn wake(&self, now: u64, claims_more: bool) -> u64 {
        let mut wake = if claims_more { now + 1 } else { NEVER };
        if let Some((_, end)) = self.entering {
            wake = wake.min(end);
        } else if let Some(head) = self.claims.front() {
            wake = wake.min(if head.arrival > now { head.arrival } else { NEVER });
            wake = wake.min(self.writing.front().map_or(NEVER, |w| w.0));
        }
        if let Some(claim) = self.claims.iter().find(|c| !c.complete) {
            wake = wake.min(claim.arrival);
        }
        wake.min(self.draining.front().map_or(NEVER, |d| d.0))
    }
}

impl<O: Observer> Agent<O> for Converter {
    fn step(&mut self, now: u64, shared: &mut Shared<O>) -> u64 {
        self.end = self.end.max(now);
        self.finish(now, shared);
        self.read_survivors(now, shared);
        self.enter(now, shared);
        let claims_more = self.claim(now, shared);
        self.state = self.state(now);
        self.wake(now, claims_more)
    }

    fn account(&mut self, now: u64, observer: &mut O) {
        self.ledger.book(self.state, self.since, now, observer);
        self.since = now;
    }

    fn end(&self) -> u64 {
        self.end
    }
}
