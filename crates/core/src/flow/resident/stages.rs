//! The stages of machines with resident pixels, and what a piece of work takes of each.

use super::work::RecordCounts;
use super::{
    ComposeSpec, Cut, FrontSpec, OrderSpec, RasterSpec, RegionSpec, Resident, StoreSpecs, TailSpec,
    TrainingSpec,
};
use crate::flow::steps::{self, TRAINING};
use crate::kernel::stream::{reads, writes};
use crate::machine::{Exclusion, KeyValues, Optional};
use crate::stage::{
    Bias, From, StageDecl, Stall, WaitDecl, also, buffer, buffer_id, double, omit, part, stage_id,
    work, work_id,
};
use powergs_energy::action::{ActionId, BufferId, Memory, Phase, StageId};

/// What excludes that regions are moved from the frame before.
const MOVED_REGIONS: &[Exclusion] = &[
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Is("front.overlap", &["frames"]),
        instead: "none",
        because: "which regions are rendered is known when all pixels have been moved",
    },
    Exclusion {
        choice: KeyValues::Not("pixels.impl", &["all"]),
        off: "all",
        other: KeyValues::Not("training.interval", &["0"]),
        instead: "0",
        because: "pixels without blends have no gradients",
    },
];

/// Conversion.
pub const FRONT_DECL: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<FrontSpec>().units),
    excludes: MOVED_REGIONS,
    also_works: &[
        also("cull").a_cycle(|m| converted(m.of_type())),
        also("project").a_cycle(|m| converted(m.of_type())),
        also("sh-colour").a_cycle(|m| converted(m.of_type())),
        also("row"),
        also("simt-operation").a_cycle(|m| match m.of_type::<TrainingSpec>().interval {
            0 => 0.0,
            _ => f64::from(m.of_type::<FrontSpec>().operations_per_cycle),
        }),
    ],
    buffers: &[
        buffer("front_in", "stores.records", |m| {
            m.of_type::<StoreSpecs>().records.shared(m.of_type::<FrontSpec>().units)
        }),
        buffer("front_out", "stores.results", |m| {
            m.of_type::<StoreSpecs>().results.shared(m.of_type::<FrontSpec>().units)
        }),
    ],
    streams: &[
        reads("records", "positions and shapes of a batch", &[], ["shades", "features"]),
        reads("shades", "colours of those with a region", &[], ["features", "records"]).scattered(),
        writes("results", "converted Gaussians and list entries", ["slices-out", "pixels"]),
        reads(
            "step-in",
            "Gaussians, their gradients and moments",
            &["gradients"],
            ["records", "shades"],
        ),
        writes("step-out", "the same, updated", ["results", "pixels"]),
    ],
    parts: &[part("operations", "Arithmetic of conversion; amount: operations a cycle.", |m| {
        f64::from(m.of_type::<FrontSpec>().operations_per_cycle)
    })],
    also_waits: &["records"],
    doubles: &[double(
        "front.units, their buffers",
        &["front.units", "stores.records.capacity", "stores.results.capacity"],
        &["A119"],
    )],
    omits: &[
        omit("Gaussians without a pixel that are converted late", Bias::Optimistic, "A119")
            .by("front.lazy = false", |m| !m.of_type::<FrontSpec>().lazy),
        omit("pointers of the lists of regions that grow", Bias::Optimistic, "A119"),
        omit("shapes of Gaussians before their regions are found", Bias::Optimistic, "A149").by(
            "front.lazy = true and region.cut = \"exact\"",
            |m| {
                let is_exact = m.of_type::<RegionSpec>().cut == Cut::Exact;
                m.of_type::<FrontSpec>().lazy && is_exact
            },
        ),
    ],
    behind: &["A119"],
    ..StageDecl::new(
        "front",
        "conversion units (front)",
        Phase::Preprocessing,
        "Converts Gaussians: reads their records, culls, projects to the screen, makes colours and \
         writes the lists of the regions. Keys: `front`.",
    )
};

/// Sorting.
pub const ORDER_DECL: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<OrderSpec>().units),
    works: &[work(
        "merged-key",
        0,
        "One key moved through the merger of an order unit in one pass.",
    )
    .comparing(|m| m.of_type::<OrderSpec>().ways.ilog2())
    .a_cycle(|m| f64::from(m.of_type::<OrderSpec>().keys_per_cycle))],
    buffers: &[buffer("order_keys", "stores.keys", |m| {
        m.of_type::<StoreSpecs>().keys.shared(m.of_type::<OrderSpec>().units)
    })],
    streams: &[
        reads("lists", "lists of regions", &["results"], ["entries", "records"]),
        writes("passes-out", "keys that do not fit, behind a pass", ["ordered", "results"]),
        reads("passes-in", "the same in front of the next", &["passes-out"], ["lists", "entries"]),
        writes("ordered", "sorted lists", ["passes-out", "results"]),
    ],
    parts: &[part("comparators", "Comparators: ways x keys a cycle.", |m| {
        f64::from(m.of_type::<OrderSpec>().ways)
            * f64::from(m.of_type::<OrderSpec>().keys_per_cycle)
    })],
    also_waits: &["list", "spill"],
    after: Some("front"),
    input: "lists of regions from the front",
    doubles: &[double(
        "order.units, their buffer",
        &["order.units", "stores.keys.capacity"],
        &["A120"],
    )],
    behind: &["A120"],
    ..StageDecl::new(
        "order",
        "order units",
        Phase::Sorting,
        "Sorts the list of each region by depth. Keys: `order`.",
    )
};

/// Rasterisation.
pub const RASTER_DECL: StageDecl = StageDecl {
    units: Some(|m| m.of_type::<RasterSpec>().engines),
    has_numbers: true,
    also_works: &[
        also("alpha").a_cycle(|m| f64::from(m.of_type::<RasterSpec>().lanes)),
        // A lane takes a pixel that has stopped in the slot in which it would evaluate another.
        also("stopped-pixel"),
        also("blend").a_cycle(|m| f64::from(m.of_type::<RasterSpec>().lanes)),
        also("pixel-finish"),
        also("row").a_cycle(|m| rows_a_cycle(m.resident())),
        also("gradient-pixel").a_cycle(|m| match m.of_type::<TrainingSpec>().interval {
            0 => 0.0,
            n => f64::from(m.of_type::<RasterSpec>().lanes) / f64::from(n),
        }),
    ],
    buffers: &[
        buffer("raster_in", "stores.gaussians", |m| {
            m.of_type::<StoreSpecs>().gaussians.shared(m.of_type::<RasterSpec>().engines)
        }),
        buffer("raster_pixels", "stores.pixels", |m| {
            m.of_type::<StoreSpecs>().pixels.shared(m.of_type::<RasterSpec>().engines)
        }),
    ],
    streams: &[
        reads("entries", "sorted entries of a chunk", &["ordered"], ["lists", "records"]),
        reads("features", "what a chunk names", &["results"], ["shades", "records"]).scattered(),
        writes("pixels", "finished pixels of a region", ["slices-out", "results"]),
        reads(
            "reverse-in",
            "pictures, lists and Gaussians in reverse",
            &["pixels"],
            ["entries", "lists"],
        ),
        writes("gradients", "gradients by pixels and by entries", ["pixels", "results"]),
    ],
    parts: &[
        part("lanes", "Lanes: a pixel each.", |m| f64::from(m.of_type::<RasterSpec>().lanes)),
        part("rows", "Rows whose ends are found in a cycle (`region.cut = \"exact\"`).", |m| {
            rows_a_cycle(m.resident())
        })
        .may_lack(),
    ],
    stats: &[&steps::LOSS, &steps::REVERSE, &steps::CHAIN, &steps::UPDATE],
    waits: &[
        WaitDecl {
            name: "tail",
            what: "its tail unit",
            short: "tail unit",
            because: "the tail unit had not finished the region before",
            symbol: 't',
            from: From::Stage("tail"),
        },
        WaitDecl {
            name: "conversion",
            what: "converted Gaussians",
            short: "conversion",
            because: "the front had not converted a chunk",
            symbol: 'v',
            from: From::Stage("front"),
        },
        WaitDecl {
            name: "others",
            what: "other depth slices of its region",
            short: "other slices",
            because: "other engines had not ended their slices of its region",
            symbol: 'y',
            from: From::Stage("raster"),
        },
        WaitDecl {
            name: "composition",
            what: "the composing unit",
            short: "composition",
            because: "its region was being put together",
            symbol: 'k',
            from: From::Stage("compose"),
        },
    ],
    also_waits: &["features"],
    after: Some("order"),
    input: "sorted lists from the order units",
    doubles: &[
        double(
            "raster.engines, their buffers",
            &["raster.engines", "stores.gaussians.capacity", "stores.pixels.capacity"],
            &["A121"],
        ),
        double("raster.lanes, banks", &["raster.lanes", "stores.pixels.banks"], &["A121"]),
    ],
    omits: &[omit("lanes of a step that meet in a bank", Bias::Optimistic, "A121")],
    behind: &["A121"],
    optional: &[
        Optional {
            what: "a search for the ends of rows",
            switch: "region.cut",
            keys: &["raster.row-cycles", "front.row"],
            with: &["region.cut=exact"],
            is_there: |m| m.of_type::<RegionSpec>().cut == Cut::Exact,
        },
        TRAINING,
    ],
    ..StageDecl::new(
        "raster",
        "raster engines",
        Phase::Rendering,
        "Takes each Gaussian of a region once through its pixels, which stay on chip. Keys: \
         `raster`, `region`.",
    )
};

/// The back of the lists.
pub const TAIL_DECL: StageDecl = StageDecl {
    units: Some(|m| match m.of_type::<TailSpec>().share > 0.0 {
        true => m.of_type::<RasterSpec>().engines,
        false => 0,
    }),
    has_numbers: true,
    also_works: &[
        also("alpha").a_cycle(|m| f64::from(m.of_type::<TailSpec>().lanes)),
        also("blend").a_cycle(|m| f64::from(m.of_type::<TailSpec>().lanes)),
    ],
    buffers: &[buffer("tail_in", "stores.tail", |m| match m.of_type::<TailSpec>().share > 0.0 {
        true => m.of_type::<StoreSpecs>().tail.shared(m.of_type::<RasterSpec>().engines),
        false => Memory::default(),
    })],
    parts: &[part("lanes", "Lanes: a pixel each.", |m| f64::from(m.of_type::<TailSpec>().lanes))],
    also_waits: &["features"],
    after: Some("raster"),
    input: "regions from the raster engines",
    doubles: &[double("tail.lanes", &["tail.lanes"], &["A122"])],
    omits: &[omit("the search for pixels that have not stopped", Bias::Optimistic, "A122")
        .by("tail.share > 0", |m| m.of_type::<TailSpec>().share > 0.0)],
    behind: &["A122"],
    optional: &[Optional {
        what: "tail units",
        switch: "tail.share",
        keys: &["tail", "stores.tail"],
        with: &[
            "tail.share=0.25",
            "region.slices=1",
            "stores.pixels.capacity=256 KiB",
            r#"stores.tail={ capacity = "32 KiB", word = "64 B", banks = 1, ports = "1rw" }"#,
        ],
        is_there: |m| m.of_type::<TailSpec>().share > 0.0,
    }],
    ..StageDecl::new(
        "tail",
        "tail units",
        Phase::Rendering,
        "Finishes regions pixel by pixel with the back of their lists, each pixel until it stops. \
         Keys: `tail`.",
    )
};

/// Depth slices.
pub const COMPOSE_DECL: StageDecl = StageDecl {
    units: Some(|m| match m.of_type::<ComposeSpec>().lanes > 0 {
        true => m.of_type::<RasterSpec>().engines,
        false => 0,
    }),
    has_numbers: true,
    works: &[work(
        "compose",
        7,
        "One pixel of a depth slice put in front of what lies behind: three colours and the \
         transmittance.",
    )
    .a_cycle(|m| f64::from(m.of_type::<ComposeSpec>().lanes))],
    streams: &[
        writes("slices-out", "pixels of a depth slice", ["pixels", "results"]),
        reads("slices-in", "the same", &["slices-out"], ["lists", "entries"]),
    ],
    parts: &[part("lanes", "Lanes: a pixel each.", |m| {
        f64::from(m.of_type::<ComposeSpec>().lanes)
    })],
    waits: &[WaitDecl {
        name: "slices",
        what: "pixels of other depth slices",
        short: "slices from DRAM",
        because: "pixels of other depth slices were in DRAM or on their way",
        symbol: 'z',
        from: From::Memory,
    }],
    after: Some("raster"),
    input: "slices from the raster engines",
    doubles: &[double("compose.lanes", &["compose.lanes"], &["A123"])],
    behind: &["A123"],
    optional: &[Optional {
        what: "composing units",
        switch: "compose.lanes",
        keys: &["compose"],
        with: &["compose.lanes=16", "region.slices=2"],
        is_there: |m| m.of_type::<ComposeSpec>().lanes > 0,
    }],
    ..StageDecl::new(
        "compose",
        "composing units",
        Phase::Rendering,
        "Puts the depth slices of a region together. Keys: `compose`, `region.slices`.",
    )
};

/// Rows whose ends an engine finds in a cycle; 0 where they are those of a square.
fn rows_a_cycle(m: &Resident) -> f64 {
    match m.region.cut {
        Cut::Box | Cut::Rows => 0.0,
        Cut::Exact => 1.0 / f64::from(m.raster.row_cycles),
    }
}

/// Gaussians that a unit converts in a cycle, where all have a region.
fn converted(spec: &FrontSpec) -> f64 {
    let all = spec.cull + spec.project + spec.shade;
    f64::from(spec.operations_per_cycle) / f64::from(all.max(1))
}

/// The stages in accounts.
pub const FRONT: StageId = stage_id("front");
/// As [`FRONT`].
pub const ORDER: StageId = stage_id("order");
/// As [`FRONT`].
pub const RASTER: StageId = stage_id("raster");
/// As [`FRONT`].
pub const TAIL: StageId = stage_id("tail");
/// As [`FRONT`].
pub const COMPOSE: StageId = stage_id("compose");

/// Records on their way to the front.
pub const RECORDS: BufferId = buffer_id("front_in");
/// Results on their way from it.
pub const RESULTS: BufferId = buffer_id("front_out");
/// Keys that are sorted.
pub const KEYS: BufferId = buffer_id("order_keys");
/// Chunks of the engines.
pub const GAUSSIANS: BufferId = buffer_id("raster_in");
/// Chunks of the tail units.
pub const TAIL_IN: BufferId = buffer_id("tail_in");
/// Pixels of regions.
pub const PIXELS: BufferId = buffer_id("raster_pixels");

/// One key in one pass.
pub const MERGED_KEY: ActionId = work_id("merged-key");
/// One pixel of a slice.
pub const COMPOSED: ActionId = work_id("compose");

/// Waits for records.
pub const WAITS_RECORDS: Stall = Stall::of("records");
/// Waits for a list.
pub const WAITS_LIST: Stall = Stall::of("list");
/// Waits for keys of a pass.
pub const WAITS_KEYS: Stall = Stall::of("spill");
/// Waits for a chunk.
pub const WAITS_FEATURES: Stall = Stall::of("features");
/// Waits for the tail unit.
pub const WAITS_TAIL: Stall = Stall::of("tail");
/// Waits for the front.
pub const WAITS_CONVERSION: Stall = Stall::of("conversion");
/// Waits for slices of other engines.
pub const WAITS_OTHERS: Stall = Stall::of("others");
/// Waits for the composing unit of another engine.
pub const WAITS_COMPOSITION: Stall = Stall::of("composition");
/// Waits for slices.
pub const WAITS_SLICES: Stall = Stall::of("slices");

impl FrontSpec {
    /// Cycles in which a unit takes a batch: its operations, or its list entries, whichever takes
    /// longer; at least one.
    pub fn cycles(&self, records: u64, counts: &RecordCounts) -> u64 {
        let operations = records * u64::from(self.cull) + self.operations(counts);
        let entries = counts.entries.div_ceil(u64::from(self.entries_per_cycle));
        operations.div_ceil(u64::from(self.operations_per_cycle)).max(entries).max(1)
    }

    /// Operations behind the cull.
    fn operations(&self, counts: &RecordCounts) -> u64 {
        counts.survivors * u64::from(self.project)
            + counts.splats * u64::from(self.shade)
            + counts.rows * u64::from(self.row)
    }

    /// Cycles in which all units together convert some Gaussians, each of which survives and has a
    /// region.
    pub fn converting(&self, gaussians: u64) -> u64 {
        let each = u64::from(self.cull) + u64::from(self.project) + u64::from(self.shade);
        let rate = u64::from(self.operations_per_cycle) * u64::from(self.units);
        (gaussians * each).div_ceil(rate).max(1)
    }
}

impl OrderSpec {
    /// Passes over a list: sorted parts of one key become one of all.
    pub fn passes(&self, keys: u64) -> u64 {
        let (mut parts, mut passes) = (keys, 0);
        while parts > 1 {
            (parts, passes) = (parts.div_ceil(u64::from(self.ways)), passes + 1);
        }
        passes
    }

    /// Cycles of a pass.
    pub fn cycles(&self, keys: u64) -> u64 {
        keys.div_ceil(u64::from(self.keys_per_cycle)) + u64::from(self.latency)
    }
}

impl Resident {
    /// Bytes of a chunk in the buffer of an engine.
    pub fn chunk_bytes(&self, entries: u64) -> u64 {
        entries * (self.gaussian.entry.0 + self.fetched())
    }

    /// Bytes that an entry brings on chip: a converted Gaussian, or its records where they are
    /// converted when they are needed.
    pub fn fetched(&self) -> u64 {
        let g = &self.gaussian;
        match self.front.lazy {
            true => g.position.0 + g.shape.0 + g.colour.0,
            false => g.feature.0,
        }
    }
}
