//! Colour unit of a core: evaluates the colours that tiles read when they first load a splat
//! (`ccu.fetch = "lazy-colour"`).
//!
//! Timing rule: a core has one, between the memory and its feature buffer. It makes
//! `vru.colour-operations-per-cycle` operations a cycle, so that a chunk holds its entry for
//! `ceil(operations / colour-operations-per-cycle)` cycles: a colour takes `operations.sh-colour`
//! of the `[ccu]` table (in proportion to the SH degree of the scene), one of a further level in
//! foveated frames as many as a finished pixel. Chunks enter in the order in which they were
//! issued, each when all that it reads has arrived and the chunk before has left the entry; its
//! colours are there `vru.colour-latency` cycles after it has left. Meanwhile the next chunk is in
//! the entry, and units render the one before: over a tile a chunk takes the longer of its
//! rendering and its colours. A chunk that reads no colour passes by (A31).
//!
//! With a codebook a colour reads an entry of the core's copy beside the arithmetic (A116).
//!
//! Where colours are evaluated before sorting, by the CCUs, there is no such unit.

use super::machine::{CcuSpec, CodebookSpec, Fetch, Machine};
use crate::workload::ChunkWork;
use powergs_energy::action::{Action, ActionCounts, Buffer, Stage};
use powergs_energy::flops;
use powergs_frame::scene::ShDegree;

/// The unit of one core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour {
    /// Operations a cycle.
    pub rate: u64,
    /// Cycles from its entry to a colour.
    pub latency: u64,
    /// Operations of a colour of the scene's SH degree.
    operations: u64,
    /// Its codebook.
    codebook: CodebookSpec,
}

/// Operations of a colour of this SH degree, in the count of a machine.
pub(crate) fn operations(ccu: &CcuSpec, degree: ShDegree) -> u64 {
    (f64::from(ccu.operations.sh_colour) * flops::colour_share(degree)).round() as u64
}

impl Colour {
    /// The unit of a machine; `None` where the CCUs evaluate colours.
    pub(crate) fn of(machine: &Machine, degree: ShDegree) -> Option<Colour> {
        (machine.ccu.fetch == Fetch::LazyColour).then(|| Colour {
            rate: u64::from(machine.vru.colour_operations_per_cycle),
            latency: u64::from(machine.vru.colour_latency),
            operations: operations(&machine.ccu, degree),
            codebook: machine.codebook.of_degree(degree),
        })
    }

    /// Cycles for which a chunk holds the entry of the unit; 0 where it reads no colour.
    pub fn cycles(&self, chunk: &ChunkWork) -> u64 {
        let level = u64::from(flops::flops(Action::PixelFinish));
        let operations =
            u64::from(chunk.first_loads) * self.operations + u64::from(chunk.level_loads) * level;
        let lookups = u64::from(chunk.first_loads) * self.codebook.cycles();
        operations.div_ceil(self.rate).max(lookups)
    }

    /// Charges the colours of a chunk.
    pub(crate) fn charge(&self, chunk: &ChunkWork, actions: &mut ActionCounts) {
        // Three multiplications and additions, as for a background.
        let levels = u64::from(chunk.level_loads);
        actions.charge(Stage::Rendering, Action::PixelFinish, levels);
        let first = u64::from(chunk.first_loads);
        actions.charge(Stage::Rendering, Action::ShColour, first);
        let looked_up = self.codebook.bytes(first);
        actions.charge(Stage::Rendering, Action::SramRead(Buffer::Codebook), looked_up);
    }
}
