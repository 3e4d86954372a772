//! Pixels that are not rendered, on a GPU (`pixels.impl`; A151): the kernels that move those of the
//! frame before.
//!
//! A thread for each pixel of the frame before moves it to its place in this one, where the nearest
//! of those that come together is kept by an atomic minimum of depth and number. A thread for each
//! pixel of this frame then takes what came to it, counts what is missing of its tile, and fills
//! that in from its neighbours where the tile is not rendered anew.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Gpu, WARP};
use crate::flow::over::pixels::{PixelSource, SomePixels};
use crate::workload::FrameWorkload;

/// The `[reproject]` table: kernels that move the pixels of the frame before (`pixels.impl` =
/// "warped").
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct ReprojectSpec {
    /// Instructions of a pixel of the frame before: its place in this one, and whether it is the
    /// nearest there.
    #[schemars(range(min = 1, max = 100000), extend("x-unit" = "instructions"))]
    pub place: u32,
    /// Instructions of a pixel of this frame: what came to it, what is missing of its tile, and
    /// where that comes from.
    #[schemars(range(min = 1, max = 100000), extend("x-unit" = "instructions"))]
    pub fill: u32,
}

impl Default for ReprojectSpec {
    /// A151.
    fn default() -> ReprojectSpec {
        ReprojectSpec { place: 60, fill: 40 }
    }
}

/// Bytes of the depth of a pixel and the number of the one that it is.
const NEAREST: u64 = 8;

/// What the kernels that move pixels do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MovedPixels {
    /// Warp instructions of each of both kernels.
    pub instructions: [u64; 2],
    /// Bytes that each reads and writes through the L2 cache.
    pub l2: [[u64; 2]; 2],
    /// Bytes that each reads from and writes to the memory.
    pub memory: [[u64; 2]; 2],
    /// Bytes of the frame before, and of what came to the places of this one.
    pub arrays: [u64; 2],
}

impl MovedPixels {
    /// What is moved for a frame; `None` where it is rendered whole.
    pub fn new(m: &Gpu, workload: &FrameWorkload, some: &SomePixels) -> Option<MovedPixels> {
        if m.pixels.source != PixelSource::Warped || some.made.is_none() {
            return None;
        }
        let pixels = u64::from(workload.width) * u64::from(workload.height);
        let warps = pixels.div_ceil(u64::from(WARP));
        let kept = m.pixel_bytes();
        let moved = some.summary.taken + some.summary.filled;
        let (before, nearest) = (pixels * kept, pixels * NEAREST);
        // Each pixel goes somewhere else: the cache reads and writes whole sectors for it.
        let scattered = pixels * m.l2.sector.0;
        let stays = before + nearest <= m.l2.capacity.0;
        let in_memory = |bytes: u64| if stays { 0 } else { bytes };
        Some(MovedPixels {
            instructions: [m.reproject.place, m.reproject.fill].map(|n| warps * u64::from(n)),
            l2: [[before + scattered, scattered], [nearest + moved * kept, moved * kept]],
            memory: [
                [before, in_memory(nearest)],
                [in_memory(nearest + moved * kept), moved * kept],
            ],
            arrays: [before, nearest],
        })
    }
}

impl Gpu {
    /// Bytes of a finished pixel in memory, with what is kept to move it.
    pub fn pixel_bytes(&self) -> u64 {
        self.blend.pixel.0 + self.pixels.kept().0
    }
}

/// Sources of pixels that need a unit beside the kernels.
pub(super) const OF_UNITS: [PixelSource; 1] = [PixelSource::Cached];

/// Keys of `pixels` that are of such a unit, or of a test of pixels before lists are made.
pub(super) const KEYS_OF_UNITS: [&str; 7] = [
    "pixels.per-cycle",
    "pixels.buffer",
    "pixels.ids",
    "pixels.ways",
    "pixels.entry",
    "pixels.region",
    "pixels.filter",
];
