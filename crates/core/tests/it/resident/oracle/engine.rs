//! An engine with its tail and composing unit, counting down.

use std::collections::VecDeque;

use powergs_core::flow::resident::layout::Place;
use powergs_core::flow::resident::{ComposePath, Resident};

use super::{Room, World, digit};
use crate::oracle_memory::Ticket;

/// A region or a slice of one.
#[derive(Clone, Copy)]
struct Job {
    number: u32,
    region: usize,
    raster: (u32, u32),
    tail: (u32, u32),
}

enum Where {
    Entries(Ticket),
    Records(Ticket),
    /// Cycles of the front and of its pipeline.
    Converts(u64),
    Here,
}

struct Chunk {
    job: u32,
    first: u32,
    count: u32,
    at: Where,
    is_needed: bool,
}

enum Raster {
    NoRoom,
    Waits,
    Works(u64),
    Drains(u64),
}

enum Output {
    Begins,
    SliceOut(Ticket),
    Held,
    WaitsForOthers,
    SlicesIn(Ticket),
    Composes(u64),
    Pixels(Ticket),
}

struct Tail {
    job: Job,
    fetched: u32,
    chunks: VecDeque<Chunk>,
    works: Option<u64>,
    drains: Option<u64>,
}

pub struct Engine {
    jobs: VecDeque<Job>,
    raster: Raster,
    fetched: u32,
    chunks: VecDeque<Chunk>,
    tail: Option<Tail>,
    output: VecDeque<(Job, Output)>,
    gaussians: Room,
    tail_in: Room,
    pixels: Room,
    /// Why there is no room for the pixels of a region, if there is none.
    no_room: char,
}

/// Step 4: the oldest chunk that can go on.
fn go_on(chunks: &mut VecDeque<Chunk>, world: &mut World) {
    let is_busy = chunks.iter().any(|c| matches!(c.at, Where::Converts(left) if left > 0));
    for chunk in chunks.iter_mut().filter(|chunk| chunk.is_needed) {
        let (first, entries) = (u64::from(chunk.first), u64::from(chunk.count));
        chunk.at = match chunk.at {
            Where::Entries(ticket) if world.is_done(ticket) => {
                let bytes = entries * world.m.fetched();
                Where::Records(world.read("features", bytes, Place::Named { first, entries }))
            }
            Where::Records(ticket) if world.is_done(ticket) && !world.m.front.lazy => Where::Here,
            Where::Records(ticket) if world.is_done(ticket) && !is_busy => {
                let cycles = world.m.front.converting(entries);
                world.converts = (world.converts.0.wrapping_add(1), cycles);
                Where::Converts(cycles + u64::from(world.m.front.latency))
            }
            Where::Converts(0) => Where::Here,
            _ => continue,
        };
        return;
    }
}

fn ask(job: &Job, first: u32, count: u32, world: &mut World) -> Chunk {
    let bytes = u64::from(count) * world.m.gaussian.entry.0;
    let place = world.memory.layout.ordered(u64::from(first), bytes);
    let at = Where::Entries(world.read("entries", bytes, place));
    Chunk { job: job.number, first, count, at, is_needed: true }
}

fn bytes(count: u32, world: &World) -> u64 {
    world.m.chunk_bytes(u64::from(count))
}

impl Engine {
    pub fn new(m: &Resident) -> Engine {
        let of = |store| Room::share(store, m.raster.engines);
        Engine {
            jobs: VecDeque::new(),
            raster: Raster::NoRoom,
            fetched: 0,
            chunks: VecDeque::new(),
            tail: None,
            output: VecDeque::new(),
            gaussians: of(&m.stores.gaussians),
            tail_in: of(&m.stores.tail),
            pixels: of(&m.stores.pixels),
            no_room: 'o',
        }
    }

    pub fn is_done(&self) -> bool {
        let is_empty = self.jobs.is_empty() && self.output.is_empty() && self.chunks.is_empty();
        is_empty && self.tail.is_none()
    }

    pub fn step(&mut self, world: &mut World) {
        self.put_out(world);
        self.finish(world);
        self.end(world);
        go_on(&mut self.chunks, world);
        self.begin(world);
        self.fetch(world);
        // What it sees when it is its turn.
        self.no_room = match self.output.front() {
            Some((job, Output::Held)) => {
                if world.ended[job.region] == world.m.region.slices {
                    'k'
                } else {
                    'y'
                }
            }
            _ => 'o',
        };
    }

    fn put_out(&mut self, world: &mut World) {
        let Some((job, at)) = self.output.front_mut() else { return };
        let (m, region) = (world.m, job.region);
        let slices = m.region.slices;
        let others = u64::from(slices - 1);
        let pixels = u64::from(world.frame.regions[region].pixels);
        let before = &world.frame.regions[..region];
        let first: u64 = before.iter().map(|region| u64::from(region.pixels)).sum();
        let room = pixels * m.raster.pixel_state.0;
        let composing = (pixels * others).div_ceil(u64::from(m.compose.lanes).max(1));
        let pixels_out = |world: &mut World| {
            let bytes = pixels * m.gaussian.pixel.0;
            let place = world.memory.layout.pixels(first, bytes);
            Output::Pixels(world.write("pixels", bytes, place))
        };
        let slice = |world: &World, n: u64, count: u64| {
            let from = first * u64::from(slices) + n * pixels;
            world.memory.layout.slices(from, count * room)
        };
        *at = match *at {
            Output::Begins if slices == 1 => pixels_out(world),
            Output::Begins => {
                let n = u64::from(world.ended[region]);
                world.ended[region] += 1;
                let is_last = world.ended[region] == slices;
                match m.compose.through {
                    ComposePath::Stores if is_last => Output::Composes(composing),
                    ComposePath::Stores => Output::Held,
                    ComposePath::Dram if is_last => Output::WaitsForOthers,
                    ComposePath::Dram => {
                        let place = slice(world, n, 1);
                        Output::SliceOut(world.write("slices-out", room, place))
                    }
                }
            }
            Output::WaitsForOthers if u64::from(world.written[region]) == others => {
                let place = slice(world, 0, others);
                Output::SlicesIn(world.read("slices-in", others * room, place))
            }
            Output::SlicesIn(ticket) if world.is_done(ticket) => Output::Composes(composing),
            Output::Composes(0) => {
                world.composed[region] = true;
                pixels_out(world)
            }
            Output::SliceOut(ticket) if world.is_done(ticket) => {
                world.written[region] += 1;
                return self.leave_output(room);
            }
            Output::Held if world.composed[region] => return self.leave_output(room),
            Output::Pixels(ticket) if world.is_done(ticket) => return self.leave_output(room),
            _ => return,
        };
    }

    fn leave_output(&mut self, bytes: u64) {
        self.pixels.used -= bytes;
        self.output.pop_front();
    }

    fn finish(&mut self, world: &mut World) {
        let Some(tail) = &mut self.tail else { return };
        if tail.works == Some(0) {
            let chunk = tail.chunks.pop_front().expect("it works on it");
            self.tail_in.used -= bytes(chunk.count, world);
            tail.works = None;
            if chunk.first + chunk.count == tail.job.tail.1 {
                tail.drains = Some(u64::from(world.m.tail.latency));
            }
        }
        if tail.drains == Some(0) {
            self.output.push_back((tail.job, Output::Begins));
            self.tail = None;
            return;
        }
        go_on(&mut tail.chunks, world);
        if tail.works.is_none()
            && let Some(Chunk { at: Where::Here, first, count, .. }) = tail.chunks.front()
        {
            let entries = &world.frame.entries[*first as usize..(*first + *count) as usize];
            let live: u64 = entries.iter().map(|entry| u64::from(entry.live)).sum();
            let lanes = u64::from(world.m.tail.lanes);
            tail.works = Some(live.div_ceil(lanes).max(entries.len() as u64));
        }
        let count = (tail.job.tail.1 - tail.fetched).min(world.m.raster.chunk);
        let room = bytes(count, world);
        if count > 0 && tail.chunks.len() < 2 && self.tail_in.admits(room) {
            self.tail_in.used += room;
            tail.chunks.push_back(ask(&tail.job, tail.fetched, count, world));
            tail.fetched += count;
        }
    }

    fn end(&mut self, world: &mut World) {
        let gaussians = &mut self.gaussians;
        self.chunks.retain(|chunk| {
            let is_there = match chunk.at {
                Where::Entries(ticket) | Where::Records(ticket) => world.is_done(ticket),
                Where::Converts(left) => left == 0,
                Where::Here => true,
            };
            let leaves = !chunk.is_needed && is_there;
            gaussians.used -= if leaves { bytes(chunk.count, world) } else { 0 };
            !leaves
        });
        let latency = u64::from(world.m.raster.latency);
        if let Raster::Works(0) = self.raster {
            let chunk = self.chunks.pop_front().expect("it works on it");
            self.gaussians.used -= bytes(chunk.count, world);
            let job = &mut self.jobs[0];
            let region = &world.frame.regions[job.region];
            let done = chunk.first + chunk.count;
            let is_last = done == job.raster.1;
            self.raster = if is_last { Raster::Drains(latency) } else { Raster::Waits };
            if world.m.raster.saturation && done >= region.start + region.saturated {
                self.raster = Raster::Drains(latency);
                (job.raster.1, job.tail.0) = (done, job.tail.1);
                let of_job = self.chunks.iter_mut().filter(|chunk| chunk.job == job.number);
                of_job.for_each(|chunk| chunk.is_needed = false);
            }
        }
        if let Raster::Drains(0) = self.raster {
            let job = self.jobs[0];
            if job.tail.0 == job.tail.1 {
                self.output.push_back((job, Output::Begins));
            } else if self.tail.is_none() && world.in_order[job.region] {
                let (fetched, chunks) = (job.tail.0, VecDeque::new());
                self.tail = Some(Tail { job, fetched, chunks, works: None, drains: None });
            } else {
                return;
            }
            self.jobs.pop_front();
            self.raster = Raster::NoRoom;
        }
    }

    fn begin(&mut self, world: &mut World) {
        let Some(job) = self.jobs.front() else { return };
        match self.raster {
            Raster::NoRoom => {
                let pixels = u64::from(world.frame.regions[job.region].pixels);
                let room = pixels * world.m.raster.pixel_state.0;
                if self.pixels.admits(room) {
                    self.pixels.used += room;
                    let is_empty = job.raster.0 == job.raster.1;
                    self.raster = if is_empty { Raster::Drains(0) } else { Raster::Waits };
                }
            }
            Raster::Waits => {
                let Some(chunk) = self.chunks.front() else { return };
                if chunk.is_needed && chunk.job == job.number && matches!(chunk.at, Where::Here) {
                    let entries = &world.frame.entries[chunk.first as usize..];
                    let entries = &entries[..chunk.count as usize];
                    let cycles: u64 = entries.iter().map(|e| world.m.entry_cycles(e)).sum();
                    self.raster = Raster::Works(cycles.max(1));
                }
            }
            Raster::Works(_) | Raster::Drains(_) => {}
        }
    }

    fn fetch(&mut self, world: &mut World) {
        if let Some(job) = self.jobs.back().copied()
            && self.fetched < job.raster.1
        {
            let count = (job.raster.1 - self.fetched).min(world.m.raster.chunk);
            let room = bytes(count, world);
            if world.in_order[job.region] && self.gaussians.admits(room) {
                self.gaussians.used += room;
                self.chunks.push_back(ask(&job, self.fetched, count, world));
                self.fetched += count;
            }
            return;
        }
        let number = world.next_job;
        if self.jobs.len() == 2 || number == world.jobs() {
            return;
        }
        let slices = world.m.region.slices;
        let (region, slice) = ((number / slices) as usize, number % slices);
        let stays = slices > 1 && world.m.compose.through == ComposePath::Stores;
        let mut own = self.jobs.iter().chain(self.output.iter().map(|(job, _)| job));
        if stays && own.any(|job| job.region == region) {
            return;
        }
        world.next_job += 1;
        let facts = &world.frame.regions[region];
        let cut = |slice: u32| {
            let entries = u64::from(facts.entries) * u64::from(slice) / u64::from(slices);
            facts.start + entries as u32
        };
        let (first, end) = (cut(slice), cut(slice + 1));
        let middle = first + world.m.front_part(end - first);
        self.fetched = first;
        self.jobs.push_back(Job { number, region, raster: (first, middle), tail: (middle, end) });
    }

    pub fn tick(&mut self) {
        let less = |left: &mut u64| *left = left.saturating_sub(1);
        if let Raster::Works(left) | Raster::Drains(left) = &mut self.raster {
            less(left);
        }
        if let Some((_, Output::Composes(left))) = self.output.front_mut() {
            less(left);
        }
        let mut all: Vec<&mut Chunk> = self.chunks.iter_mut().collect();
        if let Some(tail) = &mut self.tail {
            tail.works.iter_mut().chain(&mut tail.drains).for_each(less);
            all.extend(&mut tail.chunks);
        }
        for chunk in all {
            if let Where::Converts(left) = &mut chunk.at {
                less(left);
            }
        }
    }

    pub fn raster_symbol(&self, world: &World) -> char {
        let Some(job) = self.jobs.front() else { return '.' };
        match self.raster {
            Raster::NoRoom => self.no_room,
            Raster::Works(_) => digit(job.region as u32),
            Raster::Drains(left) if left > 0 => digit(job.region as u32),
            Raster::Drains(_) if world.in_order[job.region] => 't',
            Raster::Drains(_) => 'i',
            Raster::Waits => match self.chunks.iter().find(|chunk| chunk.job == job.number) {
                Some(Chunk { at: Where::Entries(ticket) | Where::Records(ticket), .. })
                    if !world.is_done(*ticket) =>
                {
                    'f'
                }
                Some(Chunk { at: Where::Converts(_), .. }) => 'v',
                _ => 'i',
            },
        }
    }

    pub fn tail_symbol(&self) -> char {
        match &self.tail {
            None => '.',
            Some(tail) if tail.works.is_some() || tail.drains.is_some() => {
                digit(tail.job.region as u32)
            }
            Some(_) => 'f',
        }
    }

    pub fn compose_symbol(&self) -> char {
        match self.output.front() {
            Some((job, Output::Composes(_))) => digit(job.region as u32),
            Some((_, Output::WaitsForOthers | Output::SlicesIn(_))) => 'z',
            _ => '.',
        }
    }
}
