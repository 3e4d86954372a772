//! What all units have in common: how long a piece of work occupies them, and which actions it is.

use powergs_energy::action::{ActionCounts, StageId};

/// A hardware unit and its built-in timing rule. It keeps no run state: queues, buffers and stalls
/// belong to the pipeline, so that the same work always costs the same. A
/// [`UnitRule`](crate::flow::tile_wise::UnitRule) replaces the rule of a unit on one machine.
pub trait Unit {
    /// One piece of work: a batch, a list, a chunk.
    type Work;
    /// The stage that declares it.
    const STAGE: StageId;
    /// Cycles for which `work` occupies the unit, at least 1.
    fn cycles(&self, work: &Self::Work) -> u64;
    /// Further cycles for which `work` waits for the banks of the unit's buffers.
    fn bank_stalls(&self, work: &Self::Work) -> u64;
    /// Both of them.
    #[inline]
    fn times(&self, work: &Self::Work) -> (u64, u64) {
        (self.cycles(work), self.bank_stalls(work))
    }
    /// Charges what `work` does inside the chip. DRAM bytes are charged by
    /// [`traffic`](super::traffic), from the totals of the frame.
    fn charge(&self, work: &Self::Work, actions: &mut ActionCounts);
}
