//! A trace frame under one `Geometry`: tile lists, chunks, sub-tile work. No machine, no time.

pub mod bin;
pub mod binning;
pub mod blend;
pub mod cache;
mod chunk;
pub mod demand;
mod fovea;
mod group;
pub mod lanes;
pub mod order;
pub mod paper;
mod relist;
pub mod reuse;
mod storage;
mod tile;

use powergs_frame::fovea::ScreenGaze;
use powergs_frame::scene::{Camera, ShDegree};
use powergs_frame::splat::{Counters, FoveaCounters, Intersection, Splat};

pub use bin::{bin, bin_for};
pub(crate) use chunk::{ChunkScratch, TilePixels, push_chunks};
pub use relist::TileList;

/// The part of a machine that decides what work there is, not how fast it is done. Checked: tile
/// is a multiple of the sub-tile, both are powers of two, the chunk is at least 1.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    PartialOrd,
    Ord,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Geometry {
    /// Tile side, a power of two (8 to 64).
    #[schemars(range(min = 8, max = 64), extend("x-unit" = "pixels"))]
    pub tile: u32,
    /// Sub-tile side, a power of two (4 to `tile`).
    #[schemars(range(min = 4, max = 64), extend("x-unit" = "pixels"))]
    pub subtile: u32,
    /// Side of the square whose lists are sorted together: the tile, or a multiple of it.
    #[schemars(range(min = 8, max = 512), extend("x-unit" = "pixels"))]
    pub sort_group: u32,
    /// Splats sorted and loaded together.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "splats"))]
    pub chunk: u32,
    /// Splat-against-tile test.
    pub test: Intersection,
    /// Which Gaussians are projected.
    #[serde(default)]
    pub cull: Cull,
}

/// What is known of a Gaussian before it is projected: by its centre alone.
#[derive(
    Debug,
    Clone,
    Copy,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Deserialize,
    serde::Serialize,
    schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Cull {
    /// It is in front of the near plane.
    #[default]
    Depth,
    /// And inside of the picture with a margin of 0.15 of its width and height.
    Frustum,
}

impl Geometry {
    /// The reference tiling, in which traces are measured: 16x16 tiles, 8x8 sub-tiles, chunks of
    /// 256, oriented boxes.
    pub const REFERENCE: Geometry = Geometry {
        tile: 16,
        subtile: 8,
        sort_group: 16,
        chunk: 256,
        test: Intersection::Obb,
        cull: Cull::Depth,
    };

    /// Sub-tiles along one side of a tile.
    pub fn subtiles_per_side(&self) -> u32 {
        self.tile / self.subtile
    }

    /// Sub-tiles of a tile: bits of a bitmap.
    pub fn subtiles(&self) -> u32 {
        self.subtiles_per_side().pow(2)
    }

    /// Tiles along one side of a sort group: 1 without groups.
    pub fn tiles_per_group_side(&self) -> u32 {
        (self.sort_group / self.tile).max(1)
    }

    /// Bytes of a bitmap in [`FrameWorkload::bitmaps`].
    pub(crate) fn bitmap_bytes(&self) -> usize {
        self.subtiles().div_ceil(8) as usize
    }
}

/// What machines need of a frame besides its lists.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct FrameDetail {
    /// Splats and pixels one by one ([`FrameWorkload::pixels`]).
    pub pixels: bool,
    /// Nothing stops: every pixel of a tile goes through all of its list.
    pub whole: bool,
}

impl FrameDetail {
    /// All bits as a number, 0 for none.
    pub(crate) fn number(self) -> u32 {
        u32::from(self.pixels) | u32::from(self.whole) << 1
    }

    /// The inverse.
    pub(crate) fn of_number(number: u32) -> FrameDetail {
        FrameDetail { pixels: number & 1 != 0, whole: number & 2 != 0 }
    }
}

/// Splats and pixels of a frame one by one, for units that do not work on whole sub-tiles.
#[derive(Debug, Clone, PartialEq)]
pub struct Pixels {
    /// Every splat, by rank.
    pub splats: Vec<Splat>,
    /// List position from which on each pixel needs nothing, row-major.
    pub iterated: Vec<u32>,
}

/// One chunk of one tile's list, in depth order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChunkWork {
    /// Entries (at most `Geometry::chunk`).
    pub entries: u32,
    /// What hardware executes that skips sub-tiles whose bitmap bit is clear.
    pub skipping: PairWork,
    /// What hardware executes that ignores bitmaps.
    pub unskipped: PairWork,
    /// Position in the list of the sort group (`Geometry::sort_group`) after the last entry of this
    /// chunk; without groups, the same as in the list of the tile.
    pub group_end: u32,
    /// Entries of this chunk loaded here for the first time in the frame (tiles in raster order).
    pub first_loads: u32,
    /// Colours of further levels that those entries need; 0 in plain frames.
    pub level_loads: u32,
    /// Entries that the second level of the tile has too; 0 where nothing is blended between
    /// levels.
    pub seconds: u32,
}

/// The executed (entry, sub-tile) pairs of a chunk. The counts differ in the granularity at which
/// hardware stops: with the tile, the sub-tile, the 2x2 quad or the pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PairWork {
    /// Pairs up to the end of the tile, for hardware that stops only when the whole tile has.
    pub tile_pairs: u32,
    /// Pairs up to the end of each sub-tile.
    pub subtile_pairs: u32,
    /// (entry, pixel) evaluations in 2x2 quads of which some pixel had not stopped: 4 a quad (fewer
    /// at the edge of the image).
    pub quad_evaluations: u32,
    /// (entry, pixel) evaluations by pixels that had not stopped.
    pub live_evaluations: u32,
    /// Sum over the pairs of the largest number of live pixels in any 2x2 quad: the slots of units
    /// that rotate through the live pixels of a quad only.
    pub pixel_slots: u32,
    /// Pairs of entries of both levels up to the last pixel of a sub-tile that blends both: what a
    /// second accumulator does at the same time.
    pub both_pairs: u32,
}

/// One tile.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TileWork {
    /// First list entry in [`FrameWorkload::list`].
    pub list_start: u32,
    /// List length (`T_inter`).
    pub entries: u32,
    /// Entries fetched before the tile is done, in whole chunks (`T_load`).
    pub loaded: u32,
    /// First chunk in [`FrameWorkload::chunks`]; only fetched chunks are listed.
    pub chunk_start: u32,
    /// Fetched chunks.
    pub chunks: u32,
    /// Pixels of the tile that are inside the image.
    pub pixels: u32,
    /// Entries iterated by the pixels of this tile (`T_bf_term`).
    pub alpha_evaluations: u64,
    /// Entries blended by the pixels of this tile (`T_used`).
    pub blends: u64,
    /// Pixels that an entry of these stops: it is counted with them, and leaves nothing.
    pub stopped: u32,
    /// Of a foveated frame: entries blended for the second level (`T_used2`).
    pub blends_2: u64,
    /// Entries iterated while both levels of a pixel are open (`T_extra_alpha`).
    pub extra_alpha: u64,
    /// Pixels that are mixed from two levels: all of a tile that blends, else none.
    pub mixed: u32,
    /// Largest index in storage order ([`FrameWorkload::slot`]) of its list, plus one: after how
    /// many projected splats the list is complete.
    pub complete_after: u32,
}

/// The lists that are sorted together: one per sort group, row-major.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct GroupWork {
    /// Length of the common list.
    pub entries: u32,
    /// Entries that are sorted precisely: as far as the deepest tile needs, in whole chunks.
    pub sorted: u32,
}

/// Counters of a run of records in storage order, from the first record of the scene to
/// the end of a block.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StoragePrefix {
    /// Survivors of the near-plane cull.
    pub survivors: u32,
    /// Splats that need box tests.
    pub prepared: u32,
    /// Box tests; stays at the largest number from there on.
    pub tests: u32,
    /// Splats with at least one tile.
    pub splats: u32,
    /// (splat, tile) pairs.
    pub pairs: u32,
    /// Look-ups of tile levels; 0 in plain frames.
    pub lookups: u32,
}

/// Counters of a foveated frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FoveaWork {
    /// The gaze and the screen.
    pub gaze: ScreenGaze,
    /// The region of every tile, 0 for R1 to 3 for R4, row-major.
    pub regions: Vec<u8>,
    /// Tiles that blend two levels.
    pub blending_tiles: u64,
    /// Frame totals.
    pub counters: FoveaCounters,
}

/// Records of a block of [`FrameWorkload::storage`].
pub const STORAGE_BLOCK: u64 = 32;
/// Scenes of more records have no [`FrameWorkload::storage`]: it would take more room than the
/// trace (which may hold few of them).
pub const STORAGE_RECORDS_MAX: u64 = 1 << 27;

/// A binned frame: everything that a machine of this geometry needs.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameWorkload {
    /// The geometry it was binned with; a machine with another one cannot be run on it.
    pub geometry: Geometry,
    /// The camera that sees it; `None` where there is no frame.
    pub camera: Option<Camera>,
    /// Degree of the scene's spherical harmonics: 3 where the trace does not say.
    pub sh_degree: ShDegree,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Tiles per row.
    pub tiles_x: u32,
    /// Rows of tiles.
    pub tiles_y: u32,
    /// Frame totals under this geometry.
    pub counters: Counters,
    /// α evaluations that hardware with sub-tile skipping executes: every pixel of a live sub-tile.
    pub alpha_evaluations_executed: u64,
    /// Tiles, row-major.
    pub tiles: Vec<TileWork>,
    /// Fetched chunks of all tiles, tile by tile.
    pub chunks: Vec<ChunkWork>,
    /// Depth ranks of the list entries of all tiles, tile by tile, ascending within a tile.
    pub list: Vec<u32>,
    /// Sub-tile bitmap of each list entry, `ceil(subtiles / 8)` bytes each.
    pub bitmaps: Vec<u8>,
    /// Where the sub-tiles of each tile stop, tile by tile, row-major in a tile: the k-th number is
    /// the list position up to which any 2x2 quad has more than k live pixels; 0 outside of the
    /// image.
    pub stops: Vec<[u32; 4]>,
    /// Sort groups, row-major; empty when a group is a tile.
    pub groups: Vec<GroupWork>,
    /// Index in the scene of every splat, by rank: where its records lie in storage.
    pub index: Vec<u32>,
    /// Depth of every splat, by rank.
    pub depth: Vec<f32>,
    /// Position of every splat among those with at least one tile, in storage order, by rank: where
    /// its feature record lies. `u32::MAX` for splats without a tile.
    pub slot: Vec<u32>,
    /// Counters of the first `(i + 1) STORAGE_BLOCK` records of the scene, the last entry for all.
    /// Empty for scenes beyond [`STORAGE_RECORDS_MAX`].
    pub storage: Vec<StoragePrefix>,
    /// Results of foveated frames.
    pub fovea: Option<FoveaWork>,
    /// What it was binned for.
    pub detail: FrameDetail,
    /// With [`FrameDetail::pixels`].
    pub pixels: Option<Pixels>,
}

impl FrameWorkload {
    /// Sort groups per row: tiles per row without groups.
    pub fn groups_x(&self) -> u32 {
        self.tiles_x.div_ceil(self.geometry.tiles_per_group_side())
    }

    /// Rows of sort groups.
    pub fn groups_y(&self) -> u32 {
        self.tiles_y.div_ceil(self.geometry.tiles_per_group_side())
    }

    /// Depth ranks of the list of `tile`, ascending.
    pub fn list_of(&self, tile: &TileWork) -> &[u32] {
        &self.list[tile.list_start as usize..][..tile.entries as usize]
    }

    /// The fetched chunks of `tile`.
    pub fn chunks_of(&self, tile: &TileWork) -> &[ChunkWork] {
        &self.chunks[tile.chunk_start as usize..][..tile.chunks as usize]
    }

    /// Where the sub-tiles of the tile at this index stop, row-major.
    pub fn stops_of(&self, tile: usize) -> &[[u32; 4]] {
        let subtiles = self.geometry.subtiles() as usize;
        &self.stops[tile * subtiles..][..subtiles]
    }

    /// The sub-tiles of the tile at this index that have pixels inside the image.
    pub fn subtiles_inside(&self, tile: usize) -> impl Iterator<Item = usize> + use<> {
        let Geometry { tile: pixels, subtile, .. } = self.geometry;
        let (tile, side) = (tile as u32, self.geometry.subtiles_per_side());
        let (x, y) = (tile % self.tiles_x * pixels, tile / self.tiles_x * pixels);
        let left = [self.width.saturating_sub(x), self.height.saturating_sub(y)];
        let [columns, rows] = left.map(|pixels| pixels.div_ceil(subtile).min(side));
        (0..rows).flat_map(move |y| (0..columns).map(move |x| (y * side + x) as usize))
    }

    /// The pixels of the tile at this index inside the image, `(x0, y0, x1, y1)`, half open.
    pub fn pixels_of(&self, tile: usize) -> (u32, u32, u32, u32) {
        let (tile, side) = (tile as u32, self.geometry.tile);
        let (x, y) = (tile % self.tiles_x * side, tile / self.tiles_x * side);
        (x, y, (x + side).min(self.width), (y + side).min(self.height))
    }

    /// Bytes of the workload in host memory.
    pub(crate) fn bytes(&self) -> usize {
        fn of<T>(list: &[T]) -> usize {
            std::mem::size_of_val(list)
        }
        of(&self.tiles)
            + of(&self.chunks)
            + of(&self.list)
            + of(&self.bitmaps)
            + of(&self.stops)
            + of(&self.groups)
            + of(&self.index)
            + of(&self.depth)
            + of(&self.slot)
            + of(&self.storage)
            + self.fovea.as_ref().map_or(0, |fovea| of(&fovea.regions))
            + self.pixels.as_ref().map_or(0, |p| of(&p.splats) + of(&p.iterated))
    }

    /// A workload without tiles and splats.
    pub fn empty(geometry: Geometry) -> FrameWorkload {
        FrameWorkload {
            geometry,
            camera: None,
            sh_degree: ShDegree::MAX,
            width: 0,
            height: 0,
            tiles_x: 0,
            tiles_y: 0,
            counters: Counters::default(),
            alpha_evaluations_executed: 0,
            tiles: Vec::new(),
            chunks: Vec::new(),
            list: Vec::new(),
            bitmaps: Vec::new(),
            stops: Vec::new(),
            groups: Vec::new(),
            index: Vec::new(),
            depth: Vec::new(),
            slot: Vec::new(),
            storage: Vec::new(),
            fovea: None,
            detail: FrameDetail::default(),
            pixels: None,
        }
    }
}
