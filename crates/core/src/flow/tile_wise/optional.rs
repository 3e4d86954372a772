//! Parts that a tile-wise machine may not have, and choices that bring keys of their own.

use super::{
    BinningImpl, BinningSpec, CacheSpec, CcuSpec, CodebookSpec, Eviction, Fetch, FoveaSpec,
    GsuImpl, GsuSpec, PixelSource, PixelsSpec, StereoImpl, StereoSpec, Termination, TrainingSpec,
    VruImpl, VruSpec,
};
use crate::flow::steps::TRAINING;
use crate::machine::Optional;

/// All of them.
pub(super) const OPTIONAL: [Optional; 27] = [
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
        what: "`stereo.impl` = \"derived\"",
        switch: "stereo.impl",
        keys: &["stereo.lag", "stereo.buffer"],
        with: &["stereo.impl=derived", "fovea=none"],
        is_there: |m| m.of_type::<StereoSpec>().implementation == StereoImpl::Derived,
    },
    Optional {
        what: "pixels that are not rendered",
        switch: "pixels.impl",
        keys: &["pixels.per-cycle", "pixels.buffer"],
        with: &["pixels.impl=warped", "fovea=none"],
        is_there: |m| m.of_type::<PixelsSpec>().source.has_unit(),
    },
    Optional {
        what: "`pixels.impl` = \"warped\"",
        switch: "pixels.impl",
        keys: &["pixels.holes", "pixels.depth"],
        with: &["pixels.impl=warped", "pixels.holes=0.5", "fovea=none"],
        is_there: |m| m.of_type::<PixelsSpec>().source == PixelSource::Warped,
    },
    Optional {
        what: "frames that are rendered whole and others that are not",
        switch: "pixels.impl",
        keys: &["pixels.period"],
        with: &["pixels.impl=warped", "pixels.period=2", "fovea=none"],
        is_there: |m| {
            matches!(m.of_type::<PixelsSpec>().source, PixelSource::Warped | PixelSource::Sampled)
        },
    },
    Optional {
        what: "`pixels.impl` = \"cached\"",
        switch: "pixels.impl",
        keys: &["pixels.ids", "pixels.ways", "pixels.entry", "pixels.region"],
        with: &["pixels.impl=cached", "fovea=none"],
        is_there: |m| m.of_type::<PixelsSpec>().source == PixelSource::Cached,
    },
    Optional {
        what: "`pixels.impl` = \"sampled\"",
        switch: "pixels.impl",
        keys: &["pixels.stride", "pixels.pattern", "pixels.filter"],
        with: &["pixels.impl=sampled", "fovea=none", "geometry.test=aabb"],
        is_there: |m| m.of_type::<PixelsSpec>().source == PixelSource::Sampled,
    },
    Optional {
        what: "`vru.impl` = \"pixels\"",
        switch: "vru.impl",
        keys: &["vru.entries-per-cycle"],
        with: &["vru.impl=pixels", "vru.termination=pixel", "geometry.subtile=16", "fovea=none"],
        is_there: |m| m.of_type::<VruSpec>().implementation == VruImpl::Pixels,
    },
    TRAINING,
    Optional {
        what: "gradient units",
        switch: "training.interval",
        keys: &["gradients"],
        with: &["training.interval=2", "gradients.behind=true"],
        is_there: |m| m.of_type::<TrainingSpec>().interval > 0,
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
