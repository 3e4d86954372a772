//! The list-fetch stage of a core: reads the lists of jobs, and partitions them in the QSUs.
//!
//! The stage takes the next job while it holds fewer than `gsu.queue` (A29). Jobs stay in order.
//! The list of a job is read once it is complete and the core's share of the sorting buffer admits
//! its keys beside those of earlier jobs. The QSUs run the passes of one job after the other. Then
//! the job waits until the chunk-issue stage is free. Its keys stay in the sorting buffer until its
//! last chunk has been sorted. Where chunks are merged, the BSUs sort them all before the passes.

use std::collections::VecDeque;

use crate::flow::tile_wise::STREAMS;
use crate::flow::tile_wise::layout::Layout;
use crate::flow::tile_wise::pipeline::chunk_issue::ChunkIssue;
use crate::flow::tile_wise::pipeline::{NEVER, Shared};
use crate::flow::tile_wise::qsu::{Keys, LIST, SPILL};
use crate::flow::tile_wise::schedule::Job;
use crate::kernel::buffer::BufferAllocator;
use crate::kernel::memory::Arrival;
use crate::kernel::stream::StreamId;
use crate::kernel::timeline::{Observer, State};
use crate::stage::Stall;

const LISTS: StreamId = STREAMS.id("lists");
const DEPTHS: StreamId = STREAMS.id("depths");
const SPILL_OUT: StreamId = STREAMS.id("spill-out");
const SPILL_IN: StreamId = STREAMS.id("spill-in");

/// The state of a job: what it waits for, or the operation in progress.
#[derive(Debug, Clone, Copy)]
enum Waiting {
    /// It waits until its list is complete.
    ListIncomplete,
    /// It waits until the sorting buffer admits its keys.
    BufferFull,
    /// Its list is being read.
    Reading(Arrival),
    /// The depths of entries that it keeps are being read.
    Depths(Arrival),
    /// The BSUs sort all of its chunks.
    Chunks(ListFetchPass),
    /// A QSU pass is in progress.
    Partitioning(ListFetchPass),
    /// It waits for the chunk-issue stage.
    Ready,
}

/// A pass of the QSUs over the keys of a job.
#[derive(Debug, Clone, Copy)]
struct ListFetchPass {
    /// Passes behind it.
    left: u32,
    /// Cycle in which its keys would have moved if no bank were in conflict.
    busy: u64,
    /// Cycle in which its keys have moved.
    keys: u64,
    /// The read of spilled keys that is in flight.
    spill: Option<Arrival>,
}

/// A job that the stage holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct FetchedJob {
    /// Position in the plan.
    pub job: u32,
    /// Its first tile.
    pub tile: u32,
    keys: Keys,
    waits: Waiting,
}

/// The stage, with the core's share of the sorting buffer.
#[derive(Debug)]
pub(super) struct ListFetch {
    core: u32,
    owner: u32,
    held: VecDeque<FetchedJob>,
    /// With static assignment, the next job of this core.
    next: u32,
    pub keys: BufferAllocator,
    /// Cycles in which keys are freed, with their bytes.
    releases: VecDeque<(u64, u64)>,
}

impl ListFetch {
    pub(crate) fn new(core: u32, owner: u32, share: u64) -> Self {
        let (held, releases) = (VecDeque::new(), VecDeque::new());
        Self { core, owner, held, next: core, keys: BufferAllocator::new(share), releases }
    }

    /// Frees the keys of jobs whose last chunk has been sorted.
    pub(crate) fn release_sorted(&mut self, now: u64) {
        while let Some((_, bytes)) = self.releases.pop_front_if(|r| r.0 <= now) {
            self.keys.release(now, bytes);
        }
    }

    /// Frees the keys of a job in cycle `at`, in which its last chunk will have been sorted.
    pub(crate) fn release_at(&mut self, now: u64, at: u64, bytes: u64) {
        if at <= now {
            self.keys.release(now, bytes);
        } else {
            self.releases.push_back((at, bytes));
        }
    }

    /// Begins the next pass, or ends partitioning, where a list has arrived or a pass is done.
    pub(crate) fn advance<O: Observer>(
        &mut self,
        now: u64,
        sorter: &mut ChunkIssue,
        shared: &mut Shared<O>,
    ) {
        // QSUs are a gang: the first job that is not ready holds up those behind it.
        for held in &mut self.held {
            let left = match held.waits {
                Waiting::Ready => continue,
                Waiting::Reading(read) if shared.memory.at(read) <= now => {
                    let job = &shared.plan.jobs[held.job as usize];
                    // Depths of kept entries are a frame old, and are read anew before the list is
                    // sorted (A75).
                    if job.depths > 0 {
                        let bytes = job.depths * shared.units.qsu.depth;
                        let pattern = |layout: &Layout| layout.depths(job);
                        let read = shared.issue(now, self.owner, DEPTHS, bytes, pattern);
                        held.waits = Waiting::Depths(read);
                        return;
                    }
                    if held.keys.merged && held.keys.sorted > 0 {
                        let sort = shared.plan.jobs[held.job as usize].chunks();
                        let keys = sorter.sort(held.tile, sort, now, shared);
                        let left = held.keys.passes;
                        // Where merges follow, what does not fit goes out and in once for the
                        // chunks as well (A126).
                        let spill = match left {
                            0 => None,
                            _ => spill_keys(held.keys, now, self.core, self.owner, shared),
                        };
                        let pass = ListFetchPass { left, busy: now, keys, spill };
                        held.waits = Waiting::Chunks(pass);
                        return;
                    }
                    held.keys.passes
                }
                Waiting::Depths(read) if shared.memory.at(read) <= now => held.keys.passes,
                Waiting::Partitioning(pass) | Waiting::Chunks(pass)
                    if pass.is_done(now, shared) =>
                {
                    pass.left
                }
                Waiting::ListIncomplete
                | Waiting::BufferFull
                | Waiting::Reading(_)
                | Waiting::Depths(_)
                | Waiting::Chunks(_)
                | Waiting::Partitioning(_) => return,
            };
            if left > 0 {
                let pass =
                    ListFetchPass::begin(held.keys, left - 1, now, self.core, self.owner, shared);
                held.waits = Waiting::Partitioning(pass);
                return;
            }
            held.waits = Waiting::Ready;
        }
    }

    /// Takes the first job out once it is ready.
    pub(crate) fn take_ready(&mut self) -> Option<FetchedJob> {
        self.held.pop_front_if(|held| matches!(held.waits, Waiting::Ready))
    }

    /// Takes jobs while there are free slots, and issues list reads while the buffer admits them.
    pub(crate) fn fetch<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        while self.held.len() < shared.units.qsu.spec.queue as usize {
            let Some((index, job)) = self.take(shared) else { break };
            let (tile, keys) = (shared.plan.tiles_of(job)[0], job.keys);
            self.held.push_back(FetchedJob {
                job: index,
                tile,
                keys,
                waits: Waiting::ListIncomplete,
            });
        }
        // Lists are read in the order of jobs: one without room holds up all behind it.
        for held in &mut self.held {
            let job = &shared.plan.jobs[held.job as usize];
            if matches!(held.waits, Waiting::ListIncomplete) && shared.lists.has(job.complete_after)
            {
                held.waits = Waiting::BufferFull;
            }
            let bytes = shared.units.qsu.resident(&held.keys);
            match held.waits {
                Waiting::ListIncomplete => return,
                Waiting::BufferFull if !self.keys.admits(bytes) => return,
                Waiting::BufferFull => {
                    self.keys.fill(now, bytes);
                    let span = |layout: &Layout| layout.list(job, job.read);
                    let read = shared.issue(now, self.owner, LISTS, job.read, span);
                    held.waits = Waiting::Reading(read);
                }
                Waiting::Reading(_)
                | Waiting::Depths(_)
                | Waiting::Chunks(_)
                | Waiting::Partitioning(_)
                | Waiting::Ready => {}
            }
        }
    }

    /// Takes the next job of this core from the schedule.
    fn take<'a, O>(&mut self, shared: &mut Shared<'a, O>) -> Option<(u32, &'a Job)> {
        let plan = shared.plan;
        // Without `static` the first core that asks takes the next job of the schedule (A29).
        let next = if plan.is_static { &mut self.next } else { &mut shared.next_job };
        let index = *next;
        let job = plan.jobs.get(index as usize)?;
        *next += if plan.is_static { shared.units.vru.spec.cores } else { 1 };
        Some((index, job))
    }

    fn working(&self) -> Option<&FetchedJob> {
        self.held.iter().find(|held| !matches!(held.waits, Waiting::Ready))
    }

    /// State of the QSUs after the events of cycle `now`.
    pub(crate) fn state(&self, now: u64) -> State {
        let Some(held) = self.working() else {
            return if self.held.is_empty() { State::Idle } else { State::Stalled(Stall::OUTPUT) };
        };
        match held.waits {
            Waiting::Partitioning(pass) if pass.busy > now => State::Busy(held.tile),
            Waiting::Partitioning(pass) if pass.keys > now => State::Stalled(Stall::BANK),
            Waiting::Chunks(pass) if pass.keys > now => State::Stalled(Stall::INPUT),
            Waiting::Partitioning(_) | Waiting::Chunks(_) => State::Stalled(SPILL),
            Waiting::Reading(_) if held.keys.held > 0 => State::Stalled(LIST),
            Waiting::Depths(_) => State::Stalled(LIST),
            Waiting::Reading(_) | Waiting::ListIncomplete => State::Stalled(Stall::INPUT),
            Waiting::BufferFull | Waiting::Ready => State::Stalled(Stall::OUTPUT),
        }
    }

    /// The stall cause of the units behind this stage while they have no work.
    pub(crate) fn wait(&self, now: u64) -> State {
        match self.state(now) {
            State::Idle => State::Idle,
            State::Stalled(cause) if cause == LIST || cause == SPILL => State::Stalled(cause),
            State::Busy(_) | State::Stalled(_) => State::Stalled(Stall::INPUT),
        }
    }

    pub(crate) fn wake<O>(&self, now: u64, shared: &Shared<O>) -> u64 {
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let at = |arrival: Arrival| later(shared.memory.at(arrival));
        // A list that is completed wakes the cores from outside; places and room are made by own
        // events.
        let working = self.working().map_or(NEVER, |held| match held.waits {
            Waiting::ListIncomplete | Waiting::BufferFull | Waiting::Ready => NEVER,
            Waiting::Reading(read) | Waiting::Depths(read) => at(read),
            Waiting::Partitioning(pass) | Waiting::Chunks(pass) => {
                let spill = pass.spill.map_or(NEVER, at);
                later(pass.busy).min(later(pass.keys)).min(spill)
            }
        });
        let is_blocked = self.held.iter().any(|held| matches!(held.waits, Waiting::BufferFull));
        // Keys that are freed matter only to a list that waits for room.
        let release = self.releases.front().map_or(NEVER, |r| later(r.0));
        working.min(if is_blocked { release } else { NEVER })
    }

    /// Closes the account of the sorting buffer at the end of the frame.
    pub(crate) fn close(&mut self, now: u64) {
        while let Some((_, bytes)) = self.releases.pop_front() {
            self.keys.release(now, bytes);
        }
    }
}

/// Writes what of the keys does not stay on chip, and reads it back.
fn spill_keys<O: Observer>(
    keys: Keys,
    now: u64,
    core: u32,
    owner: u32,
    shared: &mut Shared<O>,
) -> Option<Arrival> {
    let overflow = shared.units.qsu.overflow(&keys);
    (overflow > 0).then(|| {
        // The memory takes both requests in this order, so that nothing has to wait for the write
        // (A34).
        let pattern = |layout: &Layout| layout.spill(core, overflow);
        let out = shared.issue(now, owner, SPILL_OUT, overflow, pattern);
        // A frame ends no earlier than its last write, which is not waited for.
        shared.spilled = shared.spilled.max(shared.memory.known_end(out));
        shared.issue(now, owner, SPILL_IN, overflow, pattern)
    })
}

impl ListFetchPass {
    /// Begins a pass of `keys` with `left` passes behind it.
    fn begin<O: Observer>(
        keys: Keys,
        left: u32,
        now: u64,
        core: u32,
        owner: u32,
        shared: &mut Shared<O>,
    ) -> ListFetchPass {
        let units = shared.units;
        let one = Keys { passes: 1, before: keys.passes - left - 1, ..keys };
        let (cycles, stalls) = units.rules.qsu.times(&units.qsu, &one, &mut shared.rule_check);
        let busy = now + cycles;
        let spill = spill_keys(keys, now, core, owner, shared);
        ListFetchPass { left, busy, keys: busy + stalls, spill }
    }

    fn is_done<O>(&self, now: u64, shared: &Shared<O>) -> bool {
        self.keys <= now && self.spill.is_none_or(|spill| shared.memory.at(spill) <= now)
    }
}
