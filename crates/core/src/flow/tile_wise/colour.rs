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

use super::VruSpec;
use crate::flow::tile_wise::ccu::SH_COLOUR_WORK;
use crate::flow::tile_wise::vru::PIXEL_FINISH;
use crate::flow::tile_wise::{CcuSpec, CodebookSpec, Fetch};
use crate::machine::Machine;
use crate::stage::{DoubleDecl, StageDecl, also, buffer, buffer_id, part, sram_read, stage_id};
use crate::workload::ChunkWork;
use powergs_energy::action::{ActionCounts, BufferId, Memory, Phase, StageId};
use powergs_energy::flops;
use powergs_frame::scene::ShDegree;

/// What the unit declares.
pub const COLOUR: StageDecl = StageDecl {
    units: Some(|m| if has_units(m) { m.of_type::<VruSpec>().cores } else { 0 }),
    counted_in: Some(("ccu", "operations")),
    also_works: &[also("sh-colour").a_cycle(|m| {
        let one = f64::from(m.of_type::<CcuSpec>().operations.sh_colour.max(1));
        f64::from(m.of_type::<VruSpec>().colour_operations_per_cycle) / one
    })],
    parts: &[part("operations", "Operations a cycle.", |m| {
        f64::from(m.of_type::<VruSpec>().colour_operations_per_cycle)
    })],
    also_waits: &["features", "list", "spill"],
    after: Some("qsu"),
    input: "chunks whose features are there",
    doubles: &[DoubleDecl {
        name: "vru.colour-operations-per-cycle",
        keys: &["vru.colour-operations-per-cycle"],
        assumptions: &["A103"],
        is_there: has_units,
    }],
    behind: &["A103", "A31"],
    ..StageDecl::new(
        "colour",
        "colour units",
        Phase::Rendering,
        "Colour unit of a core: evaluates the colours that tiles read when they first \
         load a splat (`ccu.fetch = \"lazy-colour\"`). Keys: `vru.colour-...`.",
    )
};

/// What a codebook declares: the unit that evaluates colours has it.
pub const CODEBOOK: StageDecl = StageDecl {
    buffers: &[buffer("codebook", "codebook", |m| Memory {
        bank: m.of_type::<CodebookSpec>().bank(),
        banks: match m.of_type::<CodebookSpec>().entries {
            0 => 0,
            _ => colour_units(m).saturating_mul(m.of_type::<CodebookSpec>().banks),
        },
        word: m.of_type::<CodebookSpec>().word,
        two_ports: false,
    })
    .full()
    .sized_by("entries")],
    ..StageDecl::new(
        "codebook",
        "codebooks of colours",
        Phase::Preprocessing,
        "Codebook: coefficients of colours that records name by a number. Keys: \
         `codebook`.",
    )
};

/// Coefficients of colours that records name by a number.
pub const CODES: BufferId = buffer_id("codebook");

/// The colour units.
pub const UNITS: StageId = stage_id(COLOUR.key);

/// Whether colours have units of their own, in the cores.
fn has_units(m: &Machine) -> bool {
    m.of_type::<CcuSpec>().fetch == Fetch::LazyColour
}

/// How many units evaluate colours: CCUs, or cores.
fn colour_units(m: &Machine) -> u32 {
    if has_units(m) { m.of_type::<VruSpec>().cores } else { m.of_type::<CcuSpec>().units }
}

/// Operations of a colour of a further level: as many as of a finished pixel.
const LEVEL_OPERATIONS: u64 = 6;

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
        has_units(machine).then(|| Colour {
            rate: u64::from(machine.tiles().vru.colour_operations_per_cycle),
            latency: u64::from(machine.tiles().vru.colour_latency),
            operations: operations(&machine.tiles().ccu, degree),
            codebook: machine.tiles().codebook.of_degree(degree),
        })
    }

    /// Cycles for which a chunk holds the entry of the unit; 0 where it reads no colour.
    pub fn cycles(&self, chunk: &ChunkWork) -> u64 {
        let operations = u64::from(chunk.first_loads) * self.operations
            + u64::from(chunk.level_loads) * LEVEL_OPERATIONS;
        let lookups = u64::from(chunk.first_loads) * self.codebook.cycles();
        operations.div_ceil(self.rate).max(lookups)
    }

    /// Charges the colours of a chunk.
    pub(crate) fn charge(&self, chunk: &ChunkWork, actions: &mut ActionCounts) {
        // Three multiplications and additions, as for a background.
        let levels = u64::from(chunk.level_loads);
        actions.charge(Phase::Rendering, PIXEL_FINISH, levels);
        let first = u64::from(chunk.first_loads);
        actions.charge(Phase::Rendering, SH_COLOUR_WORK, first);
        let looked_up = self.codebook.bytes(first);
        actions.charge(Phase::Rendering, sram_read(CODES), looked_up);
    }
}
