//! Order units.
//!
//! A unit takes the next region as soon as it has none; a region without entries is in order at
//! once. It reads the whole list, takes it through as many passes as it takes to merge single keys
//! into one list, and writes it back; the list is in order when that is done. Keys beyond its share
//! of the buffer are written behind every pass but the last, and then read before the next begins.

use super::RegionShared;
use super::stages::{KEYS, ORDER, WAITS_KEYS, WAITS_LIST};
use crate::kernel::BufferUse;
use crate::kernel::buffer::{BufferAllocator, usage};
use crate::kernel::ledger::Account;
use crate::kernel::memory::{Arrival, NEVER};
use crate::kernel::timeline::{Observer, State};
use crate::stage::Stall;

/// Where a list is.
#[derive(Debug, Clone, Copy)]
enum ListAt {
    Read(Arrival),
    Pass { until: u64, left: u64 },
    Out { arrival: Arrival, left: u64 },
    Back { arrival: Arrival, left: u64 },
    Write(Arrival),
}

/// A unit.
#[derive(Debug)]
pub struct OrderUnit {
    owner: u32,
    list: Option<(u32, ListAt)>,
    keys: BufferAllocator,
    share: u64,
    pub account: Account,
    /// Keys that it moved.
    pub moved: u64,
}

impl OrderUnit {
    pub fn new(owner: u32, instance: u32, share: u64) -> OrderUnit {
        OrderUnit {
            owner,
            list: None,
            keys: BufferAllocator::new(share),
            share,
            account: Account::new(ORDER, instance),
            moved: 0,
        }
    }

    /// The buffers of all units.
    pub fn buffer(all: &[OrderUnit]) -> BufferUse {
        usage(KEYS, all.iter().map(|unit| &unit.keys))
    }

    pub fn step<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> u64 {
        self.account.up_to(now, shared.observer);
        while self.advance(now, shared) {}
        let (state, wake) = match self.list {
            None => (State::Idle, NEVER),
            Some((_, ListAt::Read(arrival))) => {
                (State::Stalled(WAITS_LIST), shared.memory.at(arrival))
            }
            Some((region, ListAt::Pass { until, .. })) => (State::Busy(region), until),
            Some((_, ListAt::Out { arrival, .. } | ListAt::Back { arrival, .. })) => {
                (State::Stalled(WAITS_KEYS), shared.memory.at(arrival))
            }
            Some((_, ListAt::Write(arrival))) => {
                (State::Stalled(Stall::OUTPUT), shared.memory.at(arrival))
            }
        };
        self.account.is(state);
        wake
    }

    /// Does the next thing; whether there was one.
    fn advance<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let Some((region, at)) = self.list else { return self.take(now, shared) };
        let facts = shared.frame.regions[region as usize];
        let keys = u64::from(facts.entries);
        let (first, bytes) = (u64::from(facts.start), keys * shared.machine.gaussian.entry.0);
        let held = bytes.min(self.share);
        let spec = &shared.machine.order;
        let pass = |left: u64| ListAt::Pass { until: now + spec.cycles(keys), left };
        let write = |unit: &OrderUnit, shared: &mut RegionShared<O>| {
            let place = shared.layout().ordered(first, bytes);
            ListAt::Write(shared.issue(now, unit.owner, shared.streams.ordered, bytes, place))
        };
        let next = match at {
            ListAt::Read(arrival)
            | ListAt::Out { arrival, .. }
            | ListAt::Back { arrival, .. }
            | ListAt::Write(arrival)
                if shared.memory.at(arrival) > now =>
            {
                return false;
            }
            ListAt::Read(_) => match spec.passes(keys) {
                0 => write(self, shared),
                passes => pass(passes - 1),
            },
            ListAt::Out { left, .. } => {
                let (stream, beyond) = (shared.streams.passes_in, bytes - held);
                let place = shared.layout().pass(first, beyond);
                let arrival = shared.issue(now, self.owner, stream, beyond, place);
                ListAt::Back { arrival, left }
            }
            ListAt::Back { left, .. } => pass(left - 1),
            ListAt::Pass { until, .. } if until > now => return false,
            ListAt::Pass { left, .. } => {
                self.moved += keys;
                let beyond = bytes - held;
                match left {
                    0 => write(self, shared),
                    _ if beyond == 0 => pass(left - 1),
                    _ => {
                        let (stream, place) =
                            (shared.streams.passes_out, shared.layout().pass(first, beyond));
                        let arrival = shared.issue(now, self.owner, stream, beyond, place);
                        ListAt::Out { arrival, left }
                    }
                }
            }
            ListAt::Write(_) => {
                self.keys.release(now, held);
                shared.ready(region);
                self.list = None;
                return true;
            }
        };
        self.list = Some((region, next));
        true
    }

    /// Takes the next region; whether there was one.
    fn take<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let region = shared.next_region;
        let Some(facts) = shared.frame.regions.get(region as usize).copied() else { return false };
        shared.next_region += 1;
        if facts.entries == 0 {
            shared.ready(region);
            return true;
        }
        let bytes = u64::from(facts.entries) * shared.machine.gaussian.entry.0;
        let place = shared.layout().list(u64::from(facts.start), bytes);
        // A list beyond the share fills it, and the rest goes through the memory behind each pass
        // (A120).
        self.keys.fill(now, bytes.min(self.share));
        let arrival = shared.issue(now, self.owner, shared.streams.lists, bytes, place);
        self.list = Some((region, ListAt::Read(arrival)));
        true
    }
}
