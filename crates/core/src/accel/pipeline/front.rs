//! The front of a core: jobs whose lists are read and roughly sorted.
//!
//! A front takes the next job while it holds fewer than `gsu.queue` (A29). In their order, jobs
//! wait until their list is complete and their keys fit the core's share of the sorting buffer
//! beside those of earlier jobs; then the list is read. The QSUs run the passes of one job after
//! the other. Then the job waits until the middle of the core is empty. Keys stay in the sorting
//! buffer until the last chunk of their job has been sorted.

use std::collections::VecDeque;

use super::{NEVER, Shared};
use crate::accel::Stall;
use crate::accel::buffer::Room;
use crate::accel::layout::Layout;
use crate::accel::memory::Arrival;
use crate::accel::qsu::Keys;
use crate::accel::schedule::Job;
use crate::accel::timeline::{Observer, State};
use crate::action::Stage;

/// Where a job is.
#[derive(Debug, Clone, Copy)]
enum Phase {
    /// Waits until its list is complete.
    Binning,
    /// Waits for room in the sorting buffer.
    Room,
    /// The list is read.
    List(Arrival),
    /// A pass is under way.
    Pass(Pass),
    /// Waits for the middle.
    Ready,
}

#[derive(Debug, Clone, Copy)]
struct Pass {
    /// Passes after it.
    left: u32,
    /// When its keys would have moved if no bank were in the way, and when they have.
    busy: u64,
    keys: u64,
    /// The spill that is under way.
    spill: Option<Arrival>,
}

/// A job in the front.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrontJob {
    /// Position in the plan.
    pub job: u32,
    /// Its first tile.
    pub tile: u32,
    keys: Keys,
    phase: Phase,
}

/// The front, and the sorting buffer.
#[derive(Debug)]
pub(super) struct Front {
    core: u32,
    owner: u32,
    held: VecDeque<FrontJob>,
    /// With static assignment, the next job of this core.
    next: u32,
    pub keys: Room,
    /// When keys are released, and how many bytes.
    releases: VecDeque<(u64, u64)>,
}

impl Front {
    pub fn new(core: u32, owner: u32, share: u64) -> Self {
        let (held, releases) = (VecDeque::new(), VecDeque::new());
        Self { core, owner, held, next: core, keys: Room::new(share), releases }
    }

    /// Gives back the room of keys whose job has been sorted.
    pub fn release_sorted(&mut self, now: u64) {
        while let Some((_, bytes)) = self.releases.pop_front_if(|r| r.0 <= now) {
            self.keys.release(now, bytes);
        }
    }

    /// The last chunk of a job will be sorted in cycle `at`.
    pub fn release_at(&mut self, now: u64, at: u64, bytes: u64) {
        if at <= now {
            self.keys.release(now, bytes);
        } else {
            self.releases.push_back((at, bytes));
        }
    }

    /// Moves on from lists that have arrived and passes that are done.
    pub fn advance<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        for held in &mut self.held {
            let left = match held.phase {
                Phase::Ready => continue,
                Phase::List(read) if shared.memory.at(read) <= now => held.keys.passes,
                Phase::Pass(pass) if pass.is_done(now, shared) => pass.left,
                Phase::Binning | Phase::Room | Phase::List(_) | Phase::Pass(_) => return,
            };
            if left > 0 {
                let pass = begin_pass(held.keys, left - 1, now, (self.core, self.owner), shared);
                held.phase = Phase::Pass(pass);
                return;
            }
            held.phase = Phase::Ready;
        }
    }

    /// Hands the first job over once it is ready.
    pub fn hand_over(&mut self) -> Option<FrontJob> {
        self.held.pop_front_if(|held| matches!(held.phase, Phase::Ready))
    }

    /// Takes jobs while there is place, and issues reads of lists while there is room.
    pub fn fetch<O: Observer>(&mut self, now: u64, shared: &mut Shared<O>) {
        while self.held.len() < shared.design.qsu.spec.queue as usize {
            let Some((index, job)) = self.take(shared) else { break };
            let (tile, keys) = (shared.plan.tiles_of(job)[0], job.keys);
            self.held.push_back(FrontJob { job: index, tile, keys, phase: Phase::Binning });
        }
        for held in &mut self.held {
            let job = &shared.plan.jobs[held.job as usize];
            if matches!(held.phase, Phase::Binning) && shared.binned.has(job.complete_after) {
                held.phase = Phase::Room;
            }
            let bytes = shared.design.qsu.resident(&held.keys);
            match held.phase {
                Phase::Binning => return,
                Phase::Room if !self.keys.admits(bytes) => return,
                Phase::Room => {
                    self.keys.fill(now, bytes);
                    let span = |layout: &Layout| layout.list(job.list_start, job.read);
                    let read = shared.read(now, self.owner, Stage::Sorting, job.read, span);
                    held.phase = Phase::List(read);
                }
                Phase::List(_) | Phase::Pass(_) | Phase::Ready => {}
            }
        }
    }

    /// The next job of this core.
    fn take<'a, O>(&mut self, shared: &mut Shared<'a, O>) -> Option<(u32, &'a Job)> {
        let plan = shared.plan;
        let next = if plan.is_static { &mut self.next } else { &mut shared.next_job };
        let index = *next;
        let job = plan.jobs.get(index as usize)?;
        *next += if plan.is_static { shared.design.vru.spec.cores } else { 1 };
        Some((index, job))
    }

    fn working(&self) -> Option<&FrontJob> {
        self.held.iter().find(|held| !matches!(held.phase, Phase::Ready))
    }

    /// What the QSUs do, as of the end of the events of cycle `now`.
    pub fn state(&self, now: u64) -> State {
        let Some(held) = self.working() else {
            return if self.held.is_empty() { State::Idle } else { State::Stalled(Stall::Output) };
        };
        match held.phase {
            Phase::Pass(pass) if pass.busy > now => State::Busy(held.tile),
            Phase::Pass(pass) if pass.keys > now => State::Stalled(Stall::Bank),
            Phase::Pass(_) => State::Stalled(Stall::Spill),
            Phase::List(_) if held.keys.held > 0 => State::Stalled(Stall::List),
            Phase::List(_) | Phase::Binning => State::Stalled(Stall::Input),
            Phase::Room | Phase::Ready => State::Stalled(Stall::Output),
        }
    }

    /// Why units behind an otherwise empty core wait.
    pub fn wait(&self, now: u64) -> State {
        match self.state(now) {
            State::Idle => State::Idle,
            State::Stalled(cause) if cause.is_dram() => State::Stalled(cause),
            State::Busy(_) | State::Stalled(_) => State::Stalled(Stall::Input),
        }
    }

    pub fn wake<O>(&self, now: u64, shared: &Shared<O>) -> u64 {
        let later = |cycle: u64| if cycle > now { cycle } else { NEVER };
        let at = |arrival: Arrival| later(shared.memory.at(arrival));
        let working = self.working().map_or(NEVER, |held| match held.phase {
            Phase::Binning | Phase::Room | Phase::Ready => NEVER,
            Phase::List(read) => at(read),
            Phase::Pass(pass) => {
                let spill = pass.spill.map_or(NEVER, at);
                later(pass.busy).min(later(pass.keys)).min(spill)
            }
        });
        let waits_for_room = self.held.iter().any(|held| matches!(held.phase, Phase::Room));
        let release = self.releases.front().map_or(NEVER, |r| later(r.0));
        working.min(if waits_for_room { release } else { NEVER })
    }

    /// Ends the account of the sorting buffer.
    pub fn close(&mut self, now: u64) {
        while let Some((_, bytes)) = self.releases.pop_front() {
            self.keys.release(now, bytes);
        }
    }
}

impl Pass {
    fn is_done<O>(&self, now: u64, shared: &Shared<O>) -> bool {
        self.keys <= now && self.spill.is_none_or(|spill| shared.memory.at(spill) <= now)
    }
}

fn begin_pass<O: Observer>(
    keys: Keys,
    left: u32,
    now: u64,
    (core, owner): (u32, u32),
    shared: &mut Shared<O>,
) -> Pass {
    let qsu = &shared.design.qsu;
    let overflow = qsu.overflow(&keys);
    let busy = now + qsu.pass_cycles(&keys);
    let done = busy + qsu.pass_stalls(&keys);
    let mut pass = Pass { left, busy, keys: done, spill: None };
    if overflow > 0 {
        let span = |layout: &Layout| layout.spill(core, overflow);
        shared.write(now, owner, Stage::Sorting, overflow, span);
        pass.spill = Some(shared.read(now, owner, Stage::Sorting, overflow, span));
    }
    pass
}
