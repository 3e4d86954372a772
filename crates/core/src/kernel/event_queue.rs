//! Event queue: the cycle in which each agent acts next.

use std::ops::Range;

use super::memory::NEVER;

/// The queue for a range of agents: a tournament tree over their next cycles.
#[derive(Debug)]
pub(crate) struct EventQueue {
    first: usize,
    /// Leaves of the tree: a power of two, at least as many as agents.
    leaves: usize,
    /// Next cycles: of agent `first + i` at `leaves + i`; inner nodes hold the minimum of their
    /// children.
    cycles: Vec<u64>,
}

impl EventQueue {
    /// A queue in which all `agents` act in cycle `start`.
    pub(crate) fn new(agents: &Range<usize>, start: u64) -> Self {
        let leaves = agents.len().next_power_of_two();
        let mut queue = Self { first: agents.start, leaves, cycles: vec![NEVER; 2 * leaves] };
        agents.clone().for_each(|agent| queue.set(agent, start));
        queue
    }

    /// Sets the cycle in which an agent acts next.
    #[inline]
    pub(crate) fn set(&mut self, agent: usize, cycle: u64) {
        let mut node = self.leaves + agent - self.first;
        self.cycles[node] = cycle;
        while node > 1 {
            node /= 2;
            self.cycles[node] = self.cycles[2 * node].min(self.cycles[2 * node + 1]);
        }
    }

    /// Makes an agent act no later than in `cycle`.
    pub(crate) fn wake_by(&mut self, agent: usize, cycle: u64) {
        let set = self.cycles[self.leaves + agent - self.first];
        self.set(agent, set.min(cycle));
    }

    /// The cycle of the next event.
    #[inline]
    pub(crate) fn next_cycle(&self) -> u64 {
        self.cycles[1]
    }

    /// The agent of the next event: of several in one cycle, the one with the lowest number.
    #[inline]
    pub(crate) fn next_agent(&self) -> usize {
        let (mut node, next_cycle) = (1, self.next_cycle());
        while node < self.leaves {
            node = 2 * node + usize::from(self.cycles[2 * node] != next_cycle);
        }
        self.first + node - self.leaves
    }
}
