//! A core, counting down.

use std::collections::VecDeque;

use powergs_core::flow::tile_wise::Fetch;
use powergs_core::flow::tile_wise::ResolvedUnits;
use powergs_core::flow::tile_wise::bsu::Sort;
use powergs_core::flow::tile_wise::layout::AccessPattern;
use powergs_core::flow::tile_wise::schedule::Job;
use powergs_core::flow::tile_wise::traffic::ChunkLoad;
use powergs_core::flow::tile_wise::vru::Render;
use powergs_core::kernel::Unit;
use powergs_core::machine::Machine;
use powergs_core::workload::ChunkWork;
use powergs_energy::flops::colour_share;
use powergs_frame::scene::ShDegree;

use super::gradients::Gru;
use super::{Frame, Memory, digit};
use crate::oracle_memory::Ticket;

enum Step {
    WantsList,
    WantsRoom,
    Reads(Ticket),
    Depths(Ticket),
    /// A sort of all chunks, by its number.
    Chunks {
        sort: usize,
        spill: Option<Ticket>,
    },
    Passes {
        left: u32,
        cycles: u64,
        bank: u64,
        spill: Option<Ticket>,
    },
    Ready,
}

struct Held {
    job: usize,
    step: Step,
}

/// The job whose chunks are sent.
struct Middle {
    job: usize,
    tile: usize,
    chunk: u32,
    group_sorted: u32,
    group_looked: u32,
    speculated: u32,
}

/// A sort in the queue of the BSU.
struct Sorting {
    number: usize,
    tile: usize,
    busy: u64,
    bank: u64,
}

/// A chunk in the feature buffer, or a tile without chunks.
struct Chunk {
    tile: usize,
    busy: u64,
    /// Cycles of these for the queues that the chunk before has left full.
    backlog: u64,
    bank: u64,
    features: Option<Ticket>,
    /// Number of its sort.
    sort: Option<usize>,
    bytes: u64,
    pixels: Option<u64>,
    wanted: bool,
    sent: u64,
    colours: Colours,
}

/// Where the colours of a chunk are.
enum Colours {
    /// Nobody waits for them: there are none, or they are done.
    There,
    /// Operations, and cycles of the codebook, that the colour unit has not been asked for.
    Wanted([u64; 2]),
    /// What has not entered it.
    Entering([u64; 2]),
    /// Cycles until the last of them leaves it.
    Leaving(u64),
}

#[derive(Default)]
pub struct Core {
    number: u32,
    dealt: usize,
    held: VecDeque<Held>,
    middle: Option<Middle>,
    chunks: VecDeque<Chunk>,
    rendering: Option<Chunk>,
    /// Whether it has begun a tile that is not over.
    in_tile: bool,
    /// Whether the next tile waits for gradients of tiles before.
    is_held: bool,
    /// Cycles since the last chunk was rendered.
    waited: u64,
    sorts: VecDeque<Sorting>,
    n_sorts: usize,
    sorts_done: usize,
    /// Keys that leave when a sort is done.
    leaving: Vec<(usize, u64)>,
    pending: Option<(u32, u64)>,
    writes: Vec<(Ticket, u64)>,
    posted: Vec<Ticket>,
    doomed: Vec<(Ticket, u64)>,
    keys_used: u64,
    features_used: u64,
    pixels_used: u64,
}

fn fits(used: u64, bytes: u64, capacity: u64) -> bool {
    used == 0 || used + bytes <= capacity
}

impl Core {
    pub fn new(number: usize) -> Self {
        Core { number: number as u32, dealt: number, ..Core::default() }
    }

    pub fn is_done(&self, now: u64, frame: &Frame, next: usize, memory: &Memory) -> bool {
        let dealt = if frame.plan.is_static { self.dealt } else { next };
        dealt >= frame.plan.jobs.len()
            && self.held.is_empty()
            && self.middle.is_none()
            && self.chunks.is_empty()
            && self.rendering.is_none()
            && self.pending.is_none()
            && self.writes.is_empty()
            && self.doomed.is_empty()
            && self.sorts.is_empty()
            && self.posted.iter().all(|&ticket| memory.is_done(ticket, now))
    }

    /// `behind` is the gradient unit that takes its tiles as soon as they are rendered.
    pub fn step(
        &mut self,
        now: u64,
        frame: &Frame,
        next: &mut usize,
        memory: &mut Memory,
        mut behind: Option<&mut Gru>,
    ) {
        let design = frame.design;
        self.give_back(now, memory);
        if let Some((tile, bytes)) = self.pending
            && fits(self.pixels_used, bytes, design.shares.pixel_out)
        {
            self.pending = None;
            self.pixels_used += bytes;
            let span = memory.layout.pixels(tile, bytes);
            self.writes.push((memory.write(now, "pixels", bytes, span), bytes));
            if let Some(unit) = &mut behind {
                unit.hand(tile as usize);
            }
        }
        let is_ready = self.chunks.front().is_some_and(|c| {
            let here = c.features.is_none_or(|ticket| memory.is_done(ticket, now));
            let is_sorted = c.sort.is_none_or(|n| n < self.sorts_done);
            here && is_sorted && c.sent < now && matches!(c.colours, Colours::There)
        });
        let admits = behind.is_none_or(|unit| unit.admits());
        if self.rendering.is_none()
            && self.pending.is_none()
            && is_ready
            && (self.in_tile || admits)
        {
            self.rendering = self.chunks.pop_front();
            self.in_tile = true;
            if let Some(chunk) = &mut self.rendering {
                chunk.busy -= chunk.backlog.min(self.waited);
            }
            self.waited = 0;
        }
        self.is_held = !self.in_tile && !admits;
        self.move_front(now, frame, memory);
        while self.send(now, frame, memory) {}
        self.fetch(now, frame, next, memory);
        self.colour(now, memory);
    }

    /// The colour unit takes the next chunk that wants it, if nothing is entering and all of the
    /// chunk has arrived.
    fn colour(&mut self, now: u64, memory: &Memory) {
        if self.chunks.iter().any(|c| matches!(c.colours, Colours::Entering(_))) {
            return;
        }
        let next = self.chunks.iter_mut().find(|c| matches!(c.colours, Colours::Wanted(_)));
        let Some(chunk) = next else { return };
        if let (Colours::Wanted(work), Some(ticket)) = (&chunk.colours, chunk.features)
            && memory.is_done(ticket, now)
        {
            chunk.colours = Colours::Entering(*work);
        }
    }

    fn give_back(&mut self, now: u64, memory: &Memory) {
        let is_done = |ticket: Ticket| memory.is_done(ticket, now);
        self.writes.retain(|&(ticket, bytes)| {
            self.pixels_used -= if is_done(ticket) { bytes } else { 0 };
            !is_done(ticket)
        });
        self.doomed.retain(|&(ticket, bytes)| {
            self.features_used -= if is_done(ticket) { bytes } else { 0 };
            !is_done(ticket)
        });
        self.leaving.retain(|&(sort, bytes)| {
            let gone = sort < self.sorts_done;
            self.keys_used -= if gone { bytes } else { 0 };
            !gone
        });
        let Some(done) = self.rendering.take_if(|c| c.busy == 0 && c.bank == 0) else { return };
        self.features_used -= done.bytes;
        self.in_tile &= done.pixels.is_none();
        self.pending = done.pixels.map(|bytes| (done.tile as u32, bytes));
        while done.pixels.is_some() && self.chunks.front().is_some_and(|c| !c.wanted) {
            let vain = self.chunks.pop_front().expect("there is one");
            let ticket = vain.features.expect("chunks have features");
            match is_done(ticket) {
                true => self.features_used -= vain.bytes,
                false => self.doomed.push((ticket, vain.bytes)),
            }
        }
    }

    fn move_front(&mut self, now: u64, frame: &Frame, memory: &mut Memory) {
        let design = frame.design;
        for i in 0..self.held.len() {
            let keys = frame.plan.jobs[self.held[i].job].keys;
            let left = match &self.held[i].step {
                Step::Ready => continue,
                Step::Reads(ticket) if memory.is_done(*ticket, now) => {
                    let job = &frame.plan.jobs[self.held[i].job];
                    if job.depths > 0 {
                        let span = memory.layout.depths(job);
                        let bytes = job.depths * design.qsu.depth;
                        self.held[i].step = Step::Depths(memory.read(now, "depths", bytes, span));
                        return;
                    }
                    // Chunks first, where they are merged.
                    if keys.merged && keys.sorted > 0 {
                        let job = &frame.plan.jobs[self.held[i].job];
                        let tile = frame.plan.tiles_of(job)[0] as usize;
                        // Entries of lists of before are in order.
                        let all = Sort { keys: keys.sorted, filtered: 0 };
                        let sort = self.queue(design, all, tile);
                        let mut spill = None;
                        if keys.passes > 0 {
                            spill = self.spill(now, design.qsu.overflow(&keys), memory);
                        }
                        self.held[i].step = Step::Chunks { sort, spill };
                        return;
                    }
                    keys.passes
                }
                Step::Depths(ticket) if memory.is_done(*ticket, now) => keys.passes,
                Step::Chunks { sort, spill }
                    if *sort < self.sorts_done
                        && spill.is_none_or(|ticket| memory.is_done(ticket, now)) =>
                {
                    keys.passes
                }
                Step::Passes { left, cycles: 0, bank: 0, spill }
                    if spill.is_none_or(|ticket| memory.is_done(ticket, now)) =>
                {
                    *left
                }
                _ => return,
            };
            if left > 0 {
                let spill = self.spill(now, design.qsu.overflow(&keys), memory);
                let pass = keys.passes - left;
                let cycles = design.qsu.pass_cycles(&keys, pass);
                let bank = design.qsu.pass_stalls(&keys, pass);
                self.held[i].step = Step::Passes { left: left - 1, cycles, bank, spill };
                return;
            }
            self.held[i].step = Step::Ready;
        }
    }

    fn spill(&mut self, now: u64, bytes: u64, memory: &mut Memory) -> Option<Ticket> {
        let span = memory.layout.spill(self.number, bytes);
        (bytes > 0).then(|| {
            self.posted.push(memory.write(now, "spill-out", bytes, span));
            memory.read(now, "spill-in", bytes, span)
        })
    }

    fn fetch(&mut self, now: u64, frame: &Frame, next: &mut usize, memory: &mut Memory) {
        let (design, plan) = (frame.design, frame.plan);
        while self.held.len() < design.qsu.spec.queue as usize {
            let place = if plan.is_static { &mut self.dealt } else { &mut *next };
            if *place >= plan.jobs.len() {
                break;
            }
            self.held.push_back(Held { job: *place, step: Step::WantsList });
            *place += if plan.is_static { design.vru.spec.cores as usize } else { 1 };
        }
        for held in &mut self.held {
            let job = &plan.jobs[held.job];
            if matches!(held.step, Step::WantsList) && frame.is_binned(job.complete_after) {
                held.step = Step::WantsRoom;
            }
            if matches!(held.step, Step::WantsList) {
                return;
            }
            if matches!(held.step, Step::WantsRoom) {
                let bytes = design.qsu.resident(&job.keys);
                if !fits(self.keys_used, bytes, design.shares.sorting) {
                    return;
                }
                self.keys_used += bytes;
                let span = memory.layout.list(job, job.read);
                held.step = Step::Reads(memory.read(now, "lists", job.read, span));
            }
        }
    }

    /// Sends one thing; says whether it did.
    fn send(&mut self, now: u64, frame: &Frame, memory: &mut Memory) -> bool {
        let Some(mut middle) = self.middle.take() else {
            let ready = self.held.pop_front_if(|held| matches!(held.step, Step::Ready));
            self.middle = ready.map(|held| Middle {
                job: held.job,
                tile: 0,
                chunk: 0,
                group_sorted: 0,
                group_looked: 0,
                speculated: 0,
            });
            return self.middle.is_some();
        };
        let job = &frame.plan.jobs[middle.job];
        let Some(&index) = frame.plan.tiles_of(job).get(middle.tile) else {
            self.finish_job(now, frame, job, memory);
            return true;
        };
        let index = index as usize;
        let tile = &frame.workload.tiles[index];
        let is_sent = if tile.chunks == 0 {
            let is_sent = self.chunks.is_empty();
            if is_sent {
                let render = frame.render(job, index, None);
                self.chunks.push_back(Chunk {
                    tile: index,
                    busy: frame.design.vru.cycles(&render),
                    backlog: 0,
                    bank: frame.design.vru.bank_stalls(&render),
                    features: None,
                    sort: None,
                    bytes: 0,
                    pixels: Some(frame.design.vru.pixel_bytes(tile)),
                    wanted: true,
                    sent: now,
                    colours: Colours::There,
                });
                middle.tile += 1;
            }
            is_sent
        } else if middle.chunk < tile.chunks {
            self.send_chunk(now, frame, &mut middle, index, memory)
        } else {
            self.speculate(now, frame, &mut middle, index, memory)
        };
        self.middle = Some(middle);
        is_sent
    }

    fn finish_job(&mut self, now: u64, frame: &Frame, job: &Job, memory: &mut Memory) {
        let resident = frame.design.qsu.resident(&job.keys);
        match self.sorts.back().filter(|_| !job.keys.merged) {
            None => self.keys_used -= resident,
            Some(last) => self.leaving.push((last.number, resident)),
        }
        if job.kept > 0 {
            let span = memory.layout.list(job, job.kept);
            self.posted.push(memory.write(now, "kept-lists", job.kept, span));
        }
    }

    fn send_chunk(
        &mut self,
        now: u64,
        frame: &Frame,
        middle: &mut Middle,
        index: usize,
        memory: &mut Memory,
    ) -> bool {
        let (design, job) = (frame.design, &frame.plan.jobs[middle.job]);
        let tile = &frame.workload.tiles[index];
        let at = (tile.chunk_start + middle.chunk) as usize;
        let chunk = frame.workload.chunks[at];
        // Entries of the first level, and of the second where the tile has one.
        let fovea = &design.vru.fovea;
        let bytes = u64::from(chunk.entries) * design.vru.feature
            + u64::from(chunk.seconds) * fovea.feature.0;
        if !fits(self.features_used, bytes, design.shares.feature) {
            return false;
        }
        let mut sort = Sort { keys: u64::from(chunk.entries), filtered: 0 };
        if let Some(group) = job.group {
            let size = frame.workload.geometry.chunk;
            let most = frame.workload.groups[group as usize].entries;
            if middle.chunk == 0 {
                middle.group_looked = 0;
            }
            let need = (chunk.group_end.div_ceil(size) * size).min(most);
            sort.keys = 0;
            while middle.group_sorted < need {
                middle.group_sorted += 1;
                sort.keys += 1;
            }
            while middle.group_looked < chunk.group_end {
                middle.group_looked += 1;
                sort.filtered += 1;
            }
        }
        let load = ChunkLoad::new(frame.workload, at, design, &frame.given);
        let render = frame.render(job, index, Some(middle.chunk));
        self.features_used += bytes;
        middle.chunk += 1;
        let is_last = middle.chunk == tile.chunks;
        let start = u64::from(tile.list_start + (middle.chunk - 1) * frame.workload.geometry.chunk);
        let span = AccessPattern::Chunk { start, entries: u64::from(chunk.entries), load };
        let features = Some(memory.read(now, "features", load.bytes(design), span));
        let sort = self.queue_chunk(design, sort, job, index);
        self.chunks.push_back(Chunk {
            tile: index,
            busy: design.vru.cycles(&render),
            backlog: render.run.map_or(0, |run| run.cycles - run.alone),
            bank: design.vru.bank_stalls(&render),
            features,
            sort,
            bytes,
            pixels: is_last.then(|| design.vru.pixel_bytes(tile)),
            wanted: true,
            sent: now,
            colours: match frame.colour_work(&chunk) {
                [0, 0] => Colours::There,
                work => Colours::Wanted(work),
            },
        });
        true
    }

    /// The sort of a chunk; keys that were merged are in order.
    fn queue_chunk(
        &mut self,
        design: &ResolvedUnits,
        sort: Sort,
        job: &Job,
        tile: usize,
    ) -> Option<usize> {
        let merges = job.keys.merged;
        let sort = Sort { keys: if merges { 0 } else { sort.keys }, ..sort };
        let is_in_order = merges && sort.filtered == 0;
        (!is_in_order).then(|| self.queue(design, sort, tile))
    }

    fn queue(&mut self, design: &ResolvedUnits, sort: Sort, tile: usize) -> usize {
        let (busy, bank) = (design.bsu.cycles(&sort), design.bsu.bank_stalls(&sort));
        self.sorts.push_back(Sorting { number: self.n_sorts, tile, busy, bank });
        self.n_sorts += 1;
        self.n_sorts - 1
    }

    /// Drops a chunk behind the last stop of its tile, or moves on to the next tile.
    fn speculate(
        &mut self,
        now: u64,
        frame: &Frame,
        middle: &mut Middle,
        index: usize,
        memory: &mut Memory,
    ) -> bool {
        let (design, job) = (frame.design, &frame.plan.jobs[middle.job]);
        let tile = &frame.workload.tiles[index];
        let is_its = |c: &Chunk| c.tile == index && c.pixels.is_some();
        let is_open = self.rendering.iter().chain(&self.chunks).any(is_its);
        let size = frame.workload.geometry.chunk;
        let left = tile.entries.saturating_sub(tile.loaded + middle.speculated * size);
        if !is_open || left == 0 || middle.speculated == design.vru.spec.speculation {
            (middle.tile, middle.chunk, middle.speculated) = (middle.tile + 1, 0, 0);
            return true;
        }
        let entries = u64::from(left.min(size));
        let bytes = entries * design.vru.feature;
        if !fits(self.features_used, bytes, design.shares.feature) {
            return false;
        }
        let keys = if job.group.is_some() { 0 } else { entries };
        self.features_used += bytes;
        middle.speculated += 1;
        let start = u64::from(tile.list_start + tile.loaded + (middle.speculated - 1) * size);
        let load = ChunkLoad { features: entries, ..ChunkLoad::default() };
        let span = AccessPattern::Chunk { start, entries, load };
        let features = Some(memory.read(now, "features", bytes, span));
        let sort = self.queue_chunk(design, Sort { keys, filtered: entries - keys }, job, index);
        self.chunks.push_back(Chunk {
            tile: index,
            busy: 0,
            backlog: 0,
            bank: 0,
            features,
            sort,
            bytes,
            pixels: None,
            wanted: false,
            sent: now,
            colours: Colours::There,
        });
        true
    }

    /// QSU, BSU, VRU, colour unit.
    pub fn symbols(&self, now: u64, frame: &Frame, memory: &Memory) -> [char; 4] {
        let name = |job: usize| digit(frame.plan.tiles_of(&frame.plan.jobs[job])[0] as usize);
        let working = self.held.iter().find(|held| !matches!(held.step, Step::Ready));
        let qsu = match (working, self.held.is_empty()) {
            (None, true) => '.',
            (None, false) => 'o',
            (Some(held), _) => match &held.step {
                Step::WantsRoom | Step::Ready => 'o',
                Step::WantsList => 'i',
                Step::Reads(_) if frame.plan.jobs[held.job].keys.held == 0 => 'i',
                Step::Reads(_) | Step::Depths(_) => 'l',
                Step::Chunks { sort, .. } if *sort < self.sorts_done => 's',
                Step::Chunks { .. } => 'i',
                Step::Passes { cycles: 0, bank: 0, .. } => 's',
                Step::Passes { cycles: 0, .. } => 'b',
                Step::Passes { .. } => name(held.job),
            },
        };
        let behind = match qsu {
            '.' | 'l' | 's' => qsu,
            _ => 'i',
        };
        let bsu = match (self.sorts.front(), &self.middle) {
            (Some(sort), _) if sort.busy > 0 => digit(sort.tile),
            (Some(_), _) => 'b',
            (None, Some(_)) => 'o',
            (None, None) => behind,
        };
        let vru = match (&self.rendering, self.pending, self.chunks.front()) {
            (Some(chunk), _, _) if chunk.busy > 0 => digit(chunk.tile),
            (Some(_), _, _) => 'b',
            (None, Some(_), _) => 'o',
            (None, None, Some(_)) if self.is_held => 'o',
            (None, None, Some(chunk)) => match chunk.features {
                Some(ticket) if !memory.is_done(ticket, now) => 'f',
                _ if self.wants_colours(now, memory) => 'c',
                _ => 'i',
            },
            (None, None, None) if self.middle.is_some() => 'f',
            (None, None, None) => behind,
        };
        let entering = |c: &&Chunk| matches!(c.colours, Colours::Entering(_));
        let wanting = |c: &Chunk| matches!(c.colours, Colours::Wanted(_));
        let colour = match self.chunks.iter().find(entering) {
            Some(chunk) => digit(chunk.tile),
            None if self.chunks.iter().any(wanting) => 'f',
            None => behind,
        };
        [qsu, bsu, vru, colour]
    }

    /// Whether the VRU has nothing to do but wait for the colours of its next chunk.
    fn wants_colours(&self, now: u64, memory: &Memory) -> bool {
        let is_free = self.rendering.is_none() && self.pending.is_none();
        is_free
            && self.chunks.front().is_some_and(|c| {
                let is_sorted = c.sort.is_none_or(|n| n < self.sorts_done);
                let is_here = c.features.is_none_or(|ticket| memory.is_done(ticket, now));
                is_sorted && is_here && !matches!(c.colours, Colours::There)
            })
    }

    pub fn tick(&mut self, machine: &Machine) {
        let vru = &machine.tiles().vru;
        for chunk in &mut self.chunks {
            let latency = u64::from(vru.colour_latency);
            let after = |left: u64| match left {
                0 => Colours::There,
                _ => Colours::Leaving(left),
            };
            match chunk.colours {
                Colours::Entering([operations, lookups]) => {
                    let rate = u64::from(vru.colour_operations_per_cycle);
                    let left = [operations.saturating_sub(rate), lookups.saturating_sub(1)];
                    chunk.colours = match left {
                        [0, 0] => after(latency),
                        left => Colours::Entering(left),
                    };
                }
                Colours::Leaving(left) => chunk.colours = after(left - 1),
                Colours::There | Colours::Wanted(_) => {}
            }
        }
        let count = |busy: &mut u64, bank: &mut u64| {
            let left = if *busy > 0 { busy } else { bank };
            *left = left.saturating_sub(1);
        };
        let working = self.held.iter_mut().find(|held| !matches!(held.step, Step::Ready));
        if let Some(Held { step: Step::Passes { cycles, bank, .. }, .. }) = working {
            count(cycles, bank);
        }
        if let Some(sort) = self.sorts.front_mut() {
            count(&mut sort.busy, &mut sort.bank);
            if sort.busy + sort.bank == 0 {
                self.sorts.pop_front();
                self.sorts_done += 1;
            }
        }
        match &mut self.rendering {
            Some(chunk) => count(&mut chunk.busy, &mut chunk.bank),
            None => self.waited += 1,
        }
    }
}

impl Frame<'_> {
    /// Operations of the colours that a chunk reads: each in proportion to the operations of its
    /// SH degree, those of further levels as many as a finished pixel. And the cycles in which its
    /// codebook gives their entries, word by word, as many at once as there are banks.
    fn colour_work(&self, chunk: &ChunkWork) -> [u64; 2] {
        if self.machine.tiles().ccu.fetch != Fetch::LazyColour {
            return [0, 0];
        }
        let full = f64::from(self.machine.tiles().ccu.operations.sh_colour);
        let one = (full * colour_share(self.workload.sh_degree)).round() as u64;
        let loads = u64::from(chunk.first_loads);
        let book = &self.machine.tiles().codebook;
        let has_entries = book.entries > 0 && self.workload.sh_degree != ShDegree::ZERO;
        let words = book.entry.0.div_ceil(book.word.0);
        let each = if has_entries { words.div_ceil(u64::from(book.banks)) } else { 0 };
        [one * loads + 6 * u64::from(chunk.level_loads), each * loads]
    }

    /// What the VRU does for a chunk of a tile, or for a tile without chunks.
    fn render(&self, job: &Job, index: usize, position: Option<u32>) -> Render {
        let tile = &self.workload.tiles[index];
        let is_last = position.is_none_or(|p| p + 1 == tile.chunks);
        let filled = |t: &u32| self.workload.tiles[*t as usize].chunks > 0;
        let last_filled = self.plan.tiles_of(job).iter().copied().rfind(filled);
        let is_overlapped = self.design.vru.spec.tile_overlap;
        Render {
            chunk: position.map_or(Default::default(), |p| {
                self.workload.chunks[(tile.chunk_start + p) as usize]
            }),
            run: position.and_then(|p| Some(self.runs.as_ref()?[index][p as usize])),
            last: is_last.then_some(*tile),
            drains: is_last && last_filled == Some(index as u32) && !is_overlapped,
        }
    }
}
