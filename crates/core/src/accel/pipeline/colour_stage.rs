//! The colour stage of a core: its colour unit, in front of the feature buffer.
//!
//! The unit takes the chunks that read colours in the order in which they were issued: each when
//! all that it reads has arrived and the entry is free. It is the last to act in a cycle; a chunk
//! can be rendered in the cycle in which its colours are there.

use super::NEVER;
use super::feature_queue::FeatureQueue;
use crate::accel::colour::Colour;
use crate::accel::memory::Memory;

/// The colour unit of one core.
#[derive(Debug)]
pub(super) struct ColourStage {
    unit: Option<Colour>,
    /// First cycle in which the entry is free.
    free: u64,
    /// Cycles for which a chunk held the entry.
    pub busy: u64,
    /// Cycles for which the VRU waited for colours alone.
    pub waited: u64,
}

impl ColourStage {
    /// Without a unit it has no work: no chunk waits for it.
    pub(crate) fn new(unit: Option<Colour>) -> Self {
        Self { unit, free: 0, busy: 0, waited: 0 }
    }

    /// Takes the next chunk if the entry is free and everything has arrived.
    pub(crate) fn step(&mut self, now: u64, features: &mut FeatureQueue, memory: &Memory) {
        let Some(unit) = self.unit.filter(|_| self.free <= now) else { return };
        let Some(chunk) = features.uncoloured() else { return };
        if memory.at(chunk.features) > now {
            return;
        }
        self.free = now + chunk.colours;
        chunk.coloured = self.free + unit.latency;
        self.busy += chunk.colours;
    }

    /// The next cycle in which it acts.
    pub(crate) fn wake(&self, features: &mut FeatureQueue, memory: &Memory) -> u64 {
        if self.unit.is_none() {
            return NEVER;
        }
        features.uncoloured().map_or(NEVER, |chunk| memory.at(chunk.features).max(self.free))
    }
}
