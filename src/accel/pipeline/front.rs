//! The front of a core: one tile whose list is read and roughly sorted.
//!
//! A front takes the next tile as soon as it is empty (A29), waits until the keys fit the core's
//! share of the sorting buffer beside those of earlier tiles, reads the list, and runs the QSU
//! passes. Then the tile waits until the middle of the core is empty. Keys stay in the sorting
//! buffer until the last fetched chunk of their tile has been sorted.

use std::collections::VecDeque;

use super::{NEVER, Shared};
use crate::accel::Stall;
use crate::accel::buffer::Room;
use crate::accel::qsu::List;
use crate::accel::timeline::State;
use crate::action::Stage;

/// Where the tile is.
#[derive(Debug, Clone, Copy)]
enum Phase {
    /// Waits for room in the sorting buffer.
    Room,
    /// The list is read until this cycle.
    List(u64),
    /// A pass is under way: passes left after it, when its keys and its spill are done.
    Pass { left: u32, keys: u64, spill: u64 },
    /// Waits for the middle.
    Ready,
}

/// The tile in the front.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrontTile {
    /// Index.
    pub tile: u32,
    /// Its list.
    pub list: List,
    phase: Phase,
}

/// The front, and the sorting buffer.
#[derive(Debug)]
pub(super) struct Front {
    held: Option<FrontTile>,
    keys: Room,
    /// When keys are released, and how many bytes.
    releases: VecDeque<(u64, u64)>,
}

impl Front {
    pub fn new(share: u64) -> Self {
        Self { held: None, keys: Room::new(share), releases: VecDeque::new() }
    }

    /// Gives back the room of keys whose tile has been sorted.
    pub fn release_sorted(&mut self, now: u64) {
        while let Some((_, bytes)) = self.releases.pop_front_if(|r| r.0 <= now) {
            self.keys.release(bytes);
        }
    }

    /// The last fetched chunk of a tile will be sorted in cycle `at`.
    pub fn release_at(&mut self, at: u64, bytes: u64) {
        self.releases.push_back((at, bytes));
    }

    /// A tile without fetched chunks needs no keys.
    pub fn release_now(&mut self, bytes: u64) {
        self.keys.release(bytes);
    }

    /// Moves on from a list that has arrived or a pass that is done.
    pub fn advance<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        let Some(held) = &mut self.held else { return };
        let left = match held.phase {
            Phase::List(arrival) if arrival <= now => shared.design.qsu.passes(held.list),
            Phase::Pass { left, keys, spill } if keys.max(spill) <= now => left,
            Phase::Room | Phase::Ready | Phase::List(_) | Phase::Pass { .. } => return,
        };
        held.phase = match left {
            0 => Phase::Ready,
            _ => begin_pass(held.list, left - 1, now, shared),
        };
    }

    /// Hands the tile over once it is ready.
    pub fn hand_over(&mut self) -> Option<FrontTile> {
        self.held.take_if(|held| matches!(held.phase, Phase::Ready))
    }

    /// Takes the next tile if there is none, and issues the list read if there is room.
    pub fn fetch<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        if self.held.is_none() {
            let Some(tile) = shared.workload.tiles.get(shared.next_tile as usize) else { return };
            let list = List { entries: u64::from(tile.entries) };
            self.held = Some(FrontTile { tile: shared.next_tile, list, phase: Phase::Room });
            shared.next_tile += 1;
        }
        let Some(held) = self.held.as_mut().filter(|h| matches!(h.phase, Phase::Room)) else {
            return;
        };
        let qsu = &shared.design.qsu;
        let bytes = qsu.resident(held.list);
        if self.keys.admits(bytes) {
            self.keys.fill(bytes);
            let read = held.list.entries * qsu.key;
            held.phase = Phase::List(shared.channel.read(now, Stage::Sorting, read));
        }
    }

    /// What the QSUs do, as of the end of the events of cycle `now`.
    pub fn state(&self, now: u64) -> State {
        let Some(held) = &self.held else { return State::Idle };
        match held.phase {
            Phase::Pass { keys, .. } if keys > now => State::Busy(held.tile),
            Phase::Pass { .. } => State::Stalled(Stall::Spill),
            Phase::List(_) if held.list.entries > 0 => State::Stalled(Stall::List),
            Phase::List(_) => State::Stalled(Stall::Input),
            Phase::Room | Phase::Ready => State::Stalled(Stall::Output),
        }
    }

    /// Why units behind an otherwise empty core wait.
    pub fn wait(&self, now: u64) -> State {
        match self.state(now) {
            State::Idle => State::Idle,
            State::Stalled(cause) if cause.is_dram() => State::Stalled(cause),
            State::Busy(_) | State::Stalled(_) => State::Stalled(Stall::Input),
        }
    }

    pub fn wake(&self, now: u64) -> u64 {
        match self.held.map(|held| held.phase) {
            None | Some(Phase::Ready) => NEVER,
            Some(Phase::Room) => self.releases.front().map_or(NEVER, |r| r.0),
            Some(Phase::List(arrival)) => arrival,
            Some(Phase::Pass { keys, spill, .. }) => {
                if keys > now {
                    keys
                } else {
                    spill
                }
            }
        }
    }
}

fn begin_pass<O>(list: List, left: u32, now: u64, shared: &mut Shared<O>) -> Phase {
    let qsu = &shared.design.qsu;
    let overflow = qsu.overflow(list);
    let keys = now + qsu.pass_cycles(list);
    if overflow == 0 {
        return Phase::Pass { left, keys, spill: now };
    }
    shared.channel.write(now, Stage::Sorting, overflow);
    let spill = shared.channel.read(now, Stage::Sorting, overflow);
    Phase::Pass { left, keys, spill }
}
