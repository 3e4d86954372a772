//! The render stage of a core: the VRU and the pixel buffer.
//!
//! The VRU takes chunks in order, each when it is sorted and its features have arrived. After the
//! last chunk of a tile the pixels move to the pixel buffer and their write is issued; while the
//! buffer does not admit them, the VRU stalls.

use super::TileMemory;
use crate::flow::tile_wise::STREAMS;
use crate::flow::tile_wise::layout::Layout;
use crate::flow::tile_wise::pipeline::feature_queue::{Chunk, FeatureQueue};
use crate::flow::tile_wise::pipeline::{NEVER, Shared};
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::vru::{COLOURS, FEATURES, Vru};
use crate::kernel::Histogram;
use crate::kernel::buffer::BufferAllocator;
use crate::kernel::ledger::Ledger;
use crate::kernel::memory::Arrival;
use crate::kernel::stream::StreamId;
use crate::kernel::timeline::{Observer, State};
use crate::kernel::unit::Unit;
use crate::stage::Stall;

const PIXELS: StreamId = STREAMS.id("pixels");

/// The chunk that is being rendered.
#[derive(Debug, Clone, Copy)]
struct Rendering {
    chunk: Chunk,
    /// Cycle in which it would be done if no bank were in conflict.
    busy: u64,
    /// Cycle in which it is done.
    end: u64,
}

/// The rendering units of one core, which work as one gang.
#[derive(Debug)]
pub(super) struct RenderStage {
    owner: u32,
    pub ledger: Ledger,
    rendering: Option<Rendering>,
    /// Pixels of a finished tile that the pixel buffer does not admit yet, bytes.
    finished: Option<u64>,
    pub pixels: BufferAllocator,
    /// Pixel writes in flight, with their bytes.
    writing: Vec<(Arrival, u64)>,
    /// Cycle in which the last chunk was done.
    idle_since: u64,
    /// First cycle of the tile that is being rendered.
    tile_since: Option<u64>,
    /// The tile that was rendered last.
    last_tile: u32,
    pub tile_cycles: Histogram,
    /// Cycle in which the last pixel write is complete, as far as it is known.
    pub end: u64,
}

impl RenderStage {
    pub(crate) fn new(core: u32, owner: u32, units: &ResolvedUnits) -> Self {
        Self {
            owner,
            ledger: Ledger::new(Vru::STAGE, core),
            rendering: None,
            finished: None,
            pixels: BufferAllocator::new(units.shares.pixel_out),
            writing: Vec::new(),
            idle_since: 0,
            tile_since: None,
            last_tile: 0,
            tile_cycles: Histogram::EMPTY,
            end: 0,
        }
    }

    /// Frees the pixels that have been written, and retires the chunk that has been rendered.
    pub(crate) fn retire(&mut self, now: u64, features: &mut FeatureQueue, memory: &TileMemory) {
        let pixels = &mut self.pixels;
        self.writing.retain(|&(write, bytes)| {
            let in_flight = memory.at(write) > now;
            if !in_flight {
                pixels.release(now, bytes);
            }
            in_flight
        });
        let Some(Rendering { chunk, .. }) = self.rendering.take_if(|r| r.end <= now) else {
            return;
        };
        features.buffer.release(now, chunk.bytes);
        self.idle_since = now;
        if chunk.pixels.is_some() {
            self.finished = chunk.pixels;
            self.tile_cycles.count(now - self.tile_since.take().unwrap_or(now));
            // Only now does the core know that what it fetched ahead is not needed (A30).
            features.end_tile(now, memory);
        }
    }

    /// Moves the pixels of a finished tile to the pixel buffer and issues their write.
    pub(crate) fn write_pixels<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        let Some(bytes) = self.finished.take_if(|bytes| self.pixels.admits(*bytes)) else { return };
        self.pixels.fill(now, bytes);
        let tile = self.last_tile;
        let pattern = |layout: &Layout| layout.pixels(tile, bytes);
        let write = shared.issue(now, self.owner, PIXELS, bytes, pattern);
        self.writing.push((write, bytes));
        // Gradient units take what is kept on chip, and need not wait for the write of the pixels.
        if let Some(handed) = &mut shared.handed {
            handed.hand(self.ledger.instance(), tile);
        }
        self.end = self.end.max(shared.memory.known_end(write));
    }

    /// Begins the next chunk if the VRU is free, and the next tile if what is kept of it has room.
    pub(crate) fn begin<O>(&mut self, now: u64, features: &mut FeatureQueue, shared: &Shared<O>) {
        // Units still hold a finished tile whose pixels have no room, and cannot take the next one.
        if self.rendering.is_some() || self.finished.is_some() || self.is_held(shared) {
            return;
        }
        let Some(chunk) = features.pop_ready(now, &shared.memory) else { return };
        // While the VRU waited for the chunk, the queues of the tile went on (A85).
        let waited = now - self.idle_since;
        let busy = now + chunk.cycles - chunk.backlog.min(waited);
        self.rendering = Some(Rendering { chunk, busy, end: busy + chunk.stalls });
        self.tile_since.get_or_insert(now);
        self.last_tile = chunk.tile;
    }

    /// Whether the next tile waits for gradients of tiles before.
    fn is_held<O>(&self, shared: &Shared<O>) -> bool {
        let core = self.ledger.instance();
        self.tile_since.is_none()
            && shared.handed.as_ref().is_some_and(|handed| !handed.admits(core))
    }

    /// State of the VRU after the events of cycle `now`; `None` when it has no chunk.
    pub(crate) fn state<O>(
        &self,
        now: u64,
        features: &FeatureQueue,
        shared: &Shared<O>,
    ) -> Option<State> {
        let memory = &shared.memory;
        // A stall has one cause: what comes from memory is named before what units have yet to do.
        match (&self.rendering, self.finished, features.first()) {
            (Some(r), _, _) if r.busy > now => Some(State::Busy(r.chunk.tile)),
            (Some(_), _, _) => Some(State::Stalled(Stall::BANK)),
            (None, Some(_), _) => Some(State::Stalled(Stall::OUTPUT)),
            (None, None, Some(_)) if self.is_held(shared) => Some(State::Stalled(Stall::OUTPUT)),
            (None, None, Some(chunk)) if memory.at(chunk.features) > now => {
                Some(State::Stalled(FEATURES))
            }
            (None, None, Some(chunk)) if chunk.sorted <= now && chunk.coloured > now => {
                Some(State::Stalled(COLOURS))
            }
            (None, None, Some(_)) => Some(State::Stalled(Stall::INPUT)),
            (None, None, None) => None,
        }
    }

    /// The next cycle in which it acts.
    pub(crate) fn wake(&self, now: u64, features: &FeatureQueue, memory: &TileMemory) -> u64 {
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let at = |arrival: Arrival| later(memory.at(arrival));
        let first = |all: &[(Arrival, u64)]| all.iter().map(|one| at(one.0)).fold(NEVER, u64::min);
        let vru = match (&self.rendering, self.finished, features.first()) {
            (Some(r), _, _) => r.end.min(later(r.busy)),
            (None, Some(_), _) => first(&self.writing),
            (None, None, Some(chunk)) if memory.at(chunk.features) > now => at(chunk.features),
            (None, None, Some(chunk)) => later(chunk.sorted).min(later(chunk.coloured)),
            (None, None, None) => NEVER,
        };
        vru.min(first(features.dropped()))
    }

    /// Closes the account of the pixel buffer at the end of the frame.
    pub(crate) fn close(&mut self, now: u64) {
        self.writing.drain(..).for_each(|(_, bytes)| self.pixels.release(now, bytes));
    }
}
