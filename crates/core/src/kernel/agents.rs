//! Agents, and the loop that lets each act when it has something to do.

use std::ops::Range;

use super::event_queue::EventQueue;
use super::memory::NEVER;

/// What acts by itself in one dataflow, with everything that it shares: CCUs and cores, or the
/// engines of a region. Agents are numbered; within a cycle they act in that order.
pub trait Agents {
    /// Lets an agent act in cycle `now`; returns the cycle in which it acts next by itself, later
    /// than `now`, or [`NEVER`].
    fn step(&mut self, agent: usize, now: u64) -> u64;

    /// Agents that what just happened lets act: those behind it in the same cycle, those before it
    /// in the next.
    fn woken(&mut self) -> Option<Range<usize>> {
        None
    }

    /// Runs the memory until a request is done, at most until cycle `until`: the cycle, and the
    /// agent of the request ([`Memory::advance`](super::memory::Memory::advance)).
    fn advance(&mut self, until: u64) -> Option<(u64, u32)>;
}

/// Runs some agents from cycle `start` until none has an event left.
pub fn drive(all: &mut impl Agents, agents: Range<usize>, start: u64) {
    let mut events = EventQueue::new(&agents, start);
    let mut now = start;
    // What others have asked of the memory since the last phase goes before what these ask.
    while start > 0 && all.advance(start).is_some() {}
    while now != NEVER {
        while events.next_cycle() == now {
            let agent = events.next_agent();
            let wake = all.step(agent, now);
            debug_assert!(wake > now, "no event after cycle {now}");
            events.set(agent, wake);
            if let Some(woken) = all.woken() {
                for other in woken.start..woken.end.min(agents.end) {
                    events.wake_by(other, now + u64::from(other <= agent));
                }
            }
        }
        while let Some((cycle, owner)) = all.advance(events.next_cycle()) {
            events.wake_by(owner as usize, cycle.max(now + 1));
        }
        now = events.next_cycle();
    }
}
