//! The feature buffer of a core: a queue of chunks between the chunk-issue stage and the VRU.
//!
//! A chunk occupies the buffer from the cycle in which its feature read is issued until it has been
//! rendered. Speculative chunks are dropped when the last needed chunk of their tile has been
//! rendered; the bytes of a dropped chunk are freed when its read has completed.

use std::collections::VecDeque;

use super::TileMemory;
use crate::flow::tile_wise::pipeline::NEVER;
use crate::kernel::buffer::BufferAllocator;
use crate::kernel::memory::Arrival;

/// A chunk in the feature buffer, or a tile without chunks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk {
    pub tile: u32,
    /// Cycles for which it occupies the VRU.
    pub cycles: u64,
    /// Cycles of these that it would not take if the queues of its tile had been emptied before it.
    pub backlog: u64,
    /// Further cycles for which the VRU waits for banks.
    pub stalls: u64,
    /// Its feature read.
    pub features: Arrival,
    /// Cycle in which the BSU has sorted it.
    pub sorted: u64,
    /// Cycles for which it holds the entry of the colour unit; 0 without colours.
    pub colours: u64,
    /// Cycle in which its colours are there; [`NEVER`] until the colour unit has taken it.
    pub coloured: u64,
    /// Bytes in the feature buffer.
    pub bytes: u64,
    /// Bytes of the tile's pixels, with its last chunk.
    pub pixels: Option<u64>,
    /// Whether it lies behind the last needed chunk of its tile.
    pub speculative: bool,
}

/// The queue, and the buffer that holds it.
#[derive(Debug)]
pub(super) struct FeatureQueue {
    chunks: VecDeque<Chunk>,
    pub buffer: BufferAllocator,
    /// Reads of dropped chunks that are in flight, with their bytes.
    dropped: Vec<(Arrival, u64)>,
    /// Whether the last needed chunk of the tile that is being issued is in the queue: the
    /// chunk-issue stage then runs ahead speculatively.
    pub may_speculate: bool,
}

impl FeatureQueue {
    /// An empty buffer of `capacity` bytes.
    pub(crate) fn new(capacity: u64) -> Self {
        Self {
            chunks: VecDeque::new(),
            buffer: BufferAllocator::new(capacity),
            dropped: Vec::new(),
            may_speculate: false,
        }
    }

    /// Whether no chunk waits for the VRU.
    pub(crate) fn is_empty(&self) -> bool {
        self.chunks.is_empty()
    }

    /// The chunk that the VRU renders next.
    pub(crate) fn first(&self) -> Option<&Chunk> {
        self.chunks.front()
    }

    /// The first chunk that the colour unit has not taken.
    pub(crate) fn uncoloured(&mut self) -> Option<&mut Chunk> {
        self.chunks.iter_mut().find(|chunk| chunk.coloured == NEVER)
    }

    /// Allocates the bytes of a chunk and queues it.
    pub(crate) fn push(&mut self, now: u64, chunk: Chunk) {
        self.buffer.fill(now, chunk.bytes);
        self.chunks.push_back(chunk);
    }

    /// Takes the first chunk out for rendering if it is needed, sorted, and its features are there.
    /// Its bytes stay allocated until it has been rendered.
    pub(crate) fn pop_ready(&mut self, now: u64, memory: &TileMemory) -> Option<Chunk> {
        self.chunks.pop_front_if(|chunk| {
            chunk.sorted.max(chunk.coloured) <= now
                && memory.at(chunk.features) <= now
                && !chunk.speculative
        })
    }

    /// The last needed chunk of a tile has been rendered: drops the speculative ones behind it.
    pub(crate) fn end_tile(&mut self, now: u64, memory: &TileMemory) {
        while let Some(unused) = self.chunks.pop_front_if(|next| next.speculative) {
            // Data that is still to come needs its place, although it is not wanted any more.
            if memory.at(unused.features) <= now {
                self.buffer.discard(now, unused.bytes);
            } else {
                self.dropped.push((unused.features, unused.bytes));
            }
        }
        // The tile that is being issued may be a later one, whose last chunk still waits.
        let is_queued = self.chunks.iter().any(|next| next.pixels.is_some());
        self.may_speculate &= is_queued;
    }

    /// Frees the bytes of dropped chunks whose reads have completed.
    pub(crate) fn free_dropped(&mut self, now: u64, memory: &TileMemory) {
        let buffer = &mut self.buffer;
        self.dropped.retain(|&(read, bytes)| {
            let in_flight = memory.at(read) > now;
            if !in_flight {
                buffer.discard(now, bytes);
            }
            in_flight
        });
    }

    /// Reads of dropped chunks that are in flight.
    pub(crate) fn dropped(&self) -> &[(Arrival, u64)] {
        &self.dropped
    }

    /// Closes the account of the buffer at the end of the frame.
    pub(crate) fn close(&mut self, now: u64) {
        self.dropped.drain(..).for_each(|(_, bytes)| self.buffer.discard(now, bytes));
    }
}
