//! Parts that a tile-wise machine may not have, and choices that bring keys of their own.

use super::{
    BinningImpl, BinningSpec, CacheSpec, CcuSpec, CodebookSpec, Eviction, Fetch, FoveaSpec,
    GsuImpl, GsuSpec, VruSpec,
};
use crate::machine::Optional;

/// All of them.
pub(super) const OPTIONAL: [Optional; 10] = [
    Optional {
        what: "a feature cache",
        switch: "cache.capacity",
        keys: &["cache"],
        with: &["cache.capacity=32 KiB"],
        is_there: |m| m.of_type::<CacheSpec>().is_there(),
    },
    Optional {
        what: "eviction by reuse distance",
        switch: "cache.eviction",
        keys: &["cache.distance-bits"],
        with: &["cache.capacity=32 KiB", "cache.eviction=reuse-distance"],
        is_there: |m| m.of_type::<CacheSpec>().eviction == Eviction::ReuseDistance,
    },
    Optional {
        what: "a codebook",
        switch: "codebook.entries",
        keys: &["codebook"],
        with: &["codebook.entries=1024"],
        is_there: |m| m.of_type::<CodebookSpec>().entries > 0,
    },
    Optional {
        what: "accumulators for foveated frames",
        switch: "fovea.accumulators",
        keys: &["fovea"],
        with: &["fovea.accumulators=1"],
        is_there: |m| m.of_type::<FoveaSpec>().accumulators > 0,
    },
    Optional {
        what: "lists that it makes itself",
        switch: "binning.impl",
        keys: &["binning"],
        with: &["binning.impl=append", "gsu.impl=sort"],
        is_there: |m| m.of_type::<BinningSpec>().implementation != BinningImpl::Free,
    },
    Optional {
        what: "`binning.impl` = \"append\"",
        switch: "binning.impl",
        keys: &["binning.block"],
        with: &["binning.impl=append", "gsu.impl=sort"],
        is_there: |m| m.of_type::<BinningSpec>().implementation == BinningImpl::Append,
    },
    Optional {
        what: "`gsu.impl` = \"merge\"",
        switch: "gsu.impl",
        keys: &["gsu.fan-in"],
        with: &["gsu.impl=merge"],
        is_there: |m| m.of_type::<GsuSpec>().implementation == GsuImpl::Merge,
    },
    Optional {
        what: "`gsu.impl` = \"update\"",
        switch: "gsu.impl",
        keys: &["gsu.reuse-period"],
        with: &["gsu.impl=update", "binning.impl=free"],
        is_there: |m| m.of_type::<GsuSpec>().implementation == GsuImpl::Update,
    },
    Optional {
        what: "`vru.impl` = \"parallel\" and \"scan\"",
        switch: "vru.impl",
        keys: &["vru.subtile-queue"],
        with: &["vru.impl=scan", "vru.termination=subtile", "buffers.pixel-out.capacity=2 MiB"],
        is_there: |m| m.of_type::<VruSpec>().has_queues(),
    },
    Optional {
        what: "colour units in its cores",
        switch: "ccu.fetch",
        keys: &["vru.colour-operations-per-cycle", "vru.colour-latency"],
        with: &[
            "ccu.fetch=lazy-colour",
            "record.feature-source=nobody",
            "vru.colour-operations-per-cycle=133",
        ],
        is_there: |m| m.of_type::<CcuSpec>().fetch == Fetch::LazyColour,
    },
];
