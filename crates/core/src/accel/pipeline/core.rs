//! A core with its buffers: the agent of the tile phase.
//!
//! A job goes from the front to the middle when the middle is empty. The middle sends the chunks
//! of the job's tiles, in order and as many a cycle as there is room for, into the feature buffer:
//! a chunk's feature read is issued and its sort is queued at the BSU when it enters, and its room
//! is free again when it has been rendered. Behind the last chunk that a tile needs, the middle
//! sends up to `vru.speculation` further chunks of its list, as long as nobody knows that they are
//! not needed: until the last needed chunk has been rendered (A30). Then they are discarded, and
//! their room is free when their data is there. A tile without chunks goes through when no chunk
//! waits for the VRU.
//!
//! The VRU takes chunks in order when they are sorted and their features have arrived. After the
//! last one of a tile the pixels move to the pixel buffer and their write is issued; while there is
//! no room for them, the VRU stalls.
//!
//! Order within a cycle: rooms are given back, pixels leave, the VRU begins; the front moves on;
//! the middle sends; the front fetches. Requests of one core reach the DRAM in that order.

use std::collections::VecDeque;

use super::front::Front;
use super::ledger::Ledger;
use super::middle::Middle;
use super::{NEVER, Shared};
use crate::accel::bsu::Bsu;
use crate::accel::buffer::Room;
use crate::accel::design::Design;
use crate::accel::layout::Layout;
use crate::accel::memory::Arrival;
use crate::accel::qsu::Qsu;
use crate::accel::timeline::{Level, Observer, State};
use crate::accel::unit::Unit;
use crate::accel::vru::Vru;
use crate::accel::{Histogram, Stall};
use crate::action::{ActionCounts, Buffer, Stage};

/// A chunk in the feature buffer, or a tile without chunks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub tile: u32,
    /// Cycles of the VRU, and further ones that it waits for banks.
    pub cycles: u64,
    pub stalls: u64,
    pub features: Arrival,
    /// When it is sorted.
    pub sorted: u64,
    /// Bytes in the feature buffer.
    pub bytes: u64,
    /// Bytes of the tile's pixels, with its last chunk.
    pub pixels: Option<u64>,
    /// Whether nobody needs it.
    pub speculative: bool,
}

/// The chunk that is rendered.
#[derive(Debug, Clone, Copy)]
struct Rendering {
    item: Item,
    busy: u64,
    end: u64,
}

/// One core.
#[derive(Debug)]
pub(super) struct Core {
    pub owner: u32,
    pub qsu: Ledger,
    pub bsu: Ledger,
    pub vru: Ledger,
    /// What QSU, BSU (when it does not sort) and VRU do since `since`.
    states: [State; 3],
    since: u64,
    pub front: Front,
    pub middle: Option<Middle>,
    pub waiting: VecDeque<Item>,
    rendering: Option<Rendering>,
    /// Whether the last needed chunk of the middle's tile has been sent and not yet rendered.
    pub is_open: bool,
    /// Pixels that wait for room.
    finished: Option<u64>,
    pub sorter_free: u64,
    pub features: Room,
    pub pixels: Room,
    /// Pixel writes under way.
    writing: Vec<(Arrival, u64)>,
    /// Features under way that nobody needs.
    doomed: Vec<(Arrival, u64)>,
    /// Since when the VRU renders the current tile.
    tile_since: Option<u64>,
    /// The tile that was rendered last.
    last_tile: u32,
    pub tile_cycles: Histogram,
    /// What was done that nobody needed.
    pub speculation: ActionCounts,
    pub end: u64,
}

impl Core {
    pub fn new(core: u32, owner: u32, design: &Design) -> Self {
        Self {
            owner,
            qsu: Ledger::new(Qsu::NAME, core),
            bsu: Ledger::new(Bsu::NAME, core),
            vru: Ledger::new(Vru::NAME, core),
            states: [State::Idle; 3],
            since: 0,
            front: Front::new(core, owner, design.shares.sorting),
            middle: None,
            waiting: VecDeque::new(),
            rendering: None,
            is_open: false,
            finished: None,
            sorter_free: 0,
            features: Room::new(design.shares.feature),
            pixels: Room::new(design.shares.pixel_out),
            writing: Vec::new(),
            doomed: Vec::new(),
            tile_since: None,
            last_tile: 0,
            tile_cycles: Histogram::EMPTY,
            speculation: ActionCounts::default(),
            end: 0,
        }
    }

    fn give_back<O>(&mut self, now: u64, shared: &Shared<O>) {
        let is_left = |arrival: Arrival| shared.memory.at(arrival) > now;
        self.writing.retain(|&(write, bytes)| {
            self.pixels.release(now, if is_left(write) { 0 } else { bytes });
            is_left(write)
        });
        self.doomed.retain(|&(read, bytes)| {
            self.features.discard(now, if is_left(read) { 0 } else { bytes });
            is_left(read)
        });
        self.front.release_sorted(now);
        let Some(Rendering { item, .. }) = self.rendering.take_if(|r| r.end <= now) else { return };
        self.features.release(now, item.bytes);
        if item.pixels.is_some() {
            self.finish_tile(now, item, shared);
        }
    }

    /// A tile is done: chunks of it that follow were fetched in vain.
    fn finish_tile<O>(&mut self, now: u64, item: Item, shared: &Shared<O>) {
        self.finished = item.pixels;
        self.tile_cycles.count(now - self.tile_since.take().unwrap_or(now));
        while let Some(unused) = self.waiting.pop_front_if(|next| next.speculative) {
            if shared.memory.at(unused.features) <= now {
                self.features.discard(now, unused.bytes);
            } else {
                self.doomed.push((unused.features, unused.bytes));
            }
        }
        let sent_later = self.waiting.iter().any(|next| next.pixels.is_some());
        self.is_open &= sent_later;
    }

    fn write_pixels<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        let Some(bytes) = self.finished.take_if(|bytes| self.pixels.admits(*bytes)) else { return };
        self.pixels.fill(now, bytes);
        let tile = self.last_tile;
        let span = |layout: &Layout| layout.pixels(tile, bytes);
        let left = shared.write(now, self.owner, Stage::Rendering, bytes, span);
        self.writing.push((left, bytes));
        self.note(left, shared);
    }

    /// The phase is not over before this is done.
    pub fn note<O>(&mut self, arrival: Arrival, shared: &Shared<O>) {
        let at = shared.memory.at(arrival);
        if at != NEVER {
            self.end = self.end.max(at);
        }
    }

    fn render<O>(&mut self, now: u64, shared: &Shared<O>) {
        if self.rendering.is_some() || self.finished.is_some() {
            return;
        }
        let is_ready = |item: &mut Item| {
            item.sorted <= now && shared.memory.at(item.features) <= now && !item.speculative
        };
        let Some(item) = self.waiting.pop_front_if(is_ready) else { return };
        let busy = now + item.cycles;
        self.rendering = Some(Rendering { item, busy, end: busy + item.stalls });
        self.tile_since.get_or_insert(now);
        self.last_tile = item.tile;
    }
}

impl Core {
    fn states<O>(&self, now: u64, shared: &Shared<O>) -> [State; 3] {
        let vru = match (&self.rendering, self.finished, self.waiting.front()) {
            (Some(r), _, _) if r.busy > now => State::Busy(r.item.tile),
            (Some(_), _, _) => State::Stalled(Stall::Bank),
            (None, Some(_), _) => State::Stalled(Stall::Output),
            (None, None, Some(item)) if shared.memory.at(item.features) > now => {
                State::Stalled(Stall::Features)
            }
            (None, None, Some(_)) => State::Stalled(Stall::Input),
            // What is in the feature buffer is not needed, and still on its way.
            (None, None, None) if self.middle.is_some() => State::Stalled(Stall::Features),
            (None, None, None) => self.front.wait(now),
        };
        let bsu = match self.middle {
            Some(_) => State::Stalled(Stall::Output),
            None => self.front.wait(now),
        };
        [self.front.state(now), bsu, vru]
    }

    fn wake<O>(&self, now: u64, shared: &Shared<O>) -> u64 {
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let at = |arrival: Arrival| later(shared.memory.at(arrival));
        let first = |all: &[(Arrival, u64)]| all.iter().map(|one| at(one.0)).fold(NEVER, u64::min);
        let vru = match (&self.rendering, self.finished, self.waiting.front()) {
            (Some(r), _, _) => r.end.min(later(r.busy)),
            (None, Some(_), _) => first(&self.writing),
            (None, None, Some(item)) if shared.memory.at(item.features) > now => at(item.features),
            (None, None, Some(item)) => later(item.sorted),
            (None, None, None) => NEVER,
        };
        let unused = first(&self.doomed);
        vru.min(unused).min(self.front.wake(now, shared))
    }

    pub fn step<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> u64 {
        self.end = self.end.max(now);
        self.give_back(now, shared);
        self.write_pixels(now, shared);
        self.render(now, shared);
        self.front.advance(now, shared);
        self.send(now, shared);
        self.front.fetch(now, shared);
        self.states = self.states(now, shared);
        if O::WANTS_LEVELS {
            self.tell(now, shared.observer);
        }
        self.wake(now, shared)
    }

    /// Says what its buffers hold.
    fn tell(&self, from: u64, observer: &mut impl Observer) {
        let rooms = [
            (Buffer::Sorting, &self.front.keys),
            (Buffer::Feature, &self.features),
            (Buffer::PixelOut, &self.pixels),
        ];
        let instance = self.vru.instance();
        for (buffer, room) in rooms {
            observer.level(Level { buffer, instance, from, bytes: room.used() });
        }
    }

    pub fn account(&mut self, now: u64, observer: &mut impl Observer) {
        let [qsu, bsu, vru] = self.states;
        self.qsu.book(qsu, self.since, now, observer);
        self.bsu.book(bsu, self.since.max(self.sorter_free), now, observer);
        self.vru.book(vru, self.since, now, observer);
        self.since = now;
    }

    /// Ends the accounts of its buffers.
    pub fn close(&mut self, now: u64) {
        self.writing.drain(..).for_each(|(_, bytes)| self.pixels.release(now, bytes));
        self.doomed.drain(..).for_each(|(_, bytes)| self.features.discard(now, bytes));
        self.front.close(now);
    }
}
