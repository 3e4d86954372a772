//! A core: the agent of the tile phase.
//!
//! A core is a pipeline of three stages with a queue in front of the last one:
//!
//! ```text
//! list fetch (QSU, sorting buffer) -> chunk issue (BSU) -> feature queue -> render (VRU, pixels)
//! ```
//!
//! Where colours are read late, a colour unit stands in front of the feature queue.
//!
//! Order within a cycle: finished chunks and writes free their buffers, pixels leave, the VRU
//! begins a chunk; lists and passes advance; chunks are issued; lists are fetched; the colour unit
//! takes a chunk. The DRAM requests of one core are issued in that order.

use crate::flow::tile_wise::pipeline::Shared;
use crate::flow::tile_wise::pipeline::chunk_issue::{ChunkIssue, ChunkIssuePorts};
use crate::flow::tile_wise::pipeline::colour_stage::ColourStage;
use crate::flow::tile_wise::pipeline::feature_queue::FeatureQueue;
use crate::flow::tile_wise::pipeline::list_fetch::ListFetch;
use crate::flow::tile_wise::pipeline::render::RenderStage;
use crate::flow::tile_wise::qsu::{Qsu, SORTING};
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::vru::{FEATURE, FEATURES, PIXEL_OUT};
use crate::kernel::ledger::Ledger;
use crate::kernel::timeline::{Level, Observer, State};
use crate::kernel::unit::Unit;
use crate::stage::Stall;

/// One core.
#[derive(Debug)]
pub(super) struct Core {
    /// Cycle account of the QSUs; those of the BSUs and the VRU are in their stages.
    pub qsu: Ledger,
    pub list_fetch: ListFetch,
    pub issue: ChunkIssue,
    pub features: FeatureQueue,
    pub colour: ColourStage,
    pub render: RenderStage,
    /// States of QSU, BSU (while it does not sort), VRU and colour unit (while it is free) since
    /// cycle `since`.
    states: [State; 4],
    since: u64,
    /// Cycle in which everything that the core has issued is complete, as far as it is known.
    pub end: u64,
}

impl Core {
    pub(crate) fn new(core: u32, owner: u32, units: &ResolvedUnits) -> Self {
        Self {
            qsu: Ledger::new(Qsu::STAGE, core),
            list_fetch: ListFetch::new(core, owner, units.shares.sorting),
            issue: ChunkIssue::new(core, owner),
            features: FeatureQueue::new(units.shares.feature),
            colour: ColourStage::new(core, units.colour),
            render: RenderStage::new(core, owner, units),
            states: [State::Idle; 4],
            since: 0,
            end: 0,
        }
    }

    /// Whether chunks wait for its rendering units.
    pub(crate) fn has_chunks(&self) -> bool {
        !self.features.is_empty()
    }

    /// Processes the events of cycle `now`; returns the cycle of its next own event.
    pub(crate) fn step<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) -> u64 {
        // Room is given back before anything asks for it, so that it is used again in the same
        // cycle.
        self.features.free_dropped(now, &shared.memory);
        self.list_fetch.release_sorted(now);
        self.render.retire(now, &mut self.features, &shared.memory);
        self.render.write_pixels(now, shared);
        self.render.begin(now, &mut self.features, shared);
        self.list_fetch.advance(now, &mut self.issue, shared);
        let (list_fetch, features) = (&mut self.list_fetch, &mut self.features);
        self.issue.step(&mut ChunkIssuePorts { now, list_fetch, features, shared });
        self.list_fetch.fetch(now, shared);
        self.colour.step(now, &mut self.features, &shared.memory, shared.observer);
        self.end = self.end.max(now).max(self.issue.end).max(self.render.end);
        self.states = self.states(now, shared);
        if shared.observer.wants_levels() {
            self.tell(now, shared.observer);
        }
        // Chunk issue has no events of its own: what lets it go on is an event of one of these.
        let render = self.render.wake(now, &self.features, &shared.memory);
        let colour = self.colour.wake(&mut self.features, &shared.memory);
        render.min(colour).min(self.list_fetch.wake(now, shared))
    }

    fn states<O>(&mut self, now: u64, shared: &Shared<O>) -> [State; 4] {
        let vru = match self.render.state(now, &self.features, shared) {
            Some(state) => state,
            // The feature buffer is full of dropped chunks whose reads are in flight.
            None if self.issue.has_job() => State::Stalled(FEATURES),
            None => self.list_fetch.wait(now),
        };
        let bsu = match self.issue.has_job() {
            true => State::Stalled(Stall::OUTPUT),
            false => self.list_fetch.wait(now),
        };
        let colour = self.colour.state(&mut self.features);
        let colour = colour.unwrap_or_else(|| self.list_fetch.wait(now));
        [self.list_fetch.state(now), bsu, vru, colour]
    }

    /// Reports the occupancy of its buffers.
    fn tell(&self, from: u64, observer: &mut impl Observer) {
        let buffers = [
            (SORTING, &self.list_fetch.keys),
            (FEATURE, &self.features.buffer),
            (PIXEL_OUT, &self.render.pixels),
        ];
        let instance = self.qsu.instance();
        for (buffer, share) in buffers {
            observer.level(Level { buffer, instance, from, bytes: share.used() });
        }
    }

    /// Books the cycles up to `now` in the ledgers.
    pub(crate) fn account(&mut self, now: u64, observer: &mut impl Observer) {
        let [qsu, bsu, vru, colour] = self.states;
        self.qsu.book(qsu, self.since, now, observer);
        // Up to `sorter_free` the BSUs were booked when their sorts were queued.
        let bsu_since = self.since.max(self.issue.sorter_free);
        self.issue.ledger.book(bsu, bsu_since, now, observer);
        self.render.ledger.book(vru, self.since, now, observer);
        self.colour.account(colour, self.since, now, observer);
        self.since = now;
    }

    /// Closes the accounts of its buffers at the end of the frame.
    pub(crate) fn close(&mut self, now: u64) {
        self.render.close(now);
        self.features.close(now);
        self.list_fetch.close(now);
    }
}
