//! Engines: raster, tail unit and composing unit, one behind the other.
//!
//! An engine has a region (or a depth slice of one) that it works on, and the next one, whose
//! chunks it may ask for already. In a cycle each of its parts does at most one thing, from the
//! back to the front:
//!
//! 1. **Output**, region by region: pixels are written, and leave the buffer when they are. Of a
//!    region in slices, the engine that ends the last one puts them together and writes the pixels.
//!    With `compose.through = "dram"` the other engines write their slices as soon as they have
//!    ended, and the last one reads them when they are all written. With `"stores"` slices stay in
//!    the buffers of their engines until the region is put together.
//! 2. **Tail**, in this order: the chunk that it works on ends and leaves its buffer;
//!    `tail.latency` cycles behind the last one the region goes to the output; the oldest chunk
//!    that can go on does (step 4); the next chunk begins, if it is there, and takes an evaluation
//!    of each pixel that has not stopped, as many a cycle as there are lanes, and a cycle for each
//!    Gaussian at least; the next chunk of the region is asked for, if the unit has fewer than two
//!    and the buffer admits it.
//! 3. **Raster, end**: chunks that their region does not need any more leave the buffer as soon as
//!    what was asked for is there; then a chunk that is done leaves it. Behind the last one, or
//!    behind the one with which the last pixel stops (`saturation`: chunks that follow are not
//!    needed), the region ends `latency` cycles later and goes to the tail unit, once that is free
//!    and the list is in order, or to the output, if the tail unit has nothing of it.
//! 4. **Chunks**, the oldest that can go on: one whose entries have arrived asks for what they
//!    name; one whose records have arrived is converted (`front.lazy`), one chunk after the other,
//!    and is there `front.latency` cycles after that.
//! 5. **Raster, begin**: it takes the room for the pixels of the next region, if it has none; or
//!    the first of its chunks begins, if that is there and is needed.
//! 6. **Fetch**: the next chunk of the region that is fetched, if the list is in order and the
//!    buffer admits it; behind the last chunk the next region is taken, if fewer than two are in
//!    front of the tail. With slices in `"stores"`, an engine takes no second slice of a region
//!    that it still has.

use std::collections::VecDeque;

use super::layout::Place;
use super::stages::{
    COMPOSE, GAUSSIANS, PIXELS, RASTER, TAIL, TAIL_IN, WAITS_COMPOSITION, WAITS_CONVERSION,
    WAITS_FEATURES, WAITS_OTHERS, WAITS_SLICES, WAITS_TAIL,
};
use super::work::RegionEntry;
use super::{ComposePath, RegionShared};
use crate::kernel::BufferUse;
use crate::kernel::buffer::{BufferAllocator, usage};
use crate::kernel::ledger::Account;
use crate::kernel::memory::{Arrival, NEVER};
use crate::kernel::timeline::{Observer, State};
use crate::stage::Stall;

/// A region, or a depth slice of one, on its way through an engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Job {
    region: u32,
    /// Entries of the raster, and of the tail, by their places in all entries.
    raster: [u32; 2],
    tail: [u32; 2],
}

/// Where a chunk is.
#[derive(Debug, Clone, Copy)]
enum ChunkAt {
    Entries(Arrival),
    Named(Arrival),
    Convert(u64),
    Here,
}

#[derive(Debug, Clone, Copy)]
struct Chunk {
    job: Job,
    first: u32,
    count: u32,
    at: ChunkAt,
    dropped: bool,
}

/// What the raster does with the region that it has.
#[derive(Debug, Clone, Copy)]
enum Raster {
    /// The room for its pixels is not there yet.
    Waits,
    /// A chunk until this cycle, or none.
    Chunks(Option<u64>),
    /// Its pixels are there in this cycle.
    Drains(u64),
}

/// What the output does with a region.
#[derive(Debug, Clone, Copy)]
enum Output {
    Begins,
    /// Its slice is written.
    Slice(Arrival),
    /// Its slice stays until the region is put together.
    Held,
    /// The other slices are not all written.
    Waits,
    Reads(Arrival),
    Composes(u64),
    Writes(Arrival),
}

/// An engine.
#[derive(Debug)]
pub struct Engine {
    owner: u32,
    /// Regions in front of the tail: at most two, the first of which the raster has.
    jobs: VecDeque<Job>,
    raster: Raster,
    /// The next entry that is asked for, of the last of `jobs`.
    fetched: u32,
    chunks: VecDeque<Chunk>,
    tail: Option<Tailing>,
    output: VecDeque<(Job, Output)>,
    gaussians: BufferAllocator,
    tail_in: BufferAllocator,
    pixels: BufferAllocator,
    /// Raster, tail, composing: those that the machine has.
    pub accounts: [Option<Account>; 3],
    pub end: u64,
    pub counts: EngineCounts,
}

/// A region in the tail unit.
#[derive(Debug)]
struct Tailing {
    job: Job,
    fetched: u32,
    chunks: VecDeque<Chunk>,
    works: Option<u64>,
    drains: Option<u64>,
}

/// What engines did.
#[derive(Debug, Clone, Copy, Default)]
pub struct EngineCounts {
    /// Evaluations by pixels that have not stopped, and by others.
    pub live: u64,
    pub stopped: u64,
    /// Gaussians that were converted late.
    pub converted: u64,
    /// Bytes that were asked for by the raster and by the tail unit.
    pub asked: [u64; 2],
    /// Bytes that the raster worked on.
    pub used: u64,
    /// Evaluations that read a pixel and wrote it.
    pub touched: u64,
    /// Pixels that were put together.
    pub composed: u64,
    /// Rows whose ends were found.
    pub rows: u64,
}

impl Engine {
    pub fn new(owner: u32, instance: u32, shares: [u64; 3], has: [bool; 3]) -> Engine {
        let account = |stage, has: bool| has.then(|| Account::new(stage, instance));
        let [gaussians, tail_in, pixels] = shares.map(BufferAllocator::new);
        Engine {
            owner,
            jobs: VecDeque::new(),
            raster: Raster::Waits,
            fetched: 0,
            chunks: VecDeque::new(),
            tail: None,
            output: VecDeque::new(),
            gaussians,
            tail_in,
            pixels,
            accounts: [account(RASTER, has[0]), account(TAIL, has[1]), account(COMPOSE, has[2])],
            end: 0,
            counts: EngineCounts::default(),
        }
    }

    /// The buffers of all engines.
    pub fn buffers(all: &[Engine]) -> [BufferUse; 3] {
        [
            usage(GAUSSIANS, all.iter().map(|engine| &engine.gaussians)),
            usage(TAIL_IN, all.iter().map(|engine| &engine.tail_in)),
            usage(PIXELS, all.iter().map(|engine| &engine.pixels)),
        ]
    }

    /// Books its cycles up to now.
    pub fn account(&mut self, now: u64, observer: &mut impl Observer) {
        self.accounts.iter_mut().flatten().for_each(|account| account.up_to(now, observer));
    }

    pub fn step<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> u64 {
        self.account(now, shared.observer);
        // From the back to the front: what a part frees can be used by the next in the same cycle.
        let acted = [
            self.put_out(now, shared),
            self.finish(now, shared),
            self.end_chunk(now, shared),
            self.end_region(now, shared),
            self.bring(now, shared),
            self.begin(now, shared),
            self.fetch(now, shared),
        ];
        let states = self.states(now, shared);
        for (account, state) in self.accounts.iter_mut().zip(states) {
            account.iter_mut().for_each(|account| account.is(state));
        }
        let is_idle = self.jobs.is_empty() && self.tail.is_none() && self.output.is_empty();
        match acted.contains(&true) {
            // Nothing is left, for others neither.
            _ if is_idle && self.chunks.is_empty() && shared.jobs_left() == 0 => NEVER,
            true => now + 1,
            false => self.wake(now, shared),
        }
    }

    /// The pixels of a region in the buffer.
    fn room<O: Observer>(job: &Job, shared: &RegionShared<O>) -> u64 {
        let pixels = shared.frame.regions[job.region as usize].pixels;
        u64::from(pixels) * shared.machine.raster.pixel_state.0
    }

    /// Step 1.
    fn put_out<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let Some((job, at)) = self.output.front().copied() else { return false };
        let region = shared.frame.regions[job.region as usize];
        let (pixels, first) = (u64::from(region.pixels), shared.first_pixel[job.region as usize]);
        let (room, slices) = (Engine::room(&job, shared), shared.machine.region.slices);
        let write = |engine: &Engine, shared: &mut RegionShared<O>| {
            let bytes = pixels * shared.machine.gaussian.pixel.0;
            let place = shared.layout().pixels(first, bytes);
            Output::Writes(shared.issue(now, engine.owner, shared.streams.pixels, bytes, place))
        };
        let next = match at {
            Output::Begins if slices == 1 => write(self, shared),
            Output::Begins => {
                let path = shared.machine.compose.through;
                let of_region = &mut shared.slices[job.region as usize];
                // Slices lie in the order in which they ended; the last to end puts them together.
                let place = first * u64::from(slices) + u64::from(of_region.ended) * pixels;
                of_region.ended += 1;
                match (of_region.ended == slices, path) {
                    (false, ComposePath::Dram) => {
                        let place = shared.layout().slices(place, room);
                        let stream = shared.streams.slices_out;
                        Output::Slice(shared.issue(now, self.owner, stream, room, place))
                    }
                    (false, ComposePath::Stores) => Output::Held,
                    (true, ComposePath::Dram) => Output::Waits,
                    (true, ComposePath::Stores) => {
                        // Who holds a slice waits for something else from now on.
                        shared.woken = true;
                        self.compose(now, pixels, shared)
                    }
                }
            }
            Output::Waits if shared.slices[job.region as usize].written + 1 == slices => {
                let others = room * u64::from(slices - 1);
                let place = shared.layout().slices(first * u64::from(slices), others);
                let stream = shared.streams.slices_in;
                Output::Reads(shared.issue(now, self.owner, stream, others, place))
            }
            Output::Reads(arrival) if shared.memory.at(arrival) <= now => {
                self.compose(now, pixels, shared)
            }
            Output::Composes(until) if until <= now => {
                shared.slices[job.region as usize].composed = true;
                shared.woken = true;
                write(self, shared)
            }
            Output::Held if shared.slices[job.region as usize].composed => {
                self.pixels.release(now, room);
                self.end = now;
                self.output.pop_front();
                return true;
            }
            Output::Slice(arrival) | Output::Writes(arrival)
                if shared.memory.at(arrival) <= now =>
            {
                if let Output::Slice(_) = at {
                    shared.slices[job.region as usize].written += 1;
                    shared.woken = true;
                }
                self.pixels.release(now, room);
                self.end = now;
                self.output.pop_front();
                return true;
            }
            _ => return false,
        };
        self.output[0].1 = next;
        true
    }

    fn compose<O: Observer>(&mut self, now: u64, pixels: u64, shared: &RegionShared<O>) -> Output {
        let composed = pixels * u64::from(shared.machine.region.slices - 1);
        self.counts.composed += composed;
        let lanes = u64::from(shared.machine.compose.lanes.max(1));
        Output::Composes(now + composed.div_ceil(lanes))
    }

    /// Step 2.
    fn finish<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let Some(tail) = &mut self.tail else { return false };
        let mut acted = false;
        if let Some(until) = tail.works.filter(|&until| until <= now) {
            let chunk = tail.chunks.pop_front().expect("it works on one");
            self.tail_in.release(now, shared.chunk_bytes(chunk.count));
            tail.works = None;
            acted = true;
            if chunk.first + chunk.count == tail.job.tail[1] {
                tail.drains = Some(until + u64::from(shared.machine.tail.latency));
            }
        }
        if tail.drains.is_some_and(|cycle| cycle <= now) {
            self.output.push_back((tail.job, Output::Begins));
            self.tail = None;
            return true;
        }
        acted |= advance(&mut tail.chunks, now, self.owner, shared, &mut self.counts, 1);
        if tail.works.is_none()
            && let Some(Chunk { at: ChunkAt::Here, first, count, .. }) = tail.chunks.front()
        {
            let entries = &shared.frame.entries[*first as usize..][..*count as usize];
            let live: u64 = entries.iter().map(|entry| u64::from(entry.live)).sum();
            self.counts.live += live;
            self.counts.touched += live;
            self.counts.rows += entries.iter().map(|entry| u64::from(entry.rows)).sum::<u64>();
            let lanes = u64::from(shared.machine.tail.lanes);
            tail.works = Some(now + live.div_ceil(lanes).max(u64::from(*count)));
            acted = true;
        }
        let [_, end] = tail.job.tail;
        if tail.fetched < end && tail.chunks.len() < 2 {
            let count = (end - tail.fetched).min(shared.machine.raster.chunk);
            let bytes = shared.chunk_bytes(count);
            if self.tail_in.admits(bytes) {
                self.tail_in.fill(now, bytes);
                self.counts.asked[1] += entry_bytes(count, shared);
                tail.chunks.push_back(ask(tail.job, tail.fetched, count, now, self.owner, shared));
                tail.fetched += count;
                acted = true;
            }
        }
        acted
    }

    /// Step 3: a chunk.
    fn end_chunk<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let mut acted = false;
        let (gaussians, chunks, end) = (&mut self.gaussians, &mut self.chunks, &mut self.end);
        chunks.retain(|chunk| {
            let is_here = match chunk.at {
                ChunkAt::Entries(arrival) | ChunkAt::Named(arrival) => {
                    shared.memory.at(arrival) <= now
                }
                ChunkAt::Convert(until) => until <= now,
                ChunkAt::Here => true,
            };
            let leaves = chunk.dropped && is_here;
            if leaves {
                gaussians.discard(now, shared.chunk_bytes(chunk.count));
                (acted, *end) = (true, now);
            }
            !leaves
        });
        let Raster::Chunks(Some(until)) = self.raster else { return acted };
        if until > now {
            return acted;
        }
        let chunk = self.chunks.pop_front().expect("it works on one");
        self.gaussians.release(now, shared.chunk_bytes(chunk.count));
        let job = self.jobs[0];
        let done = chunk.first + chunk.count;
        let region = &shared.frame.regions[job.region as usize];
        let is_opaque = shared.machine.raster.saturation && done - region.start >= region.saturated;
        self.raster = match done == job.raster[1] || is_opaque {
            false => Raster::Chunks(None),
            true => {
                if is_opaque {
                    self.leave(done);
                }
                Raster::Drains(now + u64::from(shared.machine.raster.latency))
            }
        };
        true
    }

    /// Takes what is behind `done` off the region of the raster.
    fn leave(&mut self, done: u32) {
        let job = &mut self.jobs[0];
        for chunk in self.chunks.iter_mut().filter(|chunk| chunk.job == *job) {
            chunk.dropped = true;
        }
        // Chunks know the region by what it was.
        (job.raster[1], job.tail[0]) = (done, job.tail[1]);
    }

    /// Step 3: a region.
    fn end_region<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let Raster::Drains(until) = self.raster else { return false };
        if until > now {
            return false;
        }
        let job = self.jobs[0];
        let [first, end] = job.tail;
        if first < end {
            if self.tail.is_some() || !shared.is_ready[job.region as usize] {
                return false;
            }
            let chunks = VecDeque::new();
            self.tail = Some(Tailing { job, fetched: first, chunks, works: None, drains: None });
        } else {
            self.output.push_back((job, Output::Begins));
        }
        self.jobs.pop_front();
        self.raster = Raster::Waits;
        true
    }

    /// Step 4.
    fn bring<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        advance(&mut self.chunks, now, self.owner, shared, &mut self.counts, 0)
    }

    /// Step 5.
    fn begin<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        let Some(job) = self.jobs.front().copied() else { return false };
        match self.raster {
            Raster::Waits => {
                let room = Engine::room(&job, shared);
                if !self.pixels.admits(room) {
                    return false;
                }
                self.pixels.fill(now, room);
                // A region without entries for the raster still has pixels, and may have a tail.
                self.raster = match job.raster[0] == job.raster[1] {
                    true => Raster::Drains(now),
                    false => Raster::Chunks(None),
                };
                true
            }
            Raster::Chunks(None) => {
                let head = self.chunks.front().filter(|chunk| !chunk.dropped && chunk.job == job);
                let Some(Chunk { at: ChunkAt::Here, first, count, .. }) = head else {
                    return false;
                };
                let entries = &shared.frame.entries[*first as usize..][..*count as usize];
                let sum = |of: fn(&RegionEntry) -> u32| -> u64 {
                    entries.iter().map(|entry| u64::from(of(entry))).sum()
                };
                let (pixels, live) = (sum(|e| e.pixels), sum(|e| e.live));
                self.counts.live += live;
                self.counts.stopped += pixels - live;
                self.counts.touched += pixels;
                self.counts.used += shared.chunk_bytes(*count);
                self.counts.rows += sum(|e| e.rows);
                let cycles: u64 = entries.iter().map(|e| shared.machine.entry_cycles(e)).sum();
                self.raster = Raster::Chunks(Some(now + cycles.max(1)));
                true
            }
            Raster::Chunks(Some(_)) | Raster::Drains(_) => false,
        }
    }

    /// Step 6.
    fn fetch<O: Observer>(&mut self, now: u64, shared: &mut RegionShared<O>) -> bool {
        if let Some(job) = self.jobs.back().copied()
            && self.fetched < job.raster[1]
        {
            if !shared.is_ready[job.region as usize] {
                return false;
            }
            let count = (job.raster[1] - self.fetched).min(shared.machine.raster.chunk);
            let bytes = shared.chunk_bytes(count);
            if !self.gaussians.admits(bytes) {
                return false;
            }
            self.gaussians.fill(now, bytes);
            self.counts.asked[0] += entry_bytes(count, shared);
            self.chunks.push_back(ask(job, self.fetched, count, now, self.owner, shared));
            self.fetched += count;
            return true;
        }
        if self.jobs.len() == 2 {
            return false;
        }
        let Some(job) = next_job(shared) else { return false };
        let machine = shared.machine;
        if machine.region.slices > 1 && machine.compose.through == ComposePath::Stores {
            // Its buffer keeps a slice until the region is put together: it would wait for itself.
            let mut own = self.jobs.iter().chain(self.output.iter().map(|(job, _)| job));
            if own.any(|own| own.region == job.region) {
                return false;
            }
            // What is next for others is another one.
            shared.woken = true;
        }
        shared.next_job += 1;
        self.fetched = job.raster[0];
        self.jobs.push_back(job);
        true
    }

    fn states<O: Observer>(&self, now: u64, shared: &RegionShared<O>) -> [State; 3] {
        let is_read = |chunk: &Chunk| match chunk.at {
            ChunkAt::Entries(arrival) | ChunkAt::Named(arrival) => shared.memory.at(arrival) > now,
            ChunkAt::Convert(_) | ChunkAt::Here => false,
        };
        let raster = match (self.jobs.front(), self.raster) {
            (None, _) => State::Idle,
            (Some(_), Raster::Waits) => State::Stalled(match self.output.front() {
                Some((held, Output::Held)) => {
                    let ended = shared.slices[held.region as usize].ended;
                    let is_whole = ended == shared.machine.region.slices;
                    if is_whole { WAITS_COMPOSITION } else { WAITS_OTHERS }
                }
                _ => Stall::OUTPUT,
            }),
            (Some(job), Raster::Chunks(Some(_))) => State::Busy(job.region),
            (Some(job), Raster::Drains(until)) if until > now => State::Busy(job.region),
            (Some(job), Raster::Drains(_)) => {
                let is_ready = shared.is_ready[job.region as usize];
                State::Stalled(if is_ready { WAITS_TAIL } else { Stall::INPUT })
            }
            (Some(job), Raster::Chunks(None)) => {
                match self.chunks.iter().find(|chunk| chunk.job == *job) {
                    Some(chunk) if is_read(chunk) => State::Stalled(WAITS_FEATURES),
                    Some(Chunk { at: ChunkAt::Convert(_), .. }) => State::Stalled(WAITS_CONVERSION),
                    _ => State::Stalled(Stall::INPUT),
                }
            }
        };
        let tail = match &self.tail {
            None => State::Idle,
            Some(tail) if tail.works.is_some() || tail.drains.is_some() => {
                State::Busy(tail.job.region)
            }
            Some(_) => State::Stalled(WAITS_FEATURES),
        };
        let compose = match self.output.front() {
            Some((job, Output::Composes(_))) => State::Busy(job.region),
            Some((_, Output::Waits | Output::Reads(_))) => State::Stalled(WAITS_SLICES),
            _ => State::Idle,
        };
        [raster, tail, compose]
    }

    fn wake<O: Observer>(&self, now: u64, shared: &RegionShared<O>) -> u64 {
        let chunk = |chunk: &Chunk| match chunk.at {
            ChunkAt::Entries(arrival) | ChunkAt::Named(arrival) => shared.memory.at(arrival),
            ChunkAt::Convert(until) => until,
            ChunkAt::Here => NEVER,
        };
        let output = self.output.front().map(|(_, at)| match at {
            Output::Begins | Output::Held | Output::Waits => NEVER,
            Output::Slice(arrival) | Output::Reads(arrival) | Output::Writes(arrival) => {
                shared.memory.at(*arrival)
            }
            Output::Composes(until) => *until,
        });
        let raster = match self.raster {
            Raster::Chunks(Some(until)) | Raster::Drains(until) => until,
            Raster::Waits | Raster::Chunks(None) => NEVER,
        };
        let tail = self.tail.iter();
        let of_tail = tail.flat_map(|tail| {
            let own = [tail.works, tail.drains].into_iter().flatten();
            own.chain(tail.chunks.iter().map(chunk))
        });
        let all = self.chunks.iter().map(chunk).chain(output).chain([raster]).chain(of_tail);
        all.filter(|&cycle| cycle > now).min().unwrap_or(NEVER)
    }
}

/// The next region, or slice of one.
fn next_job<O: Observer>(shared: &RegionShared<O>) -> Option<Job> {
    let slices = shared.machine.region.slices;
    let (region, slice) = (shared.next_job / slices, shared.next_job % slices);
    let facts = shared.frame.regions.get(region as usize)?;
    let cut = |slice: u32| {
        let entries = u64::from(facts.entries) * u64::from(slice) / u64::from(slices);
        facts.start + entries as u32
    };
    let [first, end] = [cut(slice), cut(slice + 1)];
    let middle = first + shared.machine.front_part(end - first);
    Some(Job { region, raster: [first, middle], tail: [middle, end] })
}

/// Bytes of some entries.
fn entry_bytes<O: Observer>(count: u32, shared: &RegionShared<O>) -> u64 {
    u64::from(count) * shared.machine.gaussian.entry.0
}

/// Asks for the entries of a chunk.
fn ask<O: Observer>(
    job: Job,
    first: u32,
    count: u32,
    now: u64,
    owner: u32,
    shared: &mut RegionShared<O>,
) -> Chunk {
    let bytes = entry_bytes(count, shared);
    let place = shared.layout().ordered(u64::from(first), bytes);
    let arrival = shared.issue(now, owner, shared.streams.entries, bytes, place);
    Chunk { job, first, count, at: ChunkAt::Entries(arrival), dropped: false }
}

/// Takes the first chunk on that has something to do; whether one had.
fn advance<O: Observer>(
    chunks: &mut VecDeque<Chunk>,
    now: u64,
    owner: u32,
    shared: &mut RegionShared<O>,
    counts: &mut EngineCounts,
    part: usize,
) -> bool {
    let lazy = shared.machine.front.lazy;
    // All units of the front convert one chunk together, and then the next (A119).
    let is_converting =
        chunks.iter().any(|chunk| matches!(chunk.at, ChunkAt::Convert(until) if until > now));
    for chunk in chunks.iter_mut().filter(|chunk| !chunk.dropped) {
        let at = match chunk.at {
            ChunkAt::Entries(arrival) if shared.memory.at(arrival) <= now => {
                let bytes = u64::from(chunk.count) * shared.machine.fetched();
                let (first, entries) = (u64::from(chunk.first), u64::from(chunk.count));
                let place = Place::Named { first, entries };
                counts.asked[part] += bytes;
                ChunkAt::Named(shared.issue(now, owner, shared.streams.features, bytes, place))
            }
            ChunkAt::Named(arrival) if shared.memory.at(arrival) <= now && !lazy => ChunkAt::Here,
            ChunkAt::Named(arrival) if shared.memory.at(arrival) <= now && !is_converting => {
                let gaussians = u64::from(chunk.count);
                counts.converted += gaussians;
                let front = &shared.machine.front;
                let until = now + front.converting(gaussians);
                shared.conversions.push([now, until]);
                ChunkAt::Convert(until + u64::from(front.latency))
            }
            ChunkAt::Convert(until) if until <= now => ChunkAt::Here,
            _ => continue,
        };
        chunk.at = at;
        return true;
    }
    false
}
