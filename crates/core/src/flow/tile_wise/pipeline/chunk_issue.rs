//! The chunk-issue stage of a core: sends the chunks of one job to the BSU and the feature queue.
//!
//! The stage takes the next job when it has issued all chunks of the last one. It issues the chunks
//! of the job's tiles in order, as many a cycle as the feature buffer admits: the feature read of a
//! chunk is issued and its sort is queued at the BSU in the same cycle.
//!
//! **Speculation.** Behind the last chunk that a tile needs, the stage issues up to
//! `vru.speculation` further chunks of the tile's list, until the last needed chunk has been
//! rendered (A30); the machine cannot tell before that they are not needed.
//!
//! A tile without chunks passes when no chunk waits for the VRU.

use crate::flow::tile_wise::STREAMS;
use crate::flow::tile_wise::bsu::{Bsu, Sort};
use crate::flow::tile_wise::layout::{AccessPattern, Layout};
use crate::flow::tile_wise::pipeline::feature_queue::{Chunk, FeatureQueue};
use crate::flow::tile_wise::pipeline::list_fetch::{FetchedJob, ListFetch};
use crate::flow::tile_wise::pipeline::{NEVER, Shared};
use crate::flow::tile_wise::rules::Rule;
use crate::flow::tile_wise::schedule::{Job, SortProgress};
use crate::flow::tile_wise::traffic::ChunkLoad;
use crate::flow::tile_wise::vru::Render;
use crate::kernel::ledger::Ledger;
use crate::kernel::memory::Arrival;
use crate::kernel::stream::StreamId;
use crate::kernel::timeline::{Observer, State};
use crate::kernel::unit::Unit;
use crate::stage::DRAM_READ;
use crate::stage::Stall;
use powergs_energy::action::{ActionCounts, Phase};

const KEPT_LISTS: StreamId = STREAMS.id("kept-lists");
const FEATURES: StreamId = STREAMS.id("features");

/// The connections of the stage in cycle `now`.
pub(super) struct ChunkIssuePorts<'p, 'a, O> {
    pub now: u64,
    pub list_fetch: &'p mut ListFetch,
    pub features: &'p mut FeatureQueue,
    pub shared: &'p mut Shared<'a, O>,
}

/// The job whose chunks are being issued.
#[derive(Debug)]
struct IssuingJob {
    fetched: FetchedJob,
    /// Tile of the job that is issued next, counted from its first.
    next_tile: u32,
    /// Chunk of that tile that is issued next.
    next_chunk: u32,
    sorted: SortProgress,
    /// Speculative chunks of that tile that have been issued.
    speculated: u32,
}

impl IssuingJob {
    fn new(fetched: FetchedJob) -> Self {
        let sorted = SortProgress::default();
        Self { fetched, next_tile: 0, next_chunk: 0, sorted, speculated: 0 }
    }

    fn next_tile(&mut self) {
        (self.next_tile, self.next_chunk, self.speculated) = (self.next_tile + 1, 0, 0);
    }
}

/// The stage, with the BSUs of the core, which work as one gang.
#[derive(Debug)]
pub(super) struct ChunkIssue {
    owner: u32,
    job: Option<IssuingJob>,
    /// Cycle account of the BSUs: booked here up to `sorter_free`, by the core after that.
    pub ledger: Ledger,
    /// Cycle in which the BSUs have finished all queued sorts.
    pub sorter_free: u64,
    /// Actions of speculative chunks.
    pub speculation: ActionCounts,
    /// Cycle in which all sorts and list writes are complete, as far as it is known.
    pub end: u64,
}

impl ChunkIssue {
    pub(crate) fn new(core: u32, owner: u32) -> Self {
        Self {
            owner,
            job: None,
            ledger: Ledger::new(Bsu::STAGE, core),
            sorter_free: 0,
            speculation: ActionCounts::default(),
            end: 0,
        }
    }

    /// Whether a job has chunks that are not issued.
    pub(crate) fn has_job(&self) -> bool {
        self.job.is_some()
    }

    /// Issues chunks of the current job and of the jobs behind it, until the feature buffer admits
    /// no more or no job is ready.
    pub(crate) fn step<O: Observer>(&mut self, ports: &mut ChunkIssuePorts<O>) {
        loop {
            let next = || ports.list_fetch.take_ready().map(IssuingJob::new);
            let Some(mut job) = self.job.take().or_else(next) else { return };
            if !self.issue_job(&mut job, ports) {
                self.job = Some(job);
                return;
            }
        }
    }

    /// Issues the chunks of a job that the buffer admits; returns whether none is left.
    fn issue_job<O: Observer>(
        &mut self,
        issuing: &mut IssuingJob,
        ports: &mut ChunkIssuePorts<O>,
    ) -> bool {
        let (plan, workload) = (ports.shared.plan, ports.shared.workload);
        let job = &plan.jobs[issuing.fetched.job as usize];
        while let Some(&tile) = plan.tiles_of(job).get(issuing.next_tile as usize) {
            let is_issued = match workload.tiles[tile as usize].chunks {
                0 => self.issue_empty(tile, job, ports),
                _ => self.issue_tile(tile, issuing, job, ports),
            };
            if !is_issued {
                return false;
            }
            issuing.next_tile();
            // Behind the next tile other chunks are speculated on, once its own last chunk is
            // queued.
            ports.features.may_speculate = false;
        }
        let resident = ports.shared.units.qsu.resident(&job.keys);
        // Merged chunks are sorted before they come; what the BSUs do now is of a later job.
        let sorted = if job.keys.merged { ports.now } else { self.sorter_free };
        ports.list_fetch.release_at(ports.now, sorted, resident);
        if job.kept > 0 {
            let pattern = |layout: &Layout| layout.list(job, job.kept);
            let shared = &mut *ports.shared;
            let stream = KEPT_LISTS;
            let write = shared.issue(ports.now, self.owner, stream, job.kept, pattern);
            self.end = self.end.max(shared.memory.known_end(write));
        }
        true
    }

    /// Passes a tile without chunks if no chunk waits for the VRU; returns whether it did.
    fn issue_empty<O>(&self, tile: u32, job: &Job, ports: &mut ChunkIssuePorts<O>) -> bool {
        // It takes no room: without this rule any number of empty tiles could queue up.
        if !ports.features.is_empty() {
            return false;
        }
        let shared = &mut *ports.shared;
        let (units, work) = (shared.units, shared.workload.tiles[tile as usize]);
        let drains = shared.drains(job, tile);
        let render = Render { last: Some(work), drains, ..Render::default() };
        let (cycles, stalls) = units.rules.vru.times(&units.vru, &render, &mut shared.rule_check);
        let chunk = Chunk {
            tile,
            cycles,
            backlog: 0,
            stalls,
            features: Arrival::NOW,
            sorted: ports.now + 1,
            colours: 0,
            coloured: ports.now,
            bytes: 0,
            pixels: Some(units.vru.pixel_bytes(&work)),
            speculative: false,
        };
        ports.features.push(ports.now, chunk);
        true
    }

    /// Issues the chunks of a tile, needed and speculative ones; returns whether none is left.
    fn issue_tile<O: Observer>(
        &mut self,
        tile: u32,
        issuing: &mut IssuingJob,
        job: &Job,
        ports: &mut ChunkIssuePorts<O>,
    ) -> bool {
        let work = &ports.shared.workload.tiles[tile as usize];
        while issuing.next_chunk < work.chunks {
            let position = issuing.next_chunk;
            let chunk = &ports.shared.workload.chunks[(work.chunk_start + position) as usize];
            if !ports.features.buffer.admits(ports.shared.units.vru.chunk_bytes(chunk)) {
                return false;
            }
            // Only behind the check of room: a chunk that waits must not move the progress twice.
            let sort = issuing.sorted.next(ports.shared.workload, job, work, position);
            self.issue_chunk(tile, position, sort, job, ports);
            issuing.next_chunk += 1;
        }
        self.speculate(tile, issuing, job, ports)
    }

    /// Issues the chunk at `position` of a tile.
    fn issue_chunk<O: Observer>(
        &mut self,
        tile: u32,
        position: u32,
        sort: Sort,
        job: &Job,
        ports: &mut ChunkIssuePorts<O>,
    ) {
        let (now, shared) = (ports.now, &mut *ports.shared);
        let (units, workload) = (shared.units, shared.workload);
        let work = &workload.tiles[tile as usize];
        let at = (work.chunk_start + position) as usize;
        let chunk = workload.chunks[at];
        let load = ChunkLoad::new(workload, at, units, &shared.context);
        let last = (position + 1 == work.chunks).then_some(*work);
        let drains = last.is_some() && shared.drains(job, tile);
        let render = Render { chunk, run: shared.context.run(at), last, drains };
        let start = u64::from(work.list_start + position * workload.geometry.chunk);
        let pattern = AccessPattern::Chunk { start, entries: u64::from(chunk.entries), load };
        let (cycles, stalls) = units.rules.vru.times(&units.vru, &render, &mut shared.rule_check);
        // A rule from outside of the crate knows nothing of queues.
        let is_built_in = units.rules.vru == Rule::BUILT_IN;
        let backlog = if is_built_in { units.vru.backlog(&render) } else { 0 };
        let bytes = load.bytes(units);
        let features = shared.issue(now, self.owner, FEATURES, bytes, |_| pattern);
        let colours = units.colour.map_or(0, |unit| unit.cycles(&chunk));
        let item = Chunk {
            tile,
            cycles,
            backlog,
            stalls,
            features,
            sorted: self.sort_chunk(tile, sort, job, now, shared),
            colours,
            coloured: if colours > 0 { NEVER } else { now },
            bytes: units.vru.chunk_bytes(&chunk),
            pixels: last.map(|tile| units.vru.pixel_bytes(&tile)),
            speculative: false,
        };
        ports.features.may_speculate = last.is_some();
        ports.features.push(now, item);
    }

    /// Queues a sort at the BSUs; returns the cycle in which it is done.
    pub(crate) fn sort<O: Observer>(
        &mut self,
        tile: u32,
        sort: Sort,
        now: u64,
        shared: &mut Shared<O>,
    ) -> u64 {
        let units = shared.units;
        let (cycles, stalls) = units.rules.bsu.times(&units.bsu, &sort, &mut shared.rule_check);
        // BSUs are a gang with one queue: sorts follow each other, however early they are asked
        // for.
        let start = self.sorter_free.max(now);
        let busy = start + cycles;
        self.sorter_free = busy + stalls;
        // A frame ends no earlier than its last sort, even a speculative one.
        self.end = self.end.max(self.sorter_free);
        self.ledger.book(State::Busy(tile), start, busy, shared.observer);
        self.ledger.book(State::Stalled(Stall::BANK), busy, self.sorter_free, shared.observer);
        self.sorter_free
    }

    /// Queues the sort of a chunk; merged chunks that nobody looks through need none.
    fn sort_chunk<O: Observer>(
        &mut self,
        tile: u32,
        sort: Sort,
        job: &Job,
        now: u64,
        shared: &mut Shared<O>,
    ) -> u64 {
        if job.keys.merged && sort == Sort::default() {
            return now;
        }
        self.sort(tile, sort, now, shared)
    }

    /// Issues chunks of a tile speculatively while the queue allows it; returns whether there is
    /// nothing left to speculate on.
    fn speculate<O: Observer>(
        &mut self,
        tile: u32,
        issuing: &mut IssuingJob,
        job: &Job,
        ports: &mut ChunkIssuePorts<O>,
    ) -> bool {
        let (now, shared) = (ports.now, &mut *ports.shared);
        let (units, workload) = (shared.units, shared.workload);
        let (work, chunk) = (&workload.tiles[tile as usize], workload.geometry.chunk);
        // That the tile is done is known only when its last needed chunk has been rendered (A30).
        while ports.features.may_speculate && issuing.speculated < units.vru.spec.speculation {
            let issued = work.loaded + issuing.speculated * chunk;
            let entries = work.entries.saturating_sub(issued).min(chunk);
            if entries == 0 {
                break;
            }
            let bytes = u64::from(entries) * units.vru.feature;
            if !ports.features.buffer.admits(bytes) {
                return false;
            }
            // Features of one level: those of the second are read when an entry is needed.
            let load = ChunkLoad { features: u64::from(entries), ..ChunkLoad::default() };
            let start = u64::from(work.list_start + issued);
            let pattern = AccessPattern::Chunk { start, entries: u64::from(entries), load };
            // The keys of a group may have been sorted for another tile of it.
            let of = |is_done: bool| if is_done { 0 } else { u64::from(entries) };
            let keys = of(job.group.is_some() || job.keys.merged);
            let sort = Sort { keys, filtered: of(job.group.is_none()) };
            // Charged here, because the totals of the frame know nothing of chunks that are
            // dropped.
            let (bsu, check) = (&units.rules.bsu, &mut shared.rule_check);
            bsu.charge(&units.bsu, &sort, &mut self.speculation, check);
            units.vru.charge_unused(entries, &mut self.speculation);
            let read = load.bytes(units);
            self.speculation.charge(Phase::Rendering, DRAM_READ, read);
            let features = shared.issue(now, self.owner, FEATURES, read, |_| pattern);
            let item = Chunk {
                tile,
                cycles: 0,
                backlog: 0,
                stalls: 0,
                features,
                sorted: self.sort_chunk(tile, sort, job, now, shared),
                colours: 0,
                coloured: now,
                bytes,
                pixels: None,
                speculative: true,
            };
            ports.features.push(now, item);
            issuing.speculated += 1;
        }
        true
    }
}
