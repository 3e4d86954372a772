//! A core with its buffers: the agent of the tile phase.
//!
//! A tile goes from the front to the middle when the middle is empty. The middle sends its fetched
//! chunks, in order and as many a cycle as there is room for, into the feature buffer: a chunk's
//! feature read is issued and its sort is queued at the BSU when it enters, and its room is free
//! again when it has been rendered. The machine knows which chunks a tile needs (A30): none is
//! fetched in vain. A tile without chunks goes through when no chunk waits for the VRU.
//!
//! The VRU takes chunks in order when they are sorted and their features have arrived. After the
//! last one of a tile the pixels move to the pixel buffer and their write is issued; while there is
//! no room for them, the VRU stalls.
//!
//! Order within a cycle: rooms are given back, pixels leave, the VRU begins; the front moves on;
//! the middle sends; the front fetches. Requests of one core reach the DRAM in that order.

use std::collections::VecDeque;

use super::front::{Front, FrontTile};
use super::ledger::Ledger;
use super::{Agent, NEVER, Shared};
use crate::accel::Stall;
use crate::accel::bsu::Bsu;
use crate::accel::buffer::Room;
use crate::accel::design::Design;
use crate::accel::qsu::Qsu;
use crate::accel::timeline::{Observer, State};
use crate::accel::traffic::{chunk_read, chunks_of};
use crate::accel::unit::Unit;
use crate::accel::vru::{Render, Vru};
use crate::action::Stage;

/// A tile in the middle.
#[derive(Debug)]
struct Middle {
    tile: FrontTile,
    next_chunk: u32,
}

/// A chunk in the feature buffer, or a tile without chunks.
#[derive(Debug, Clone, Copy)]
struct Item {
    tile: u32,
    /// Cycles of the VRU.
    cycles: u64,
    /// When its features are there.
    features: u64,
    /// When it can be rendered.
    ready: u64,
    /// Bytes in the feature buffer.
    bytes: u64,
    /// Bytes of the tile's pixels, with its last chunk.
    pixels: Option<u64>,
}

/// One core.
#[derive(Debug)]
pub(super) struct Core {
    pub qsu: Ledger,
    pub bsu: Ledger,
    pub vru: Ledger,
    /// What QSU, BSU (when it does not sort) and VRU do since `since`.
    states: [State; 3],
    since: u64,
    front: Front,
    middle: Option<Middle>,
    waiting: VecDeque<Item>,
    /// The chunk that is rendered, and the cycle in which it is done.
    rendering: Option<(Item, u64)>,
    /// Pixels that wait for room.
    finished: Option<u64>,
    sorter_free: u64,
    features: Room,
    pixels: Room,
    /// Pixel writes under way: when they have left, bytes.
    writing: VecDeque<(u64, u64)>,
    end: u64,
}

impl Core {
    pub fn new(core: u32, design: &Design) -> Self {
        Self {
            qsu: Ledger::new(Qsu::NAME, core),
            bsu: Ledger::new(Bsu::NAME, core),
            vru: Ledger::new(Vru::NAME, core),
            states: [State::Idle; 3],
            since: 0,
            front: Front::new(design.shares.sorting),
            middle: None,
            waiting: VecDeque::new(),
            rendering: None,
            finished: None,
            sorter_free: 0,
            features: Room::new(design.shares.feature),
            pixels: Room::new(design.shares.pixel_out),
            writing: VecDeque::new(),
            end: 0,
        }
    }

    fn give_back(&mut self, now: u64) {
        while let Some((_, bytes)) = self.writing.pop_front_if(|w| w.0 <= now) {
            self.pixels.release(bytes);
        }
        self.front.release_sorted(now);
        if let Some((item, _)) = self.rendering.take_if(|r| r.1 <= now) {
            self.features.release(item.bytes);
            self.finished = item.pixels;
        }
    }

    fn write_pixels<O>(&mut self, now: u64, shared: &mut Shared<O>) {
        if let Some(bytes) = self.finished.take_if(|bytes| self.pixels.admits(*bytes)) {
            self.pixels.fill(bytes);
            let left = shared.channel.write(now, Stage::Rendering, bytes);
            self.writing.push_back((left, bytes));
            self.end = self.end.max(left);
        }
    }

    fn render(&mut self, now: u64) {
        if self.rendering.is_none() && self.finished.is_none() {
            self.rendering = self
                .waiting
                .pop_front_if(|item| item.ready <= now)
                .map(|item| (item, now + item.cycles));
        }
    }

    /// Sends what the middle and then the front have, as far as there is room.
    fn send<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        loop {
            if self.middle.is_none() {
                let Some(tile) = self.front.hand_over() else { return };
                self.middle = Some(Middle { tile, next_chunk: 0 });
            }
            let Some(middle) = self.middle.take() else { return };
            self.middle = self.send_tile(middle, now, shared);
            if self.middle.is_some() {
                return;
            }
        }
    }

    /// Gives the tile back if some of it has to stay.
    fn send_tile<O: Observer>(
        &mut self,
        mut middle: Middle,
        now: u64,
        shared: &mut Shared<O>,
    ) -> Option<Middle> {
        let workload = shared.workload;
        let work = &workload.tiles[middle.tile.tile as usize];
        let resident = shared.design.qsu.resident(middle.tile.list);
        if work.chunks == 0 {
            if !self.waiting.is_empty() {
                return Some(middle);
            }
            self.front.release_now(resident);
            let vru = &shared.design.vru;
            let cycles = vru.cycles(&Render { last: Some(*work), ..Render::default() });
            self.waiting.push_back(Item {
                tile: middle.tile.tile,
                cycles,
                features: now,
                ready: now + 1,
                bytes: 0,
                pixels: Some(vru.pixel_bytes(work)),
            });
            return None;
        }
        while middle.next_chunk < work.chunks {
            let bytes = self.chunk_bytes(&middle, shared);
            if !self.features.admits(bytes) {
                return Some(middle);
            }
            self.send_chunk(&middle, bytes, now, shared);
            middle.next_chunk += 1;
        }
        self.front.release_at(self.sorter_free, resident);
        None
    }

    fn chunk_bytes<O>(&self, middle: &Middle, shared: &Shared<O>) -> u64 {
        let tile = &shared.workload.tiles[middle.tile.tile as usize];
        let chunk = &chunks_of(shared.workload, tile)[middle.next_chunk as usize];
        u64::from(chunk.entries) * shared.design.vru.feature
    }

    fn send_chunk<O: Observer>(
        &mut self,
        middle: &Middle,
        bytes: u64,
        now: u64,
        shared: &mut Shared<O>,
    ) {
        let (design, index) = (shared.design, middle.tile.tile);
        let tile = &shared.workload.tiles[index as usize];
        let chunk = &chunks_of(shared.workload, tile)[middle.next_chunk as usize];
        let last = (middle.next_chunk + 1 == tile.chunks).then_some(*tile);
        let features = shared.channel.read(now, Stage::Rendering, chunk_read(chunk, design));
        let sort_start = self.sorter_free.max(now);
        self.sorter_free = sort_start + design.bsu.cycles(chunk);
        self.bsu.book(State::Busy(index), sort_start, self.sorter_free, shared.observer);
        self.features.fill(bytes);
        self.waiting.push_back(Item {
            tile: index,
            cycles: design.vru.cycles(&Render { chunk: *chunk, last }),
            features,
            ready: features.max(self.sorter_free),
            bytes,
            pixels: last.map(|tile| design.vru.pixel_bytes(&tile)),
        });
    }

    fn states(&self, now: u64) -> [State; 3] {
        let vru = match (&self.rendering, self.finished, self.waiting.front()) {
            (Some((item, _)), _, _) => State::Busy(item.tile),
            (None, Some(_), _) => State::Stalled(Stall::Output),
            (None, None, Some(item)) if item.features > now => State::Stalled(Stall::Features),
            (None, None, Some(_)) => State::Stalled(Stall::Input),
            (None, None, None) => self.front.wait(now),
        };
        let bsu = match self.middle {
            Some(_) => State::Stalled(Stall::Output),
            None => self.front.wait(now),
        };
        [self.front.state(now), bsu, vru]
    }

    fn wake(&self, now: u64) -> u64 {
        let vru = match (&self.rendering, self.finished, self.waiting.front()) {
            (Some((_, end)), _, _) => *end,
            (None, Some(_), _) => self.writing.front().map_or(NEVER, |w| w.0),
            (None, None, Some(item)) if item.features > now => item.features,
            (None, None, Some(item)) => item.ready,
            (None, None, None) => NEVER,
        };
        vru.min(self.front.wake(now))
    }
}

impl<O: Observer> Agent<O> for Core {
    fn step(&mut self, now: u64, shared: &mut Shared<O>) -> u64 {
        self.end = self.end.max(now);
        self.give_back(now);
        self.write_pixels(now, shared);
        self.render(now);
        self.front.advance(now, shared);
        self.send(now, shared);
        self.front.fetch(now, shared);
        self.states = self.states(now);
        self.wake(now)
    }

    fn account(&mut self, now: u64, observer: &mut O) {
        let [qsu, bsu, vru] = self.states;
        self.qsu.book(qsu, self.since, now, observer);
        self.bsu.book(bsu, self.since.max(self.sorter_free), now, observer);
        self.vru.book(vru, self.since, now, observer);
        self.since = now;
    }

    fn end(&self) -> u64 {
        self.end
    }
}
