//! The stages of a GPU: its multiprocessors run every kernel; a unit may blend beside them.

use super::{AttachedImpl, AttachedSpec, L2Spec, RopSpec, SmSpec, TrainSpec, WARP};
use crate::flow::over::pixels::{self, PixelSource, PixelsSpec};
use crate::flow::steps;
use crate::kernel::stream::{reads, writes};
use crate::machine::{Exclusion, KeyValues, Machine, Optional};
use crate::stage::{
    Bias, DoubleDecl, From, StageDecl, Stall, StatDecl, WaitDecl, buffer, buffer_id, counted,
    double, omit, part, share, stage_id, timed, work, work_id,
};
use powergs_base::quantity::Bytes;
use powergs_energy::action::{ActionId, BufferId, Memory, Phase, StageId};

/// What it declares.
pub const SM_DECL: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<SmSpec>().units),
    works: &[
        work("warp-instruction", WARP, "One instruction of a warp, whatever its threads do.")
            .a_cycle(|m| m.of_type::<SmSpec>().issue()),
        work("warp-exponential", 0, "The exponential of an alpha, a warp of them.")
            .a_cycle(|m| f64::from(m.of_type::<SmSpec>().special) / f64::from(WARP)),
    ],
    buffers: &[buffer("l2", "l2", |m| {
        let l2: &L2Spec = m.of_type();
        Memory {
            bank: l2.capacity,
            banks: u32::from(l2.capacity.0 > 0),
            word: l2.sector,
            two_ports: false,
        }
    })
    .full()],
    streams: &[
        reads("scene", "Gaussians, as stored", &[], ["splats", "keys-in"]).of(Phase::Preprocessing),
        writes("results", "converted Gaussians", ["pairs-out", "keys-out"])
            .of(Phase::Preprocessing),
        reads("counts", "numbers of pairs, and what keys are made of", &[], ["keys-in", "scene"])
            .of(Phase::Sorting),
        writes("pairs-out", "pairs in the order of storage", ["keys-out", "results"])
            .of(Phase::Sorting),
        reads("keys-in", "pairs in front of a pass", &["pairs-out"], ["counts", "scene"])
            .of(Phase::Sorting),
        writes("keys-out", "pairs behind a pass", ["pairs-out", "results"]).of(Phase::Sorting),
        reads("splats", "lists of tiles, and their Gaussians", &["results"], ["scene", "keys-in"])
            .scattered()
            .of(Phase::Rendering),
        writes("picture", "finished pixels", ["pairs-out", "results"]).of(Phase::Rendering),
        reads("blended-in", "pictures, and lists in reverse", &["picture"], ["splats", "scene"])
            .scattered()
            .of(Phase::Rendering),
        writes("gradients-out", "gradients by pixels and by Gaussians", ["picture", "results"])
            .of(Phase::Rendering),
        reads(
            "parameters-in",
            "Gaussians, their gradients and moments",
            &["gradients-out"],
            ["scene", "keys-in"],
        )
        .of(Phase::Preprocessing),
        writes("parameters-out", "the same, updated", ["results", "pairs-out"])
            .of(Phase::Preprocessing),
        reads("known-in", "pixels of the frame before", &[], ["splats", "scene"]).scattered(),
        writes("known-out", "the same at their places", ["picture", "results"]),
    ],
    parts: &[part("lanes", "Lanes of single precision.", |m| {
        f64::from(m.of_type::<SmSpec>().lanes)
    })],
    stats: &[
        &CONVERTING,
        &PAIRING,
        &SORTING,
        &BLENDING,
        &LAUNCHING,
        &LIVE_LANES,
        &L2_HIT_SHARE,
        &steps::LOSS,
        &steps::REVERSE,
        &steps::CHAIN,
        &steps::UPDATE,
        &REPROJECTING,
        &pixels::RENDERED,
        &pixels::WARPED,
        &pixels::FILLED,
    ],
    waits: &[
        WaitDecl {
            name: "pass",
            what: "pairs of a pass of the sort",
            short: "pairs from DRAM",
            because: "pairs of a pass of the sort were in DRAM or on their way",
            symbol: 'p',
            from: From::Memory,
        },
        WaitDecl {
            name: "launch",
            what: "the next kernel",
            short: "launch",
            because: "the next kernel had not been launched",
            symbol: 'g',
            from: From::Neighbour,
        },
    ],
    also_waits: &["records", "features"],
    doubles: &[
        double("sm.units", &["sm.units"], &["A137"]),
        double("sm.lanes, schedulers", &["sm.lanes", "sm.special", "sm.schedulers"], &["A137"]),
        double("l2.capacity", &["l2.capacity"], &["A139"]),
        DoubleDecl {
            is_there: |m| !m.dram.has_device() && m.dram.bandwidth.is_none(),
            ..double("bus.width", &["bus.width"], &["A4"])
        },
    ],
    omits: &[
        omit(
            "conflicts of banks of shared memory, misses of instruction caches",
            Bias::Optimistic,
            "",
        ),
        omit("kernels that overlap in their ends and beginnings", Bias::Pessimistic, "A138"),
        omit("clocks that fall under load", Bias::Optimistic, ""),
        omit("a depth for each pixel, which the blending kernel finds", Bias::Optimistic, "A151")
            .by("pixels.impl = \"warped\"", |m| m.gpu().pixels.source == PixelSource::Warped),
        omit(
            "densification: Gaussians that are cloned, split and removed",
            Bias::Optimistic,
            "A144",
        )
        .by("training.densify = 0", |m| {
            let train = m.of_type::<TrainSpec>();
            train.trains() && train.densify == 0
        }),
    ],
    behind: &["A137", "A138", "A139", "A144", "A151"],
    optional: &[TRAINING_KERNELS, WARPED_PIXELS, PERIODS, SAMPLES],
    check: Some(pixels::check),
    excludes: EXCLUDES,
    ..StageDecl::new(
        "sm",
        "streaming multiprocessors (SM)",
        Phase::Rendering,
        "Multiprocessors of a GPU: they run the kernels that convert, pair, sort and blend. Keys: \
         `sm`, `convert`, `pairs`, `radix`, `blend`, `pixels`, `reproject`, `training`.",
    )
};

/// Time of the conversion.
pub const CONVERTING: StatDecl =
    timed("kernels.convert_ms", "Time of the kernel that converts Gaussians.");
/// Time of the pairs.
pub const PAIRING: StatDecl =
    timed("kernels.pairs_ms", "Time of the kernels that count pairs and write them.");
/// Time of the sort.
pub const SORTING: StatDecl =
    timed("kernels.sort_ms", "Time of the kernels that sort pairs and find those of a tile.");
/// Time of the blending.
pub const BLENDING: StatDecl = timed("kernels.blend_ms", "Time of the kernel that blends tiles.");
/// Time of the pixels of the frame before.
pub const REPROJECTING: StatDecl = timed(
    "kernels.reproject_ms",
    "Time of the kernels that move the pixels of the frame before, where a machine does.",
);
/// Time without a kernel.
pub const LAUNCHING: StatDecl = timed("kernels.launch_ms", "Time between kernels.");
/// Lanes of warps that evaluate an entry.
pub const SLOTS: StatDecl = counted("kernels.slots", "");
/// Those of them whose pixel has not stopped.
pub const LIVE: StatDecl = counted("kernels.live", "");
const LIVE_LANES: StatDecl = share(
    "kernels.live_lanes_frac",
    &LIVE,
    &[&SLOTS],
    "Share of the lanes of evaluating warps whose pixel has not stopped, 0 to 1.",
);
/// Gaussians that blocks read and find in the L2 cache.
pub const L2_HITS: StatDecl = counted("kernels.l2_hits", "");
/// Those that they read from the memory.
pub const L2_MISSES: StatDecl = counted("kernels.l2_misses", "");
const L2_HIT_SHARE: StatDecl = share(
    "kernels.l2_hit_frac",
    &L2_HITS,
    &[&L2_HITS, &L2_MISSES],
    "Share of the Gaussians read by blocks that the L2 cache has, 0 to 1.",
);

/// A unit that blends beside it.
pub const ATTACHED_DECL: StageDecl = StageDecl {
    units: Some(|m| u32::from(m.of_type::<AttachedSpec>().is_there())),
    works: &[
        work("attached-alpha", 13, "One α of a pixel of an attached unit, live or not.")
            .a_cycle(lanes),
        work("attached-blend", 11, "One blend of an attached unit.").a_cycle(lanes),
        work("attached-row", 13, "The ends of an ellipse found in one row of pixels there.")
            .a_cycle(|m| match m.of_type::<AttachedSpec>().implementation {
                AttachedImpl::Rows => lanes(m),
                _ => 0.0,
            }),
    ],
    buffers: &[buffer("attached_cache", "attached.cache", |m| {
        let spec = m.of_type::<AttachedSpec>();
        match spec.is_there() && spec.cache.capacity.0 > 0 {
            true => spec.cache.shared(1),
            false => Memory { bank: Bytes(0), banks: 0, ..spec.cache.shared(1) },
        }
    })
    .full()],
    streams: &[
        reads("attached-in", "lists, and their Gaussians", &["results"], ["splats", "scene"])
            .scattered(),
        writes("attached-out", "its finished pixels", ["picture", "results"]),
    ],
    parts: &[part("lanes", "Pixels a cycle: `attached.lanes`.", |m| {
        f64::from(m.of_type::<AttachedSpec>().lanes)
    })],
    also_waits: &["features"],
    after: Some("sm"),
    input: "sorted lists from its GPU",
    doubles: &[double("attached.lanes", &["attached.lanes"], &["A147"])],
    omits: &[omit("what it takes to hand a frame to another chip", Bias::Optimistic, "A147")
        .by("attached.impl = \"rows\"", |m| m.of_type::<AttachedSpec>().is_there())],
    behind: &["A147"],
    optional: &[ATTACHED_UNIT],
    ..StageDecl::new(
        "attached",
        "attached unit",
        Phase::Rendering,
        "A unit beside a GPU that blends the lists which its kernels make. Keys: `attached`.",
    )
};

/// Raster operations that blend.
pub const ROP_DECL: StageDecl = StageDecl {
    units: Some(|m| u32::from(m.of_type::<RopSpec>().is_there())),
    works: &[
        work("quad-found", 32, "A quad of 2x2 pixels of which a box covers one, found.")
            .a_cycle(|m| rate(m, |spec| spec.found_per_cycle)),
        work("quad-blended", 36, "A quad of 2x2 pixels blended by raster operations.")
            .a_cycle(|m| rate(m, |spec| spec.quads_per_cycle)),
    ],
    buffers: &[buffer("rop_bins", "rops", |m| {
        let spec = m.of_type::<RopSpec>();
        let bytes = if spec.is_there() { spec.bytes() } else { 0 };
        Memory {
            bank: Bytes(bytes),
            banks: u32::from(bytes > 0),
            word: Bytes(16),
            two_ports: false,
        }
    })
    .full()
    .sized_by("bins")],
    parts: &[
        part("quads", "Quads that are blended in a cycle: `rops.quads-per-cycle`.", |m| {
            f64::from(m.of_type::<RopSpec>().quads_per_cycle)
        }),
        part("found", "Quads that are found in a cycle: `rops.found-per-cycle`.", |m| {
            f64::from(m.of_type::<RopSpec>().found_per_cycle)
        }),
    ],
    also_waits: &["features"],
    after: Some("sm"),
    input: "shaded fragments",
    doubles: &[
        double("rops.quads-per-cycle", &["rops.quads-per-cycle"], &["A148"]),
        double("rops.found-per-cycle", &["rops.found-per-cycle"], &["A148"]),
    ],
    omits: &[
        omit("quads that are on their way when their pixels stop", Bias::Optimistic, "A148")
            .by("rops.stop = true", |m| m.of_type::<RopSpec>().stop),
        omit("an alpha of 11 bits, which stops pixels earlier", Bias::Pessimistic, "A148")
            .by("rops.impl = \"boxes\"", |m| m.of_type::<RopSpec>().is_there()),
    ],
    behind: &["A148"],
    optional: &[ROP_UNIT],
    ..StageDecl::new(
        "rop",
        "raster operations (ROP)",
        Phase::Rendering,
        "The graphics pipeline of a GPU, which draws Gaussians as boxes: the rasteriser, bins of \
         quads, and raster operations. Keys: `rops`.",
    )
};

fn rate(m: &Machine, of: fn(&RopSpec) -> u32) -> f64 {
    let spec = m.of_type::<RopSpec>();
    if spec.is_there() { f64::from(of(spec)) } else { 0.0 }
}

/// Raster operations.
pub const ROP: StageId = stage_id("rop");
/// Quads, and Gaussians in front of them, that wait.
pub const ROP_BINS: BufferId = buffer_id("rop_bins");
/// A quad found.
pub const QUAD_FOUND: ActionId = work_id("quad-found");
/// A quad blended.
pub const QUAD_BLENDED: ActionId = work_id("quad-blended");

/// Pixels in a cycle of the GPU.
fn lanes(m: &Machine) -> f64 {
    let spec = m.of_type::<AttachedSpec>();
    match spec.is_there() {
        true => f64::from(spec.lanes) * spec.clock.0 / m.clock.0,
        false => 0.0,
    }
}

/// The unit.
pub const ATTACHED: StageId = stage_id("attached");
/// Its cache.
pub const ATTACHED_CACHE: BufferId = buffer_id("attached_cache");
/// An α.
pub const ATTACHED_ALPHA: ActionId = work_id("attached-alpha");
/// A blend.
pub const ATTACHED_BLEND: ActionId = work_id("attached-blend");
/// A row.
pub const ATTACHED_ROW: ActionId = work_id("attached-row");

/// The stage.
pub const SM: StageId = stage_id("sm");
/// An instruction of a warp.
pub const INSTRUCTION: ActionId = work_id("warp-instruction");
/// Exponentials of a warp.
pub const EXPONENTIAL: ActionId = work_id("warp-exponential");
/// The L2 cache.
pub const L2: BufferId = buffer_id("l2");
/// Waits for the next kernel.
pub const LAUNCH: Stall = Stall::of("launch");

const ATTACHED_UNIT: Optional = Optional {
    what: "an attached unit",
    switch: "attached.impl",
    keys: &["attached.lanes", "attached.clock", "attached.overlap", "attached.cache"],
    with: &[
        "energy=orin-nx-gbu",
        "attached.impl=rows",
        "attached.lanes=1",
        "attached.overlap=none",
    ],
    is_there: |m| m.of_type::<AttachedSpec>().is_there(),
};

const WARPED_PIXELS: Optional = Optional {
    what: "kernels that move pixels",
    switch: "pixels.impl",
    keys: &["pixels.holes", "pixels.depth", "reproject"],
    with: &["pixels.impl=warped", "pixels.holes=0.5"],
    is_there: |m| is(m, PixelSource::Warped),
};

const PERIODS: Optional = Optional {
    what: "kernels for frames of which not all is rendered",
    switch: "pixels.impl",
    keys: &["pixels.period"],
    with: &["pixels.impl=warped", "pixels.period=2"],
    is_there: |m| is(m, PixelSource::Warped) || is(m, PixelSource::Sampled),
};

const SAMPLES: Optional = Optional {
    what: "kernels for a sample of the pixels",
    switch: "pixels.impl",
    keys: &["pixels.stride", "pixels.pattern"],
    with: &["pixels.impl=sampled"],
    is_there: |m| is(m, PixelSource::Sampled),
};

fn is(m: &Machine, source: PixelSource) -> bool {
    m.of_type::<PixelsSpec>().source == source
}

const TRAINING_KERNELS: Optional = Optional {
    what: "kernels that train",
    switch: "training.sum",
    // The first as that of other dataflows: what both have is said of theirs.
    keys: &[
        "training.state",
        "training.update",
        "training.loss",
        "training.loss-bytes",
        "training.gradient",
        "training.record",
        "training.atomics",
        "training.zeroed",
        "training.chain",
        "training.widths",
        "training.step",
        "training.densify",
    ],
    with: &["training.sum=pixel", "training.atomics=0.05"],
    is_there: |m| m.of_type::<TrainSpec>().trains(),
};

const ROP_UNIT: Optional = Optional {
    what: "raster operations that blend",
    switch: "rops.impl",
    keys: &[
        "rops.quads-per-cycle",
        "rops.found-per-cycle",
        "rops.stop",
        "rops.merge",
        "rops.bins",
        "rops.bin-quads",
        "rops.groups",
        "rops.group-side",
        "rops.group-gaussians",
        "rops.corner",
        "rops.shade",
        "rops.pair",
    ],
    with: &[
        "energy=agx-orin-rops",
        "pairs.test=obb",
        "rops.impl=boxes",
        "rops.merge=true",
        "rops.groups=4",
        "rops.bins=4",
        "rops.shade=2000",
        "rops.pair=500",
    ],
    is_there: |m| m.of_type::<RopSpec>().is_there(),
};

/// What gradients of kernels exclude, or a unit that blends in place of one.
const EXCLUDES: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Not("rops.impl", &["none"]),
        off: "none",
        other: KeyValues::Not("training.sum", &["none"]),
        instead: "none",
        because: "gradients are found by kernels that have blended",
    },
    Exclusion {
        choice: KeyValues::Not("rops.impl", &["none"]),
        off: "none",
        other: KeyValues::Not("attached.impl", &["none"]),
        instead: "none",
        because: "one of them blends",
    },
    Exclusion {
        choice: KeyValues::Not("rops.impl", &["none"]),
        off: "none",
        other: KeyValues::Not("pairs.test", &["obb"]),
        instead: "obb",
        because: "oriented boxes are drawn",
    },
    Exclusion {
        choice: KeyValues::Not("attached.impl", &["none"]),
        off: "none",
        other: KeyValues::Not("training.sum", &["none"]),
        instead: "none",
        because: "gradients are found by kernels that have blended themselves",
    },
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Not("attached.impl", &["none"]),
        instead: "none",
        because: "a unit that blends writes whole pictures",
    },
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Not("rops.impl", &["none"]),
        instead: "none",
        because: "what is drawn is drawn into the whole picture",
    },
    Exclusion {
        choice: KeyValues::Is("pixels.impl", &["warped"]),
        off: "all",
        other: KeyValues::Not("training.sum", &["none"]),
        instead: "none",
        because: "pixels without blends have no gradients",
    },
];
