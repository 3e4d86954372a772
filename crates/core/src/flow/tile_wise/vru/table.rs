//! The `[vru]` and `[fovea]` tables: rendering units, and what excludes what.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::flow::tile_wise::TileWise;
use crate::machine::check::{Found, RECORD_MAX};
use crate::machine::{Exclusion, KeyValues, Machine, Optional};
use powergs_base::quantity::Bytes;

/// The `[vru]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct VruSpec {
    /// Cores; each has its own GSU and feature buffer and renders one tile at a time.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "cores"))]
    pub cores: u32,
    /// Rendering units per core.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units per core"))]
    pub units_per_core: u32,
    /// Pixels that one unit holds and rotates through its pipeline.
    #[serde(default = "quad")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "pixels"))]
    pub pixels_per_unit: u32,
    /// Pipeline latency, cycles: paid when a tile drains.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Cycles from a pixel's α to its next one, because its transmittance must be known: a unit
    /// that rotates through fewer pixels waits.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "cycles"))]
    pub recurrence: u32,
    /// Whether sub-tiles whose bitmap bit is clear are skipped.
    #[serde(default = "skips")]
    pub subtile_skipping: bool,
    /// What stops when its pixels have all stopped.
    pub termination: Termination,
    /// Further cycles for which a unit is held by an α that is not pruned (α ≥ 1/255).
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles per blend"))]
    pub blend_stall: u32,
    /// Chunks of a tile that are fetched and sorted ahead of its last needed one, before anybody
    /// knows that they are not needed.
    #[schemars(range(min = 0, max = 1024), extend("x-unit" = "chunks"))]
    pub speculation: u32,
    /// Whether the next tile enters while the last one drains.
    pub tile_overlap: bool,
    /// How the units of a core go through the sub-tiles of a tile.
    #[serde(rename = "impl")]
    pub implementation: VruImpl,
    /// Entries that wait for the units of a sub-tile, or behind the scan, with the one that is
    /// worked on.
    #[serde(default = "queued_entries")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "entries"))]
    pub subtile_queue: u32,
    /// Entries that leave the feature buffer in a cycle: units that take single pixels put so many
    /// Gaussians of one together at a time.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 256), extend("x-unit" = "entries/cycle"))]
    pub entries_per_cycle: u32,
    /// Leader pixels that a test unit looks at in a cycle.
    #[serde(default = "leaders")]
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "pixels per cycle"))]
    pub leaders_per_cycle: u32,
    /// Ratio of axes from which a splat is spiky: two leader pixels of a mini-tile are tested, and
    /// four of a smooth one. With 1 all are spiky.
    #[serde(default = "spiky")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "ratio"))]
    pub spiky_from: u32,
    /// Pixels that are divided by the sum of their weights in a cycle, per core.
    #[serde(default = "divisions")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "pixels per cycle"))]
    pub divisions_per_cycle: u32,
    /// State of a pixel that is not finished: transmittance and colour.
    pub pixel_state: Bytes,
    /// Cycles from the last pair of a sub-tile (or tile) that is needed until it is known to have
    /// stopped; pairs that begin in them are executed in vain.
    #[serde(default)]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub stop_latency: u32,
    /// Arithmetic of the colour unit of a core, which `ccu.fetch = "lazy-colour"` needs: operations
    /// of `ccu.operations.sh-colour` that it makes in a cycle.
    #[serde(default)]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations per cycle"))]
    pub colour_operations_per_cycle: u32,
    /// Pipeline latency of the colour unit, cycles.
    #[serde(default = "colour_cycles")]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub colour_latency: u32,
}

impl VruSpec {
    /// Whether entries wait in queues in front of the units.
    pub fn has_queues(&self) -> bool {
        use VruImpl::{Leaders, Parallel, Rows, Scan};
        matches!(self.implementation, Parallel | Scan | Leaders | Rows)
    }
}

/// A84: an entry in work and one that waits.
fn queued_entries() -> u32 {
    2
}

/// Units of 2x2 pixels.
fn quad() -> u32 {
    4
}

/// A131.
fn divisions() -> u32 {
    4
}

fn one() -> u32 {
    1
}

fn skips() -> bool {
    true
}

/// A128.
fn leaders() -> u32 {
    8
}

/// A128.
fn spiky() -> u32 {
    3
}

/// A103.
fn colour_cycles() -> u32 {
    16
}

/// How the units of a core go through the sub-tiles of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VruImpl {
    /// All of them together, from one sub-tile to the next for nothing: the pixel state of a tile
    /// is in the units, without area and energy of its own.
    Serial,
    /// The same, where the pixel state of a sub-tile is written to the pixel buffer and that of
    /// another is read.
    Swap,
    /// The same, where the features of a chunk are scanned once for each sub-tile, and the pixel
    /// state changes once for each of them.
    Scan,
    /// Every sub-tile has its own share of the units, with a queue in front of it.
    Parallel,
    /// The same, where sub-tiles are mini-tiles and an entry is tested at leader pixels of 2x2 of
    /// them, after the boxes of its list entry have said which test units look at it.
    Leaders,
    /// Every unit has rows of the tile, with a queue in front of it, and takes of an entry the
    /// pixels between the ends of its ellipse in each row.
    Rows,
    /// All units together take quads, 2x2 pixels, that an entry reaches and that have not stopped,
    /// of as many entries as there is room for.
    Quads,
    /// The same with single pixels: no lane is ever empty while there is work in the chunk.
    Pixels,
    /// All units together take the pixels of an entry's bounding square in the tile, as many at a
    /// time as there are units.
    Box,
}

impl VruImpl {
    /// All of them.
    pub const ALL: [VruImpl; 9] = [
        VruImpl::Serial,
        VruImpl::Swap,
        VruImpl::Scan,
        VruImpl::Parallel,
        VruImpl::Leaders,
        VruImpl::Rows,
        VruImpl::Quads,
        VruImpl::Pixels,
        VruImpl::Box,
    ];

    /// Whether units work on whole sub-tiles.
    pub const fn has_subtiles(self) -> bool {
        !matches!(self, VruImpl::Rows | VruImpl::Quads | VruImpl::Pixels | VruImpl::Box)
    }

    /// Whether pixels are looked at one by one.
    pub const fn needs_pixels(self) -> bool {
        !self.has_subtiles() || matches!(self, VruImpl::Leaders)
    }

    /// What stops together, where there is no choice.
    pub const fn stops(self) -> Option<Termination> {
        match self {
            VruImpl::Rows | VruImpl::Box => Some(Termination::Tile),
            VruImpl::Quads => Some(Termination::Quad),
            VruImpl::Pixels => Some(Termination::Pixel),
            _ => None,
        }
    }

    /// Whether the pixel state of sub-tiles goes through the pixel buffer.
    pub const fn swaps(self) -> bool {
        matches!(self, VruImpl::Swap | VruImpl::Scan)
    }

    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            VruImpl::Serial => "serial",
            VruImpl::Swap => "swap",
            VruImpl::Scan => "scan",
            VruImpl::Parallel => "parallel",
            VruImpl::Leaders => "leaders",
            VruImpl::Rows => "rows",
            VruImpl::Quads => "quads",
            VruImpl::Pixels => "pixels",
            VruImpl::Box => "box",
        }
    }
}

/// What stops together, once all of its pixels have stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Termination {
    /// Every pixel: its unit rotates through the others of 2x2.
    Pixel,
    /// The 2x2 pixels of a unit: it sleeps until the sub-tile is done.
    Quad,
    /// A sub-tile.
    Subtile,
    /// The whole tile.
    Tile,
    /// Nothing: every pixel of a tile goes through all of its list.
    None,
}

impl Termination {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            Termination::Pixel => "pixel",
            Termination::Quad => "quad",
            Termination::Subtile => "subtile",
            Termination::Tile => "tile",
            Termination::None => "none",
        }
    }
}

/// The `[fovea]` table: what a machine has for foveated frames. Of no effect on others.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct FoveaSpec {
    /// Levels that a rendering unit blends at the same time in tiles that show two: 1 for one that
    /// blends the two one after the other, 2 for one with a second accumulator; without it, or with
    /// 0, the machine cannot show foveated frames.
    #[schemars(range(min = 0, max = 2), extend("x-unit" = "levels"))]
    pub accumulators: u32,
    /// Look-ups of the level of a tile, and comparisons with it, of one CCU a cycle.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "tests per cycle"))]
    pub level_tests: u32,
    /// Record of DC colour and opacity in one further level, in DRAM.
    pub record: Bytes,
    /// Colour and opacity of the second level, added to a feature record in tiles that show two.
    pub feature: Bytes,
}

impl Default for FoveaSpec {
    /// Nothing; what there is where the file says only the accumulators (A16).
    fn default() -> FoveaSpec {
        FoveaSpec { accumulators: 0, level_tests: 1, record: Bytes(19), feature: Bytes(8) }
    }
}

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[
    Optional {
        what: "accumulators for foveated frames",
        switch: "fovea.accumulators",
        keys: &["fovea"],
        with: &["fovea.accumulators=1"],
        is_there: |m| m.of_type::<FoveaSpec>().accumulators > 0,
    },
    Optional {
        what: "units with queues",
        switch: "vru.impl",
        keys: &["vru.subtile-queue"],
        with: &["vru.impl=scan", "vru.termination=subtile", "buffers.pixel-out.capacity=2 MiB"],
        is_there: |m| m.of_type::<VruSpec>().has_queues(),
    },
    Optional {
        what: "`vru.impl` = \"leaders\"",
        switch: "vru.impl",
        keys: &["vru.leaders-per-cycle", "vru.spiky-from"],
        with: &["vru.impl=leaders", "geometry.subtile=4", "vru.termination=subtile", "fovea=none"],
        is_there: |m| m.of_type::<VruSpec>().implementation == VruImpl::Leaders,
    },
    Optional {
        what: "units that work on whole sub-tiles",
        switch: "vru.impl",
        keys: &["vru.subtile-skipping", "vru.pixels-per-unit"],
        with: &["vru.impl=serial", "geometry.subtile=4"],
        is_there: |m| m.of_type::<VruSpec>().implementation.has_subtiles(),
    },
    Optional {
        what: "units of which several stop together",
        switch: "vru.termination",
        keys: &["vru.stop-latency"],
        with: &[
            "gsu.impl=split",
            "vru.impl=serial",
            "vru.termination=subtile",
            "geometry.subtile=4",
        ],
        is_there: |m| {
            let vru = m.of_type::<VruSpec>();
            let is_alone = matches!(vru.implementation, VruImpl::Quads | VruImpl::Pixels);
            !is_alone && vru.termination != Termination::None
        },
    },
    Optional {
        what: "`vru.impl` = \"pixels\"",
        switch: "vru.impl",
        keys: &["vru.entries-per-cycle"],
        with: &["vru.impl=pixels", "vru.termination=pixel", "geometry.subtile=16", "fovea=none"],
        is_there: |m| m.of_type::<VruSpec>().implementation == VruImpl::Pixels,
    },
];

/// What its choices exclude.
pub(super) const EXCLUDES: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Is("vru.impl", &["scan"]),
        off: "serial",
        other: KeyValues::Is("vru.termination", &["tile", "none"]),
        instead: "subtile",
        because: "units that scan one sub-tile after the other stop with the sub-tile",
    },
    Exclusion {
        choice: KeyValues::Is("vru.impl", &["rows", "box"]),
        off: "",
        other: KeyValues::Not("vru.termination", &["tile", "none"]),
        instead: "tile",
        because: "such units stop with the tile",
    },
    Exclusion {
        choice: KeyValues::Is("vru.impl", &["quads"]),
        off: "",
        other: KeyValues::Not("vru.termination", &["quad", "none"]),
        instead: "quad",
        because: "such units stop with the quad",
    },
    Exclusion {
        choice: KeyValues::Is("vru.impl", &["pixels"]),
        off: "",
        other: KeyValues::Not("vru.termination", &["pixel", "none"]),
        instead: "pixel",
        because: "such units stop with the pixel",
    },
    Exclusion {
        choice: KeyValues::Is("vru.impl", &["leaders"]),
        off: "",
        other: KeyValues::Is("vru.termination", &["pixel", "quad"]),
        instead: "subtile",
        because: "its mini-tiles stop whole",
    },
    Exclusion {
        choice: KeyValues::Is("vru.impl", &["rows", "quads", "pixels", "box"]),
        off: "",
        other: KeyValues::Unlike("geometry.subtile", "geometry.tile"),
        instead: "",
        because: "such units have no sub-tiles",
    },
    Exclusion {
        choice: KeyValues::Is("vru.impl", &["leaders", "rows", "quads", "pixels", "box"]),
        off: "serial",
        other: KeyValues::Not("fovea.accumulators", &["0"]),
        instead: "0",
        because: "how such units blend two levels is not known",
    },
    Exclusion {
        choice: KeyValues::Is("vru.termination", &["none"]),
        off: "subtile",
        other: KeyValues::Not("fovea.accumulators", &["0"]),
        instead: "0",
        because: "how such units blend two levels is not known",
    },
];

/// Units that are divided over sub-tiles, or go from one to the next.
pub(super) fn check(machine: &Machine, found: &mut Found) {
    let m = machine.tiles();
    numbers(m, found);
    let (g, vru) = (&m.geometry, &m.vru);
    if g.subtile == 0 || g.tile < g.subtile {
        return;
    }
    let (units, subtiles) = (vru.units_per_core, g.subtiles());
    lanes(m, found);
    let is_divided = matches!(vru.implementation, VruImpl::Parallel | VruImpl::Leaders);
    if is_divided && !units.is_multiple_of(subtiles) {
        let message = format!(
            "`vru.impl` = \"{}\" divides `vru.units-per-core` = {units} over \
             the {subtiles} sub-tiles of a tile (`geometry.tile` = {}, `geometry.subtile` = {}): \
             it must be a multiple of {subtiles}",
            vru.implementation.name(),
            g.tile,
            g.subtile
        );
        found.add("vru.units-per-core", message);
        found.ends_with("vru.units-per-core", units.next_multiple_of(subtiles));
    }
    if vru.termination == Termination::Pixel
        && vru.implementation.has_subtiles()
        && vru.pixels_per_unit != 4
    {
        let message = format!(
            "`vru.termination` = \"pixel\" contradicts `vru.pixels-per-unit` = {}: pixels stop one \
             by one in units that rotate through 2x2 of them; set `vru.pixels-per-unit` = 4 or \
             `vru.termination` = \"subtile\"",
            vru.pixels_per_unit
        );
        found.add("vru.termination", message);
        found.ends_with("vru.pixels-per-unit", 4);
    }
    if !(1..=RECORD_MAX.0).contains(&vru.pixel_state.0) {
        let message = format!(
            "`vru.pixel-state` = {} must be from 1 B to {RECORD_MAX}: transmittance and colour of \
             a pixel",
            vru.pixel_state
        );
        found.add("vru.pixel-state", message);
    }
}

/// Units that do not work on whole sub-tiles, and pixels that never stop.
fn lanes(m: &TileWise, found: &mut Found) {
    let (g, vru) = (&m.geometry, &m.vru);
    let way = vru.implementation;
    if way == VruImpl::Leaders && g.subtile == g.tile {
        let message = format!(
            "`vru.impl` = \"leaders\" contradicts `geometry.subtile` = {} and `geometry.tile` = \
             {}: a test unit looks at 2x2 sub-tiles; set `geometry.subtile` = {} or less",
            g.subtile,
            g.tile,
            g.tile / 2
        );
        found.add("geometry.subtile", message);
        found.ends_with("geometry.subtile", g.tile / 2);
    }
    if way == VruImpl::Rows && vru.units_per_core > g.tile {
        let message = format!(
            "`vru.units-per-core` = {} contradicts `vru.impl` = \"rows\": a tile has \
             `geometry.tile` = {} rows for them; set `vru.units-per-core` = {1} or less",
            vru.units_per_core, g.tile
        );
        found.add("vru.units-per-core", message);
        found.ends_with("vru.units-per-core", g.tile);
    }
}

/// Numbers of a feature record: its form, three; its place, two; opacity; colour.
const FEATURE_NUMBERS: u64 = 9;

/// A feature record holds the numbers that rendering units read.
fn numbers(m: &TileWise, found: &mut Found) {
    let Some(format) = m.record.numbers else { return };
    let least = Bytes((FEATURE_NUMBERS * u64::from(format.bits())).div_ceil(8));
    if m.record.feature < least {
        let message = format!(
            "`record.numbers` = \"{format}\" and `record.feature` = {} contradict each other: \
             nine numbers of {} bits have {least}; set `record.feature` to that, or `numbers` to \
             a shorter format",
            m.record.feature,
            format.bits()
        );
        found.add("record.numbers", message);
        found.ends_with("record.feature", least);
    }
    if format.exponent_bits() < 4 {
        let message = format!(
            "`record.numbers` = \"{format}\": places in a tile need four bits of exponent, as in \
             e4m3"
        );
        found.add("record.numbers", message);
    }
}
