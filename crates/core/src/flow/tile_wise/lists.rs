//! Lists of tiles: what their making declares. How pairs get into them is measured outside of time
//! ([`workload::binning`](crate::workload::binning)); CCUs do it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::measures;
use super::{CcuSpec, Overlap, ScheduleSpec};
use crate::machine::check::Found;
use crate::machine::{BufferSpec, Exclusion, KeyValues, Machine, Optional, Ports};
use crate::stage::{Bias, StageDecl, buffer, buffer_id, omit};
use powergs_base::quantity::Bytes;
use powergs_energy::action::{BufferId, Memory, Phase};

/// What the making of lists declares.
pub const LISTS: StageDecl = StageDecl {
    buffers: &[
        buffer("pointers", "binning.pointers", |m| memory(m, &m.of_type::<BinningSpec>().pointers))
            .full(),
        buffer("combining", "binning.combining", |m| {
            memory(m, &m.of_type::<BinningSpec>().combining)
        })
        .full(),
    ],
    stats: measures::STATS,
    omits: &[
        omit(
            "how pairs get from the order of the CCUs into the lists of tiles",
            Bias::Optimistic,
            "A90",
        )
        .by("binning.impl = \"free\"", |m| {
            m.of_type::<BinningSpec>().implementation == BinningImpl::Free
        }),
        omit("lists of early tiles used before preprocessing ends", Bias::Pessimistic, "A28")
            .by("schedule.overlap = \"none\"", |m| {
                m.of_type::<ScheduleSpec>().overlap == Overlap::None
            }),
    ],
    optional: OPTIONAL,
    excludes: EXCLUDES,
    check: Some(check),
    ..StageDecl::new(
        "lists",
        "making of tile lists",
        Phase::Preprocessing,
        "How CCUs get pairs into the lists of tiles. Keys: `binning`.",
    )
};

/// Where the next entry of each tile goes.
pub const POINTERS: BufferId = buffer_id("pointers");

/// Entries of each tile on their way to DRAM.
pub const COMBINING: BufferId = buffer_id("combining");

fn memory(m: &Machine, spec: &BufferSpec) -> Memory {
    let is_there =
        m.of_type::<BinningSpec>().implementation != BinningImpl::Free && spec.capacity.0 > 0;
    let memory = spec.shared(m.of_type::<CcuSpec>().units);
    Memory { banks: if is_there { memory.banks } else { 0 }, ..memory }
}

/// The `[binning]` table: how (splat, tile) pairs get into the lists of tiles. Without it lists are
/// there for nothing.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct BinningSpec {
    /// Who knows where the next entry of a tile goes.
    #[serde(rename = "impl")]
    pub implementation: BinningImpl,
    /// Bytes of the pointer to the end of a list, or of the counter of its entries.
    pub pointer_size: Bytes,
    /// Pointers on chip, over all CCUs; the others are in DRAM.
    pub pointers: BufferSpec,
    /// Lines of entries on their way to DRAM, over all CCUs; with `0 B` every entry is written by
    /// itself.
    pub combining: BufferSpec,
    /// Bytes of a tile that are written together: a line.
    pub line: Bytes,
    /// How bytes are written that begin inside of a line.
    pub partial: PartialWrite,
    /// Bytes of the blocks in which lists grow.
    pub block: Bytes,
}

impl Default for BinningSpec {
    /// Free lists; what there is where the file says only another method (A91).
    fn default() -> BinningSpec {
        let memory = |capacity, word| BufferSpec {
            capacity: Bytes(capacity),
            word: Bytes(word),
            banks: 2,
            ports: Ports::ReadOrWrite,
        };
        BinningSpec {
            implementation: BinningImpl::Free,
            pointer_size: Bytes(4),
            pointers: memory(16 << 10, 4),
            combining: memory(8 << 10, 8),
            line: Bytes(32),
            partial: PartialWrite::Masked,
            block: Bytes(1 << 10),
        }
    }
}

/// How lists are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BinningImpl {
    /// Nobody: entries are written back to back, as if all pointers were known and all entries of a
    /// tile came together (a published count of bytes).
    Free,
    /// A pointer for each tile to the end of its list, which grows in blocks.
    Append,
    /// The first pass over all splats counts, a sum over the tiles places the lists, the second
    /// pass writes them.
    TwoPass,
}

impl BinningImpl {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            BinningImpl::Free => "free",
            BinningImpl::Append => "append",
            BinningImpl::TwoPass => "two-pass",
        }
    }
}

/// How bytes are written that begin inside of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PartialWrite {
    /// By themselves: the memory leaves the other bytes of a burst as they are.
    Masked,
    /// With those of the line before them, which are read for that.
    ReadModifyWrite,
}

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[
    Optional {
        what: "lists that it makes itself",
        switch: "binning.impl",
        keys: &["binning"],
        with: &["binning.impl=append", "gsu.impl=split"],
        is_there: |m| m.of_type::<BinningSpec>().implementation != BinningImpl::Free,
    },
    Optional {
        what: "`binning.impl` = \"append\"",
        switch: "binning.impl",
        keys: &["binning.block"],
        with: &["binning.impl=append", "gsu.impl=split"],
        is_there: |m| m.of_type::<BinningSpec>().implementation == BinningImpl::Append,
    },
];

/// What its choices exclude.
pub(super) const EXCLUDES: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Not("binning.impl", &["free"]),
        off: "free",
        other: KeyValues::Is("gsu.impl", &["update", "last", "shared"]),
        instead: "split",
        because: "lists that are kept lie back to back",
    },
    Exclusion {
        choice: KeyValues::Is("binning.impl", &["two-pass"]),
        off: "free",
        other: KeyValues::Not("schedule.overlap", &["none"]),
        instead: "none",
        because: "nothing overlaps with two passes over all splats",
    },
    // Of what is rendered only in part.
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Not("fovea.accumulators", &["0"]),
        instead: "0",
        because: "pixels of a foveated frame have two levels",
    },
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Not("stereo.impl", &["separate"]),
        instead: "separate",
        because: "the second eye needs all that blends in the first one",
    },
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Unlike("geometry.sort-group", "geometry.tile"),
        instead: "",
        because: "tiles that are not rendered have no part in the list of a group",
    },
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Is("vru.termination", &["none"]),
        instead: "subtile",
        because: "pixels that never stop do not know what they see first",
    },
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Is("gsu.impl", &["update"]),
        instead: "split",
        because: "a list that is kept is that of a tile which is rendered in each frame",
    },
    Exclusion {
        choice: KeyValues::Is("pixels.impl", &["warped", "sampled"]),
        off: "all",
        other: KeyValues::Is("gsu.impl", &["last", "shared"]),
        instead: "split",
        because: "a list that is kept is that of a tile which is rendered in each frame",
    },
];

/// The largest line and the largest block of a list.
const LINE_MAX: Bytes = Bytes(4096);

const BLOCK_MAX: Bytes = Bytes(1 << 20);

/// Adds what is wrong with them.
fn check(machine: &Machine, found: &mut Found) {
    let m = machine.tiles();
    let b = &m.binning;
    if b.implementation == BinningImpl::Free {
        return;
    }
    let entry = Bytes(m.list_entry());
    if b.line < entry || b.line > LINE_MAX {
        let message = format!(
            "`binning.line` = {} must be from the {entry} of a list entry (`record.depth-bits`, \
             `record.id-bits`, `record.entry-bitmap`) to {LINE_MAX}",
            b.line
        );
        found.add("binning.line", message);
        if b.line < entry {
            found.ends_with("binning.line", Bytes(entry.0.next_power_of_two()));
        }
    }
    if b.combining.capacity.0 > 0 && b.combining.capacity < b.line {
        let message = format!(
            "`binning.combining.capacity` = {} holds no line of `binning.line` = {}: enlarge it, \
             or set it to 0 B for no combining",
            b.combining.capacity, b.line
        );
        found.add("binning.combining.capacity", message);
        found.ends_with("binning.combining.capacity", b.line);
    }
    if !(1..=16).contains(&b.pointer_size.0) {
        let message =
            format!("`binning.pointer-size` = {} must be from 1 B to 16 B", b.pointer_size);
        found.add("binning.pointer-size", message);
    }
    let fits = b.block.0.is_multiple_of(b.line.0.max(1)) && b.block > b.pointer_size;
    if b.implementation == BinningImpl::Append && (!fits || b.block > BLOCK_MAX) {
        let message = format!(
            "`binning.block` = {} must be a multiple of `binning.line` = {}, hold more than \
             `binning.pointer-size` = {}, and be at most {BLOCK_MAX}",
            b.block, b.line, b.pointer_size
        );
        found.add("binning.block", message);
    }
}
