//! Whose turn it is: when each agent acts next.

use std::ops::Range;

use super::NEVER;

/// Agents of a range of numbers, as a tree of minima.
#[derive(Debug)]
pub(super) struct Turns {
    first: usize,
    /// Leaves of the tree: a power of two, at least as many as agents.
    leaves: usize,
    /// Cycles: of agent `first + i` at `leaves + i`, of a node the smaller one of its children.
    cycles: Vec<u64>,
}

impl Turns {
    /// All `agents` act in cycle `start`.
    pub fn new(agents: &Range<usize>, start: u64) -> Self {
        let leaves = agents.len().next_power_of_two();
        let mut turns = Self { first: agents.start, leaves, cycles: vec![NEVER; 2 * leaves] };
        agents.clone().for_each(|agent| turns.set(agent, start));
        turns
    }

    /// Says when an agent acts next.
    #[inline]
    pub fn set(&mut self, agent: usize, cycle: u64) {
        let mut node = self.leaves + agent - self.first;
        self.cycles[node] = cycle;
        while node > 1 {
            node /= 2;
            self.cycles[node] = self.cycles[2 * node].min(self.cycles[2 * node + 1]);
        }
    }

    /// Lets an agent act in `cycle`, if it would act later.
    pub fn hasten(&mut self, agent: usize, cycle: u64) {
        let set = self.cycles[self.leaves + agent - self.first];
        self.set(agent, set.min(cycle));
    }

    /// The next cycle in which anybody acts.
    #[inline]
    pub fn soonest(&self) -> u64 {
        self.cycles[1]
    }

    /// The agent that acts next: of several in one cycle, the one with the lowest number.
    #[inline]
    pub fn next(&self) -> usize {
        let (mut node, soonest) = (1, self.soonest());
        while node < self.leaves {
            node = 2 * node + usize::from(self.cycles[2 * node] != soonest);
        }
        self.first + node - self.leaves
    }
}
