//! Agents, and the loop that lets each act when it has something to do.

use std::fmt;
use std::ops::Range;
use std::panic::resume_unwind;

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

    /// Whether the frame is still wanted: what its task says.
    fn halt(&self) -> Halt<'_> {
        Halt::NEVER
    }
}

/// Asks whether a frame under way is still wanted.
#[derive(Clone, Copy)]
pub struct Halt<'a>(Option<&'a (dyn Fn() -> bool + Sync)>);

impl Default for Halt<'_> {
    fn default() -> Self {
        Halt::NEVER
    }
}

impl fmt::Debug for Halt<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "asked" } else { "never" })
    }
}

impl<'a> Halt<'a> {
    /// It is, to its end.
    pub const NEVER: Halt<'static> = Halt(None);

    /// It is until this is true.
    pub fn when(is_due: &'a (dyn Fn() -> bool + Sync)) -> Halt<'a> {
        Halt(Some(is_due))
    }

    /// Unwinds with [`Halted`] if the frame is not wanted any more: half of a frame is no use to
    /// anybody on the way, and whoever began it catches that.
    fn look(self) {
        if self.0.is_some_and(|is_due| is_due()) {
            resume_unwind(Box::new(Halted));
        }
    }
}

/// What a frame unwinds with that nobody wants any more.
#[derive(Debug, Clone, Copy)]
pub struct Halted;

/// Events between two looks at whether the frame is wanted: some milliseconds.
const LOOK_EVENTS: u32 = 1 << 16;

/// Cycles of the memory alone between two such looks.
const LOOK_CYCLES: u64 = 1 << 20;

/// Runs some agents from cycle `start` until none has an event left.
pub fn drive(all: &mut impl Agents, agents: Range<usize>, start: u64) {
    let mut events = EventQueue::new(&agents, start);
    let (mut now, mut acted) = (start, 0_u32);
    // What others have asked of the memory since the last phase goes before what these ask.
    while start > 0 && all.advance(start).is_some() {}
    while now != NEVER {
        while events.next_cycle() == now {
            let agent = events.next_agent();
            let wake = all.step(agent, now);
            debug_assert!(wake > now, "no event after cycle {now}");
            events.set(agent, wake);
            acted += 1;
            if acted == LOOK_EVENTS {
                acted = 0;
                all.halt().look();
            }
            if let Some(woken) = all.woken() {
                for other in woken.start..woken.end.min(agents.end) {
                    events.wake_by(other, now + u64::from(other <= agent));
                }
            }
        }
        // The memory may be busy with others for long: then in pieces.
        let mut piece = now;
        loop {
            let next = events.next_cycle();
            piece = if next == NEVER { next } else { next.min(piece.saturating_add(LOOK_CYCLES)) };
            match all.advance(piece) {
                Some((cycle, owner)) => events.wake_by(owner as usize, cycle.max(now + 1)),
                None if piece == next => break,
                None => all.halt().look(),
            }
        }
        now = events.next_cycle();
    }
}
