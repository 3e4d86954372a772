//! The `[pixels]` table: where pixels come from, and what excludes what.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::COUNTER;
use crate::flow::Incompatible;
use crate::machine::check::{Found, RECORD_MAX, SIZE_MAX};
use crate::machine::{BufferSpec, Machine, Optional, Ports};
use powergs_base::quantity::Bytes;

/// The `[pixels]` table: which pixels of a frame are rendered, and where the others come from.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct PixelsSpec {
    /// Where pixels come from.
    #[serde(rename = "impl")]
    pub source: PixelSource,
    /// One frame in so many is rendered whole; with `sampled` 0 for none.
    #[schemars(range(min = 0, max = 1000), extend("x-unit" = "frames"))]
    pub period: u32,
    /// Largest share of a tile that may be missing where its pixels are moved: above it is rendered
    /// anew.
    #[schemars(range(min = 0, max = 1), extend("x-unit" = "fraction"))]
    pub holes: f64,
    /// Depth of a pixel that is kept beside its colour.
    pub depth: Bytes,
    /// Gaussians that a pixel blends before it is looked up.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "Gaussians"))]
    pub ids: u32,
    /// Ways of a set of the cache of colours.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "ways"))]
    pub ways: u32,
    /// An entry of it: tag and colour.
    pub entry: Bytes,
    /// Side of the square of pixels that has a cache of its own, which is fetched with it.
    #[schemars(range(min = 8, max = 4096), extend("x-unit" = "pixels"))]
    pub region: u32,
    /// One pixel in a square of this side is rendered.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "pixels"))]
    pub stride: u32,
    /// Which one.
    pub pattern: SamplePattern,
    /// Whether lists have only Gaussians that reach a pixel that is rendered: CCUs evaluate α at
    /// those in its bounding square, `ccu.intersection-units` a cycle.
    pub filter: bool,
    /// Pixels that the unit moves, or looks up, in a cycle.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "pixels"))]
    pub per_cycle: u32,
    /// On chip: counters of what is missing of tiles, or the cache of a region.
    pub buffer: BufferSpec,
}

impl PixelsSpec {
    /// Whether CCUs test pixels.
    pub fn filters(&self) -> bool {
        self.source == PixelSource::Sampled && self.filter
    }

    /// Which pixels are rendered of pictures of `pixel` bytes a pixel; `None` where all are.
    pub fn filter(&self, pixel: Bytes) -> Option<PixelFilter<'_>> {
        (self.source != PixelSource::All).then_some(PixelFilter { spec: self, pixel })
    }

    /// Whether a machine can show an image of this size.
    ///
    /// # Errors
    /// A sample that is larger than the image.
    pub fn fits(&self, machine: &str, [width, height]: [u32; 2]) -> Result<(), Incompatible> {
        let most = width.min(height);
        if self.source != PixelSource::Sampled || self.stride <= most {
            return Ok(());
        }
        let why = format!(
            "`pixels.stride` = {} is larger than the image of {width}x{height}: set it to {most} \
             at most",
            self.stride
        );
        Err(Incompatible::Other { machine: machine.to_owned(), why })
    }

    /// Whether the unit has a counter for each of `tiles` tiles or regions; a larger `key` makes
    /// fewer of them.
    ///
    /// # Errors
    /// More than it has.
    pub fn counts(&self, machine: &str, tiles: usize, key: &str) -> Result<(), Incompatible> {
        let counters = Bytes(tiles as u64 * COUNTER);
        if self.source != PixelSource::Warped || counters <= self.buffer.capacity {
            return Ok(());
        }
        let why = format!(
            "{tiles} parts of the image have counters of {counters} in all, and \
             `pixels.buffer.capacity` is {}: make it, or `{key}`, larger",
            self.buffer.capacity
        );
        Err(Incompatible::Other { machine: machine.to_owned(), why })
    }

    /// Bytes that are kept of a pixel beside its colour.
    pub fn kept(&self) -> Bytes {
        if self.source == PixelSource::Warped { self.depth } else { Bytes(0) }
    }
}

/// Which pixels of the pictures of a machine are rendered.
#[derive(Debug, Clone, Copy)]
pub struct PixelFilter<'a> {
    /// Where the others come from.
    pub spec: &'a PixelsSpec,
    /// A finished pixel in memory.
    pub pixel: Bytes,
}

impl PixelFilter<'_> {
    /// What decides which pixels are rendered: machines with the same numbers render the same.
    pub fn numbers(&self) -> Vec<u32> {
        let p = self.spec;
        let both = |n: u64| [n as u32, (n >> 32) as u32];
        let of = match p.source {
            PixelSource::All => Vec::new(),
            PixelSource::Warped => {
                let bytes = both(self.pixel.0 + p.depth.0);
                [&[p.period][..], &both(p.holes.to_bits()), &bytes].concat()
            }
            PixelSource::Cached => {
                let sizes = [both(p.entry.0), both(p.buffer.capacity.0)].concat();
                [&[p.ids, p.ways, p.region][..], &sizes].concat()
            }
            PixelSource::Sampled => {
                vec![p.period, p.stride, p.pattern as u32, u32::from(p.filter)]
            }
        };
        [vec![p.source as u32], of].concat()
    }
}

impl Default for PixelsSpec {
    /// All are rendered; what there is where the file says only another source.
    fn default() -> PixelsSpec {
        PixelsSpec {
            source: PixelSource::All,
            period: 5,
            holes: 1.0 / 6.0,
            depth: Bytes(4),
            ids: 5,
            ways: 4,
            entry: Bytes(13),
            region: 64,
            stride: 16,
            pattern: SamplePattern::Random,
            filter: false,
            per_cycle: 1,
            buffer: BufferSpec {
                capacity: Bytes(52 << 10),
                word: Bytes(16),
                banks: 4,
                ports: Ports::ReadOrWrite,
            },
        }
    }
}

/// Where pixels come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PixelSource {
    /// All are rendered.
    All,
    /// Those of the frame before are moved to where their depth says that they are now; tiles of
    /// which too much is missing are rendered.
    Warped,
    /// Pixels whose first Gaussians are known stop there.
    Cached,
    /// Some are rendered, as tracking and mapping need them.
    Sampled,
}

impl PixelSource {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            PixelSource::All => "all",
            PixelSource::Warped => "warped",
            PixelSource::Cached => "cached",
            PixelSource::Sampled => "sampled",
        }
    }

    /// Whether a unit knows pixels.
    pub const fn has_unit(self) -> bool {
        matches!(self, PixelSource::Warped | PixelSource::Cached)
    }

    /// Whether everything else waits for it.
    pub const fn is_first(self) -> bool {
        matches!(self, PixelSource::Warped)
    }
}

/// Which pixel of a square is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SamplePattern {
    /// The one in the middle.
    Grid,
    /// Another one in each square and frame.
    Random,
    /// As `random`, and every pixel that is more than half transparent.
    Unseen,
}

/// Parts and choices that it may be without.
pub(in crate::flow) const OPTIONAL: &[Optional] = &[
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
];

/// Takes sources of pixels, and keys of `pixels`, out of the schema of tables: those that machines
/// of a dataflow cannot have.
pub(in crate::flow) fn leave_out(schema: &mut Value, sources: &[PixelSource], keys: &[&str]) {
    let Some(table) = schema["properties"]["pixels"]["properties"].as_object_mut() else { return };
    let own = keys.iter().filter_map(|key| key.strip_prefix("pixels."));
    own.for_each(|key| drop(table.remove(key)));
    let is_out = |one: &Value| sources.iter().any(|source| one["const"] == source.name());
    if let Some(all) = table["impl"]["oneOf"].as_array_mut() {
        all.retain(|one| !is_out(one));
    }
}

/// Whether a number of frames shows what a machine does.
///
/// # Errors
/// Pixels that are moved from frame to frame, and one frame only.
pub(in crate::flow) fn goes_over(machine: &Machine, frames: usize) -> Result<(), String> {
    let Some(pixels) = machine.tables.get::<PixelsSpec>() else { return Ok(()) };
    if pixels.source != PixelSource::Warped || pixels.period <= 1 || frames > 1 {
        return Ok(());
    }
    Err(format!(
        "machine `{}` renders one frame in {} whole (`pixels.period`), and there is one frame \
         only: extract frames of a path (--path-frames 900 --frames 0..10), or set `pixels.impl` \
         = \"all\"",
        machine.name, pixels.period
    ))
}

/// Adds what of the keys of a machine does not fit together.
pub(in crate::flow) fn check(machine: &Machine, found: &mut Found) {
    let p: &PixelsSpec = machine.of_type();
    if p.source == PixelSource::All {
        return;
    }
    // The sizes of tiles do not depend on the image where pixels may be cached.
    let [tile, _] = machine.flow().tile(machine, [1, 1]);
    if p.source == PixelSource::Cached && !p.region.is_multiple_of(tile) {
        let message = format!(
            "`pixels.region` = {} is no multiple of the side of a tile, {tile}: a tile is in one \
             region",
            p.region
        );
        found.add("pixels.region", message);
        found.ends_with("pixels.region", p.region.next_multiple_of(tile));
    }
    if p.source == PixelSource::Warped && p.period == 0 {
        let message = "`pixels.period` = 0: the first frame is rendered whole; 1 renders all, 5 \
                       one in five";
        found.add("pixels.period", message.to_owned());
        found.ends_with("pixels.period", 5);
    }
    if !(0.0..=1.0).contains(&p.holes) {
        found.add("pixels.holes", format!("`pixels.holes` = {} must be from 0 to 1", p.holes));
    }
    for (key, bytes) in [("pixels.depth", p.depth), ("pixels.entry", p.entry)] {
        if !(1..=RECORD_MAX.0).contains(&bytes.0) {
            found.add(key, format!("`{key}` = {bytes} must be from 1 B to {RECORD_MAX}"));
        }
    }
    let b = &p.buffer;
    let least = match p.source {
        PixelSource::Cached => p.entry.0.saturating_mul(p.ways.into()),
        _ => 1,
    };
    if p.source.has_unit() && (b.capacity.0 < least || b.capacity > SIZE_MAX) {
        let message = format!(
            "`pixels.buffer.capacity` = {} must be from {}, a set of the cache, to {SIZE_MAX}",
            b.capacity,
            Bytes(least)
        );
        found.add("pixels.buffer.capacity", message);
    }
    if p.source.has_unit() && !(1..=b.capacity.0).contains(&b.word.0) {
        let message = format!(
            "`pixels.buffer.word` = {} must be from 1 B to the capacity, {}",
            b.word, b.capacity
        );
        found.add("pixels.buffer.word", message);
    }
}
