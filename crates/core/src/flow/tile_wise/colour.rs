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

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::VruSpec;
use crate::flow::tile_wise::ccu::SH_COLOUR_WORK;
use crate::flow::tile_wise::vru::PIXEL_FINISH;
use crate::flow::tile_wise::{CcuSpec, Fetch};
use crate::machine::check::{Found, RECORD_MAX, SIZE_MAX};
use crate::machine::{Exclusion, KeyValues, Machine, Optional};
use crate::stage::{DoubleDecl, StageDecl, also, buffer, buffer_id, part, sram_read, stage_id};
use crate::workload::ChunkWork;
use powergs_base::quantity::Bytes;
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
    optional: OPTIONAL,
    excludes: EXCLUDES,
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
    optional: CODEBOOK_OPTIONAL,
    check: Some(check),
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

/// The `[codebook]` table: colours beyond the constant one as entries of a table on chip, which a
/// record names by its number. Each CCU, or with `ccu.fetch = "lazy-colour"` each core, has a whole
/// copy, which stays from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct CodebookSpec {
    /// Entries; without it, or with 0, there is none: records have the coefficients themselves.
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "entries"))]
    pub entries: u32,
    /// Bytes of an entry: the coefficients of three channels, of the highest SH degree that it is
    /// made for. A look-up for a scene of a lower degree above 0 reads all of them.
    pub entry: Bytes,
    /// Bytes of one access of one bank.
    pub word: Bytes,
    /// Banks of a copy; the words of an entry lie in as many of them.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "banks"))]
    pub banks: u32,
}

impl Default for CodebookSpec {
    fn default() -> CodebookSpec {
        CodebookSpec { entries: 0, entry: Bytes(90), word: Bytes(32), banks: 1 }
    }
}

impl CodebookSpec {
    /// The codebook of a scene of this SH degree: constant colours have no entries.
    pub(crate) fn of_degree(self, degree: ShDegree) -> CodebookSpec {
        let entries = if degree == ShDegree::ZERO { 0 } else { self.entries };
        CodebookSpec { entries, ..self }
    }

    /// Bits of the number of an entry; 0 without a codebook.
    pub(crate) fn number_bits(&self) -> u64 {
        match self.entries {
            0 => 0,
            n => u64::from(u32::BITS - (n - 1).leading_zeros()),
        }
    }

    /// Words of an entry.
    pub(crate) fn words(&self) -> u64 {
        self.entry.0.div_ceil(self.word.0.max(1))
    }

    /// Cycles for which a look-up has its copy; 0 without a codebook.
    pub(crate) fn cycles(&self) -> u64 {
        match self.entries {
            0 => 0,
            _ => self.words().div_ceil(u64::from(self.banks)),
        }
    }

    /// Bytes that so many look-ups read: an access takes a whole word.
    pub(crate) fn bytes(&self, lookups: u64) -> u64 {
        match self.entries {
            0 => 0,
            _ => lookups * self.words() * self.word.0,
        }
    }

    /// Bytes of a bank of a copy.
    pub(crate) fn bank(&self) -> Bytes {
        let words = u64::from(self.entries) * self.words();
        Bytes(words.div_ceil(u64::from(self.banks.max(1))) * self.word.0)
    }
}

/// Parts and choices that it may be without.
pub(super) const CODEBOOK_OPTIONAL: &[Optional] = &[Optional {
    what: "a codebook",
    switch: "codebook.entries",
    keys: &["codebook"],
    with: &["codebook.entries=1024"],
    is_there: |m| m.of_type::<CodebookSpec>().entries > 0,
}];

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[Optional {
    what: "colour units in its cores",
    switch: "ccu.fetch",
    keys: &["vru.colour-operations-per-cycle", "vru.colour-latency"],
    with: &[
        "ccu.fetch=lazy-colour",
        "record.feature-source=nobody",
        "vru.colour-operations-per-cycle=133",
    ],
    is_there: |m| m.of_type::<CcuSpec>().fetch == Fetch::LazyColour,
}];

/// What its choices exclude.
pub(super) const EXCLUDES: &[Exclusion] = &[Exclusion {
    choice: KeyValues::Is("vru.colour-operations-per-cycle", &["0"]),
    off: "133",
    other: KeyValues::Is("ccu.fetch", &["lazy-colour"]),
    instead: "visible-colour",
    because: "cores read colours and evaluate them",
}];

/// A table of colours has words, and is no larger than any other buffer.
pub(super) fn check(machine: &Machine, found: &mut Found) {
    let m = machine.tiles();
    let book = &m.codebook;
    if book.entries == 0 {
        return;
    }
    if book.entry == Bytes(0) || book.entry > RECORD_MAX {
        let message = format!("`codebook.entry` = {} must be 1 B to {RECORD_MAX}", book.entry);
        found.add("codebook.entry", message);
        return;
    }
    if book.word == Bytes(0) || book.word > RECORD_MAX {
        let message = format!("`codebook.word` = {} must be 1 B to {RECORD_MAX}", book.word);
        found.add("codebook.word", message);
        return;
    }
    // Entries are whole words.
    let copy = u64::from(book.entries).saturating_mul(book.words()).saturating_mul(book.word.0);
    if copy > SIZE_MAX.0 {
        let message = format!(
            "`codebook.entries` = {} of {} are above {SIZE_MAX}: a typing error?",
            book.entries, book.entry
        );
        found.add("codebook.entries", message);
    }
    let (record, pitch) = (m.record.of(ShDegree::MAX, book).colour, m.record.colour_pitch);
    if record > pitch {
        let message = format!(
            "`record.colour-pitch` = {pitch} is less than the {record} of a record with the number \
             of one of {} entries",
            book.entries
        );
        found.add("record.colour-pitch", message);
        found.ends_with("record.colour-pitch", record);
    }
}
