//! The middle of a core: sends the chunks of one job into the feature buffer and to the sorter.

use super::Shared;
use super::core::{Core, Item};
use super::front::FrontJob;
use crate::accel::bsu::Sort;
use crate::accel::layout::{Layout, Span};
use crate::accel::schedule::{Job, SortFront};
use crate::accel::timeline::{Observer, State};
use crate::accel::traffic::Load;
use crate::accel::unit::Unit;
use crate::accel::vru::Render;
use crate::accel::{Stall, memory::Arrival};
use crate::action::{Action, Stage};
use crate::workload::TileWork;

/// A job in the middle.
#[derive(Debug)]
pub(super) struct Middle {
    held: FrontJob,
    /// Tile of the job, and its chunk, that are sent next.
    next_tile: u32,
    next_chunk: u32,
    sorted: SortFront,
    /// Chunks of this tile that were sent although nobody needs them.
    speculated: u32,
}

impl Middle {
    fn new(held: FrontJob) -> Self {
        let sorted = SortFront::default();
        Self { held, next_tile: 0, next_chunk: 0, sorted, speculated: 0 }
    }

    fn next_tile(&mut self) {
        (self.next_tile, self.next_chunk, self.speculated) = (self.next_tile + 1, 0, 0);
    }
}

impl Core {
    /// Sends what the middle and then the front have, as far as there is room.
    pub fn send<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        loop {
            let front = &mut self.front;
            let Some(mut middle) =
                self.middle.take().or_else(|| front.hand_over().map(Middle::new))
            else {
                return;
            };
            if !self.send_job(&mut middle, now, shared) {
                self.middle = Some(middle);
                return;
            }
        }
    }

    /// Says whether all of the job has been sent.
    fn send_job<O: Observer>(
        &mut self,
        middle: &mut Middle,
        now: u64,
        shared: &mut Shared<O>,
    ) -> bool {
        let (plan, workload) = (shared.plan, shared.workload);
        let job = &plan.jobs[middle.held.job as usize];
        while let Some(&index) = plan.tiles_of(job).get(middle.next_tile as usize) {
            let tile = &workload.tiles[index as usize];
            let sent = match tile.chunks {
                0 => self.send_empty(index, job, now, shared),
                _ => self.send_tile(index, middle, job, now, shared),
            };
            if !sent {
                return false;
            }
            middle.next_tile();
            self.is_open = false;
        }
        let resident = shared.design.qsu.resident(&job.keys);
        self.front.release_at(now, self.sorter_free, resident);
        if job.kept > 0 {
            let span = |layout: &Layout| layout.list(job.list_start, job.kept);
            let left = shared.write(now, self.owner, Stage::Sorting, job.kept, span);
            self.note(left, shared);
        }
        true
    }

    /// A tile without chunks goes through when no chunk waits.
    fn send_empty<O>(&mut self, tile: u32, job: &Job, now: u64, shared: &Shared<O>) -> bool {
        if !self.waiting.is_empty() {
            return false;
        }
        let (vru, work) = (&shared.design.vru, shared.workload.tiles[tile as usize]);
        let drains = shared.drains(job, tile);
        let render = Render { last: Some(work), drains, ..Render::default() };
        self.waiting.push_back(Item {
            tile,
            cycles: vru.cycles(&render),
            stalls: vru.bank_stalls(&render),
            features: Arrival::NOW,
            sorted: now + 1,
            bytes: 0,
            pixels: Some(vru.pixel_bytes(&work)),
            speculative: false,
        });
        true
    }

    /// Sends the chunks of a tile, needed ones and others; says whether that was all.
    fn send_tile<O: Observer>(
        &mut self,
        index: u32,
        middle: &mut Middle,
        job: &Job,
        now: u64,
        shared: &mut Shared<O>,
    ) -> bool {
        let tile = &shared.workload.tiles[index as usize];
        while middle.next_chunk < tile.chunks {
            let chunk = tile.chunk_start + middle.next_chunk;
            let bytes = shared.design.vru.chunk_bytes(&shared.workload.chunks[chunk as usize]);
            if !self.features.admits(bytes) {
                return false;
            }
            let sort = middle.sorted.next(shared.workload, job, tile, middle.next_chunk);
            self.send_chunk(
                (index, middle.next_chunk),
                sort,
                shared.drains(job, index),
                now,
                shared,
            );
            middle.next_chunk += 1;
        }
        self.speculate(index, tile, middle, job, now, shared)
    }

    fn send_chunk<O: Observer>(
        &mut self,
        (index, position): (u32, u32),
        sort: Sort,
        drains: bool,
        now: u64,
        shared: &mut Shared<O>,
    ) {
        let (design, workload) = (shared.design, shared.workload);
        let tile = &workload.tiles[index as usize];
        let at = (tile.chunk_start + position) as usize;
        let (chunk, load) = (workload.chunks[at], Load::new(workload, at, design, &shared.given));
        let last = (position + 1 == tile.chunks).then_some(*tile);
        let render = Render { chunk, last, drains: drains && last.is_some() };
        let start = u64::from(tile.list_start + position * workload.geometry.chunk);
        let span = Span::Chunk { start, entries: u64::from(chunk.entries), load };
        let bytes = design.vru.chunk_bytes(&chunk);
        let item = Item {
            tile: index,
            cycles: design.vru.cycles(&render),
            stalls: design.vru.bank_stalls(&render),
            features: shared.read(now, self.owner, Stage::Rendering, load.bytes(design), |_| span),
            sorted: self.sort(index, sort, now, shared),
            bytes,
            pixels: last.map(|tile| design.vru.pixel_bytes(&tile)),
            speculative: false,
        };
        self.is_open = last.is_some();
        self.features.fill(now, bytes);
        self.waiting.push_back(item);
    }

    /// Queues a sort; returns when it is done.
    fn sort<O: Observer>(
        &mut self,
        tile: u32,
        sort: Sort,
        now: u64,
        shared: &mut Shared<O>,
    ) -> u64 {
        let bsu = &shared.design.bsu;
        let start = self.sorter_free.max(now);
        let busy = start + bsu.cycles(&sort);
        self.sorter_free = busy + bsu.bank_stalls(&sort);
        // A frame is over when its last sort is, even one in vain.
        self.end = self.end.max(self.sorter_free);
        self.bsu.book(State::Busy(tile), start, busy, shared.observer);
        self.bsu.book(State::Stalled(Stall::Bank), busy, self.sorter_free, shared.observer);
        self.sorter_free
    }

    /// Sends further chunks of a tile while nobody knows that they are not needed; says whether it
    /// is done with that.
    fn speculate<O: Observer>(
        &mut self,
        index: u32,
        tile: &TileWork,
        middle: &mut Middle,
        job: &Job,
        now: u64,
        shared: &mut Shared<O>,
    ) -> bool {
        let (design, chunk) = (shared.design, shared.workload.geometry.chunk);
        while self.is_open && middle.speculated < design.vru.spec.speculation {
            let sent = tile.loaded + middle.speculated * chunk;
            let entries = tile.entries.saturating_sub(sent).min(chunk);
            if entries == 0 {
                break;
            }
            let bytes = u64::from(entries) * design.vru.feature;
            if !self.features.admits(bytes) {
                return false;
            }
            // Of one level: that of the second follows when an entry is needed.
            let load = Load { features: u64::from(entries), ..Load::default() };
            let start = u64::from(tile.list_start + sent);
            let span = Span::Chunk { start, entries: u64::from(entries), load };
            // The keys of a group may be sorted already, or for another tile.
            let keys = if job.group.is_some() { 0 } else { u64::from(entries) };
            let sort = Sort { keys, filtered: u64::from(entries) - keys };
            design.bsu.charge(&sort, &mut self.speculation);
            design.vru.charge_unused(entries, &mut self.speculation);
            let read = load.bytes(design);
            self.speculation.charge(Stage::Rendering, Action::DramRead, read);
            let item = Item {
                tile: index,
                cycles: 0,
                stalls: 0,
                features: shared.read(now, self.owner, Stage::Rendering, read, |_| span),
                sorted: self.sort(index, sort, now, shared),
                bytes,
                pixels: None,
                speculative: true,
            };
            self.features.fill(now, bytes);
            self.waiting.push_back(item);
            middle.speculated += 1;
        }
        true
    }
}
