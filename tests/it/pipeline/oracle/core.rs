//! A core, counting down.

use std::collections::VecDeque;

use powergs_sim::accel::qsu::List;
use powergs_sim::accel::traffic::chunk_read;
use powergs_sim::accel::vru::Render;
use powergs_sim::accel::{Design, Unit};
use powergs_sim::workload::FrameWorkload;

use super::digit;
use super::memory::{Memory, Ticket};

const SORTING: usize = 1;
const RENDERING: usize = 2;

enum Step {
    WantsRoom,
    Reads(Ticket),
    Passes { left: u32, cycles: u64, spill: Option<Ticket> },
    Ready,
}

struct Front {
    tile: usize,
    entries: u32,
    step: Step,
}

/// A chunk between the middle and the end of the VRU, or a tile without chunks.
struct Chunk {
    tile: usize,
    cycles: u64,
    features: Option<Ticket>,
    sort_left: u64,
    is_last: bool,
    bytes: u64,
    pixels: u64,
    sent: u64,
}

#[derive(Default)]
pub struct Core {
    front: Option<Front>,
    middle: Option<(usize, usize)>,
    /// Chunks in order.
    chunks: VecDeque<Chunk>,
    rendering: Option<Chunk>,
    pending: Option<u64>,
    writes: Vec<(Ticket, u64)>,
    keys_used: u64,
    features_used: u64,
    pixels_used: u64,
}

fn fits(used: u64, bytes: u64, capacity: u64) -> bool {
    used == 0 || used + bytes <= capacity
}

fn list(workload: &FrameWorkload, tile: usize) -> List {
    List { entries: u64::from(workload.tiles[tile].entries) }
}

impl Core {
    pub fn is_done(&self) -> bool {
        self.front.is_none()
            && self.middle.is_none()
            && self.chunks.is_empty()
            && self.rendering.is_none()
            && self.pending.is_none()
            && self.writes.is_empty()
    }

    pub fn step(
        &mut self,
        now: u64,
        design: &Design,
        workload: &FrameWorkload,
        next: &mut usize,
        memory: &mut Memory,
    ) {
        self.give_back(now, design, workload, memory);
        if let Some(bytes) = self.pending
            && fits(self.pixels_used, bytes, design.shares.pixel_out)
        {
            self.pending = None;
            self.pixels_used += bytes;
            self.writes.push((memory.write(now, RENDERING, bytes), bytes));
        }
        let can_render = self.chunks.front().is_some_and(|c| {
            let here = c.features.is_none_or(|ticket| memory.is_done(ticket, now));
            here && c.sort_left == 0 && c.sent < now
        });
        if self.rendering.is_none() && self.pending.is_none() && can_render {
            self.rendering = self.chunks.pop_front();
        }
        self.move_front(now, design, workload, memory);
        while self.send(now, design, workload, memory) {}
        if self.front.is_none() && *next < workload.tiles.len() {
            self.front = Some(Front {
                tile: *next,
                entries: workload.tiles[*next].entries,
                step: Step::WantsRoom,
            });
            *next += 1;
        }
        if let Some(front) = &mut self.front
            && matches!(front.step, Step::WantsRoom)
        {
            let list = list(workload, front.tile);
            let bytes = design.qsu.resident(list);
            if fits(self.keys_used, bytes, design.shares.sorting) {
                self.keys_used += bytes;
                let read = memory.read(now, SORTING, list.entries * design.qsu.key);
                front.step = Step::Reads(read);
            }
        }
    }

    fn give_back(&mut self, now: u64, design: &Design, workload: &FrameWorkload, memory: &Memory) {
        self.writes.retain(|&(ticket, bytes)| {
            let done = memory.is_done(ticket, now);
            self.pixels_used -= if done { bytes } else { 0 };
            !done
        });
        for chunk in &mut self.chunks {
            // `is_last` is dropped once the keys of the tile have been given back.
            if chunk.sort_left == 0 && chunk.is_last {
                chunk.is_last = false;
                self.keys_used -= design.qsu.resident(list(workload, chunk.tile));
            }
        }
        if let Some(done) = self.rendering.take_if(|chunk| chunk.cycles == 0) {
            self.features_used -= done.bytes;
            self.pending = (done.pixels != u64::MAX).then_some(done.pixels);
        }
    }

    fn move_front(
        &mut self,
        now: u64,
        design: &Design,
        workload: &FrameWorkload,
        memory: &mut Memory,
    ) {
        let Some(front) = &mut self.front else { return };
        let list = list(workload, front.tile);
        let left = match &front.step {
            Step::Reads(ticket) if memory.is_done(*ticket, now) => design.qsu.passes(list),
            Step::Passes { left, cycles: 0, spill }
                if spill.is_none_or(|ticket| memory.is_done(ticket, now)) =>
            {
                *left
            }
            _ => return,
        };
        front.step = Step::Ready;
        if left > 0 {
            let overflow = design.qsu.overflow(list);
            let spill = (overflow > 0).then(|| {
                memory.write(now, SORTING, overflow);
                memory.read(now, SORTING, overflow)
            });
            let cycles = design.qsu.pass_cycles(list);
            front.step = Step::Passes { left: left - 1, cycles, spill };
        }
    }

    /// Sends one thing; says whether it did.
    fn send(
        &mut self,
        now: u64,
        design: &Design,
        workload: &FrameWorkload,
        memory: &mut Memory,
    ) -> bool {
        let Some((index, next)) = self.middle else {
            let ready = self.front.take_if(|front| matches!(front.step, Step::Ready));
            self.middle = ready.map(|front| (front.tile, 0));
            return self.middle.is_some();
        };
        let tile = &workload.tiles[index];
        if tile.chunks == 0 {
            if !self.chunks.is_empty() {
                return false;
            }
            self.keys_used -= design.qsu.resident(list(workload, index));
            self.middle = None;
            self.chunks.push_back(Chunk {
                tile: index,
                cycles: design.vru.cycles(&Render { last: Some(*tile), ..Render::default() }),
                features: None,
                sort_left: 0,
                is_last: false,
                bytes: 0,
                pixels: design.vru.pixel_bytes(tile),
                sent: now,
            });
            return true;
        }
        let chunk = &workload.chunks[tile.chunk_start as usize + next];
        let bytes = u64::from(chunk.entries) * design.vru.feature;
        if !fits(self.features_used, bytes, design.shares.feature) {
            return false;
        }
        let is_last = next + 1 == tile.chunks as usize;
        self.features_used += bytes;
        self.middle = (!is_last).then_some((index, next + 1));
        let last = is_last.then_some(*tile);
        self.chunks.push_back(Chunk {
            tile: index,
            cycles: design.vru.cycles(&Render { chunk: *chunk, last }),
            features: Some(memory.read(now, RENDERING, chunk_read(chunk, design))),
            sort_left: design.bsu.cycles(chunk),
            is_last,
            bytes,
            pixels: if is_last { design.vru.pixel_bytes(tile) } else { u64::MAX },
            sent: now,
        });
        true
    }

    /// QSU, BSU, VRU.
    pub fn symbols(&self, now: u64, memory: &Memory) -> [char; 3] {
        let qsu = match &self.front {
            None => '.',
            Some(front) => match &front.step {
                Step::WantsRoom | Step::Ready => 'o',
                Step::Reads(_) if front.entries == 0 => 'i',
                Step::Reads(_) => 'd',
                Step::Passes { cycles: 0, .. } => 'd',
                Step::Passes { .. } => digit(front.tile),
            },
        };
        let behind = match qsu {
            '.' | 'd' => qsu,
            _ => 'i',
        };
        let bsu = match (self.chunks.iter().find(|c| c.sort_left > 0), self.middle) {
            (Some(chunk), _) => digit(chunk.tile),
            (None, Some(_)) => 'o',
            (None, None) => behind,
        };
        let vru = match (&self.rendering, self.pending, self.chunks.front()) {
            (Some(chunk), _, _) => digit(chunk.tile),
            (None, Some(_), _) => 'o',
            (None, None, Some(chunk)) => match chunk.features {
                Some(ticket) if !memory.is_done(ticket, now) => 'd',
                _ => 'i',
            },
            (None, None, None) => behind,
        };
        [qsu, bsu, vru]
    }

    pub fn tick(&mut self) {
        if let Some(Front { step: Step::Passes { cycles, .. }, .. }) = &mut self.front {
            *cycles = cycles.saturating_sub(1);
        }
        if let Some(chunk) = self.chunks.iter_mut().find(|c| c.sort_left > 0) {
            chunk.sort_left -= 1;
        }
        if let Some(chunk) = &mut self.rendering {
            chunk.cycles -= 1;
        }
    }
}
