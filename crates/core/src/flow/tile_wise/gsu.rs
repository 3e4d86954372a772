//! The `[gsu]` table: how lists are sorted, by [`qsu`](super::qsu) and [`bsu`](super::bsu).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DepthKey, PivotRule};
use crate::flow::over::kept_order::ListKeeping;
use crate::machine::{Exclusion, KeyValues, Optional};

/// The `[gsu]` table; counts are per core.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct GsuSpec {
    /// Quick sorting units per core.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units per core"))]
    pub qsu_per_core: u32,
    /// Pivots of a QSU: one pass splits a list into `pivots + 1` parts.
    #[schemars(range(min = 1, max = 1023), extend("x-unit" = "pivots"))]
    pub pivots: u32,
    /// Keys per cycle of one QSU.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "keys per cycle"))]
    pub keys_per_cycle: u32,
    /// Pipeline latency of one QSU pass, cycles.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub qsu_latency: u32,
    /// Bitonic sorting units per core.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units per core"))]
    pub bsu_per_core: u32,
    /// Inputs of the bitonic network.
    #[schemars(range(min = 2, max = 1024), extend("x-unit" = "keys"))]
    pub bsu_width: u32,
    /// Pipeline latency of the network, cycles.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub bsu_latency: u32,
    /// Tiles whose lists a core holds or has asked for ahead of the one that is rendered.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "tiles"))]
    pub queue: u32,
    /// Where the keys of a pass go.
    pub spill: Spill,
    /// How pivots are chosen; the order that comes out is checked with it.
    pub pivot_rule: PivotRule,
    /// What of a depth is in a key.
    pub depth: DepthKey,
    /// Where the order of a list comes from.
    #[serde(rename = "impl")]
    pub implementation: GsuImpl,
    /// Sorted parts that a merge takes together.
    #[serde(default = "merged_parts")]
    #[schemars(range(min = 2, max = 1024), extend("x-unit" = "parts"))]
    pub fan_in: u32,
    /// Frames after which every list is sorted from nothing again.
    #[serde(default = "reused_frames")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "frames"))]
    pub reuse_period: u32,
    /// How far a splat may be from a tile to be in its list of several frames.
    #[serde(default = "margin")]
    #[schemars(range(min = 0, max = 64), extend("x-unit" = "pixels"))]
    pub margin: u32,
    /// Who knows the depths of the entries that are kept.
    #[serde(default = "deferred")]
    pub depth_update: DepthUpdate,
    /// Weights that are made of depths in a cycle, per core.
    #[serde(default = "weights")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "depths per cycle"))]
    pub weights_per_cycle: u32,
}

impl GsuSpec {
    /// Comparisons of a key with others in one pass: with pivots, or with the heads of other parts.
    pub fn comparisons(&self) -> u32 {
        match self.implementation {
            GsuImpl::Split | GsuImpl::Update => self.pivots,
            GsuImpl::Merge | GsuImpl::Last | GsuImpl::Shared => self.fan_in.saturating_sub(1),
            GsuImpl::None => 0,
        }
    }

    /// Whether there are units that sort.
    pub fn sorts(&self) -> bool {
        self.implementation != GsuImpl::None
    }

    /// Whether lists are sorted whole, chunk by chunk, and merged.
    pub fn merges(&self) -> bool {
        matches!(self.implementation, GsuImpl::Merge) || self.keeps_lists()
    }

    /// How frames go through lists of frames before; `None` where they do not.
    pub fn keeping(&self) -> Option<ListKeeping> {
        match self.implementation {
            GsuImpl::Last => Some(ListKeeping::Last),
            GsuImpl::Shared => {
                Some(ListKeeping::Shared { period: self.reuse_period, margin: self.margin })
            }
            GsuImpl::Split | GsuImpl::Merge | GsuImpl::Update | GsuImpl::None => None,
        }
    }

    /// Whether frames go through lists of frames before.
    pub fn keeps_lists(&self) -> bool {
        self.keeping().is_some()
    }

    /// Frames after which every list is sorted from nothing; 1 for every frame.
    pub fn period(&self) -> u32 {
        if self.implementation == GsuImpl::Update { self.reuse_period } else { 1 }
    }
}

/// A75.
fn deferred() -> DepthUpdate {
    DepthUpdate::Deferred
}

/// A134.
fn margin() -> u32 {
    16
}

/// A131.
fn weights() -> u32 {
    256
}

/// A126.
fn merged_parts() -> u32 {
    2
}

/// As long as a number says.
fn reused_frames() -> u32 {
    65_536
}

/// Where the order of a list comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GsuImpl {
    /// Every list is split at pivots until its parts fit a chunk, and a chunk is sorted when it is
    /// needed, in every frame.
    Split,
    /// Every list is sorted chunk by chunk, and the chunks are merged, in every frame.
    Merge,
    /// The order of the frame before is updated, until `reuse-period` is over.
    Update,
    /// A frame goes through the lists of the frame before as they are; its own are merged
    /// meanwhile, for the next one.
    Last,
    /// Lists with a margin are merged every `reuse-period` frames, and go for all of these.
    Shared,
    /// Nobody sorts: blending does not depend on the order. Every entry has a weight by its depth,
    /// sums are divided by those of the weights, and nothing stops.
    None,
}

impl GsuImpl {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            GsuImpl::Split => "split",
            GsuImpl::Merge => "merge",
            GsuImpl::Update => "update",
            GsuImpl::Last => "last",
            GsuImpl::Shared => "shared",
            GsuImpl::None => "none",
        }
    }
}

/// Who knows the depths of the entries that an updated list keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DepthUpdate {
    /// The list: rendering, which reads the features of its entries anyway, has left them in it in
    /// the frame before.
    Deferred,
    /// They are read from the projected records before the list is sorted.
    Fetched,
}

/// Where the keys of a sorting pass go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spill {
    /// They stay in the sorting buffer; what does not fit is written to DRAM and read back.
    Overflow,
    /// All of them are written to DRAM and read back in every pass (Neo's model of GSCore).
    All,
}

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[
    Optional {
        what: "lists that are merged",
        switch: "gsu.impl",
        keys: &["gsu.fan-in"],
        with: &["gsu.impl=merge"],
        is_there: |m| m.of_type::<GsuSpec>().merges(),
    },
    Optional {
        what: "an order for several frames",
        switch: "gsu.impl",
        keys: &["gsu.reuse-period"],
        with: &["gsu.impl=update", "binning.impl=free"],
        is_there: |m| {
            matches!(m.of_type::<GsuSpec>().implementation, GsuImpl::Update | GsuImpl::Shared)
        },
    },
    Optional {
        what: "`gsu.impl` = \"shared\"",
        switch: "gsu.impl",
        keys: &["gsu.margin"],
        with: &[
            "gsu.impl=shared",
            "gsu.reuse-period=6",
            "binning.impl=free",
            "record.entry-bitmap=false",
            "fovea=none",
        ],
        is_there: |m| m.of_type::<GsuSpec>().implementation == GsuImpl::Shared,
    },
    Optional {
        what: "`gsu.impl` = \"update\"",
        switch: "gsu.impl",
        keys: &["gsu.depth-update"],
        with: &["gsu.impl=update", "binning.impl=free"],
        is_there: |m| m.of_type::<GsuSpec>().implementation == GsuImpl::Update,
    },
    Optional {
        what: "`gsu.impl` = \"none\"",
        switch: "gsu.impl",
        keys: &["gsu.weights-per-cycle", "vru.divisions-per-cycle"],
        with: &["gsu.impl=none", "vru.termination=none", "fovea=none"],
        is_there: |m| !m.of_type::<GsuSpec>().sorts(),
    },
];

/// What its choices exclude.
pub(super) const EXCLUDES: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Is("gsu.impl", &["none"]),
        off: "split",
        other: KeyValues::Not("vru.termination", &["none"]),
        instead: "none",
        because: "without an order no pixel knows that the rest is hidden",
    },
    Exclusion {
        choice: KeyValues::Is("gsu.impl", &["none"]),
        off: "split",
        other: KeyValues::Unlike("geometry.sort-group", "geometry.tile"),
        instead: "",
        because: "nobody looks through the list of a group",
    },
    Exclusion {
        choice: KeyValues::Is("gsu.impl", &["last", "shared"]),
        off: "merge",
        other: KeyValues::Unlike("geometry.sort-group", "geometry.tile"),
        instead: "",
        because: "lists are kept tile by tile",
    },
    Exclusion {
        choice: KeyValues::Is("gsu.impl", &["last", "shared"]),
        off: "merge",
        other: KeyValues::Is("record.entry-bitmap", &["true"]),
        instead: "false",
        because: "sub-tiles of the frame before would be those of splats that have moved",
    },
    Exclusion {
        choice: KeyValues::Is("gsu.impl", &["last", "shared"]),
        off: "merge",
        other: KeyValues::Not("fovea.accumulators", &["0"]),
        instead: "0",
        because: "how levels are kept is not known",
    },
];
