//! The `[ccu]` table, with the parts of units that convert, and what excludes what.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::machine::check::{Found, RECORD_MAX};
use crate::machine::{Exclusion, KeyValues, Machine, Optional};
use crate::workload::STORAGE_BLOCK;
use powergs_base::quantity::Bytes;

/// When the colour (SH) record of a Gaussian is fetched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fetch {
    /// The CCU reads the whole record of every Gaussian (the NeRArch-Sim model of GSCore).
    Everything,
    /// Positions of all, everything else of survivors.
    GeometryFirst,
    /// Positions of all, geometry of survivors, colour of those with a tile (GSCore, which converts
    /// what is visible before sorting).
    VisibleColour,
    /// Positions of all, geometry of survivors, colour when a tile first loads the splat (the
    /// PowerGS model of GSCore).
    LazyColour,
}

/// The `[ccu]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CcuSpec {
    /// Number of culling and conversion units.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units"))]
    pub units: u32,
    /// Arithmetic of one CCU, without its box tests: operations of the table `operations` that it
    /// makes in a cycle.
    #[schemars(range(min = 1, max = 1048576), extend("x-unit" = "operations per cycle"))]
    pub operations_per_cycle: u32,
    /// Arithmetic for culling alone, beside that of the other steps; 0: they share theirs.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "operations per cycle"))]
    pub cull_operations_per_cycle: u32,
    /// Arithmetic for colours alone, beside that of the other steps; 0: they share theirs.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "operations per cycle"))]
    pub colour_operations_per_cycle: u32,
    /// What the steps of a conversion take.
    pub operations: CcuOperations,
    /// Intersection units of one CCU: box tests per cycle.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "tests per cycle"))]
    pub intersection_units: u32,
    /// Cycles from a record to its list entries.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Records that one CCU takes from DRAM in one batch, at most as many as fit its input
    /// buffer.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "Gaussians"))]
    pub batch: u32,
    /// Batches that one CCU has asked for and not yet converted, at most.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "batches"))]
    pub queue: u32,
    /// When the records of a Gaussian are read.
    pub fetch: Fetch,
    /// Gaussians in storage order that have a common record of their bounds, which is tested first:
    /// a multiple of 32, or 0 for none.
    #[serde(default)]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "Gaussians"))]
    pub clusters: u32,
    /// Bytes of the bounds of a cluster.
    #[serde(default = "bounds")]
    #[schemars(extend("x-unit" = "bytes"))]
    pub cluster: Bytes,
}

impl CcuSpec {
    /// Gaussians a cycle, at most 1, that each engine takes through its steps: that of culling,
    /// that of projection and boxes, that of colours. Steps that share an engine share its rate.
    pub fn gaussians_per_cycle(&self) -> [f64; 3] {
        let o = &self.operations;
        let colour = if self.fetch == Fetch::LazyColour { 0 } else { o.sh_colour };
        let own = [self.cull_operations_per_cycle, 0, self.colour_operations_per_cycle];
        let steps = [o.cull, o.project + o.obb_prepare, colour];
        let shared = steps.iter().zip(own).filter(|(_, own)| *own == 0).map(|(step, _)| step);
        let shared: u32 = shared.sum();
        let rate = |operations: u32, per_cycle: u32| {
            (f64::from(per_cycle) / f64::from(operations.max(1))).min(1.0)
        };
        [0, 1, 2].map(|step| match own[step] {
            0 => rate(shared, self.operations_per_cycle),
            own => rate(steps[step], own),
        })
    }

    /// Operations a cycle of all its engines.
    pub fn all_operations_per_cycle(&self) -> u64 {
        let own = [self.cull_operations_per_cycle, self.colour_operations_per_cycle];
        own.into_iter().map(u64::from).sum::<u64>() + u64::from(self.operations_per_cycle)
    }
}

/// A136.
fn bounds() -> Bytes {
    Bytes(16)
}

/// The `ccu.operations` table: arithmetic operations of each step, in the count of the source that
/// `ccu.operations-per-cycle` is in.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CcuOperations {
    /// The depth test of a record.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub cull: u32,
    /// Projection of a survivor: mean, covariance, bounding square.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub project: u32,
    /// Axes of the oriented box of a splat that is tested.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub obb_prepare: u32,
    /// A colour from spherical harmonics of degree 3; lower degrees take as much less as they have
    /// fewer operations.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub sh_colour: u32,
}

/// Parts and choices that it may be without.
pub(super) const OPTIONAL: &[Optional] = &[
    Optional {
        what: "clusters of Gaussians",
        switch: "ccu.clusters",
        keys: &["ccu.clusters", "ccu.cluster"],
        with: &["ccu.clusters=64"],
        is_there: |m| m.of_type::<CcuSpec>().clusters > 0,
    },
    Optional {
        what: "colours in its conversion units",
        switch: "ccu.fetch",
        keys: &["ccu.colour-operations-per-cycle"],
        with: &["ccu.fetch=visible-colour"],
        is_there: |m| m.of_type::<CcuSpec>().fetch != Fetch::LazyColour,
    },
];

/// What its choices exclude.
pub(super) const EXCLUDES: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Is("record.feature-source", &["ccu"]),
        off: "nobody",
        other: KeyValues::Is("ccu.fetch", &["lazy-colour"]),
        instead: "visible-colour",
        because: "features need colours before the lists are rendered",
    },
    Exclusion {
        choice: KeyValues::Not("ccu.clusters", &["0"]),
        off: "0",
        other: KeyValues::Is("stereo.impl", &["shared"]),
        instead: "separate",
        because: "the second eye goes through what the first one has converted, no scene",
    },
];

/// Bounds that are tested before records are read.
pub(super) fn check(machine: &Machine, found: &mut Found) {
    let m = machine.tiles();
    let (size, bytes) = (m.ccu.clusters, m.ccu.cluster);
    let block = STORAGE_BLOCK as u32;
    if !size.is_multiple_of(block) {
        let message = format!(
            "`ccu.clusters` = {size} must be a multiple of {block}, or 0 for none: who survives is \
             known of {block} Gaussians together"
        );
        found.add("ccu.clusters", message);
        found.ends_with("ccu.clusters", size.next_multiple_of(block));
    }
    if size > 0 && !(1..=RECORD_MAX.0).contains(&bytes.0) {
        let message = format!("`ccu.cluster` = {bytes} must be from 1 B to {RECORD_MAX}");
        found.add("ccu.cluster", message);
    }
}
