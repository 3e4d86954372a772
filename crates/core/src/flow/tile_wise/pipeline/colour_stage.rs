//! The colour stage of a core: its colour unit, in front of the feature buffer.
//!
//! The unit takes the chunks that read colours in the order in which they were issued: each when
//! all that it reads has arrived and the entry is free. It is the last to act in a cycle; a chunk
//! can be rendered in the cycle in which its colours are there.

use super::TileMemory;
use crate::flow::tile_wise::colour::{Colour, UNITS};
use crate::flow::tile_wise::pipeline::NEVER;
use crate::flow::tile_wise::pipeline::feature_queue::FeatureQueue;
use crate::flow::tile_wise::vru::FEATURES;
use crate::kernel::ledger::Ledger;
use crate::kernel::timeline::{Observer, State};

/// The colour unit of one core.
#[derive(Debug)]
pub(super) struct ColourStage {
    unit: Option<Colour>,
    /// First cycle in which the entry is free.
    free: u64,
    /// Cycle account: booked here up to `free`, by the core after that.
    pub ledger: Ledger,
}

impl ColourStage {
    /// Without a unit it has no work: no chunk waits for it.
    pub(crate) fn new(core: u32, unit: Option<Colour>) -> Self {
        Self { unit, free: 0, ledger: Ledger::new(UNITS, core) }
    }

    /// Takes the next chunk if the entry is free and everything has arrived.
    pub(crate) fn step(
        &mut self,
        now: u64,
        features: &mut FeatureQueue,
        memory: &TileMemory,
        observer: &mut impl Observer,
    ) {
        let Some(unit) = self.unit.filter(|_| self.free <= now) else { return };
        let Some(chunk) = features.uncoloured() else { return };
        if memory.at(chunk.features) > now {
            return;
        }
        // The entry is free before the colours are there, because the unit is a pipeline (A31).
        self.free = now + chunk.colours;
        chunk.coloured = self.free + unit.latency;
        self.ledger.book(State::Busy(chunk.tile), now, self.free, observer);
    }

    /// Its state while no chunk holds the entry; `None` when it has no chunk to wait with.
    pub(crate) fn state(&self, features: &mut FeatureQueue) -> Option<State> {
        self.unit?;
        features.uncoloured().map(|_| State::Stalled(FEATURES))
    }

    /// Books the cycles up to `now`, in which it is in `state` where no chunk holds the entry.
    pub(crate) fn account(
        &mut self,
        state: State,
        since: u64,
        now: u64,
        observer: &mut impl Observer,
    ) {
        if self.unit.is_some() {
            self.ledger.book(state, since.max(self.free), now, observer);
        }
    }

    /// The next cycle in which it acts.
    pub(crate) fn wake(&self, features: &mut FeatureQueue, memory: &TileMemory) -> u64 {
        if self.unit.is_none() {
            return NEVER;
        }
        features.uncoloured().map_or(NEVER, |chunk| memory.at(chunk.features).max(self.free))
    }
}
