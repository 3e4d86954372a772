//! The tiles that a splat touches: bounding rectangle, then a test row by row.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16};

use super::obb::{Obb, ObbBlock};
use super::project::{LANES, lanes_of};
use super::{Ellipse, Intersection, Splat};

/// The tiles of an image.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TileGrid {
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Tile side, pixels.
    pub tile: u32,
    /// Tiles per row.
    pub nx: u32,
    /// Rows of tiles.
    pub ny: u32,
}

impl TileGrid {
    /// The grid of `tile`-sided tiles that covers the image.
    pub fn new(width: u32, height: u32, tile: u32) -> TileGrid {
        TileGrid { width, height, tile, nx: width.div_ceil(tile), ny: height.div_ceil(tile) }
    }

    /// Number of tiles.
    pub fn len(&self) -> usize {
        self.nx as usize * self.ny as usize
    }

    /// Whether the image is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of a tile in row-major lists.
    #[inline]
    pub fn index(&self, tx: u32, ty: u32) -> usize {
        ty as usize * self.nx as usize + tx as usize
    }

    /// The pixels of tile (tx, ty) that are inside the image: `(x0, y0, x1, y1)`, half open.
    pub fn pixels(&self, tx: u32, ty: u32) -> (u32, u32, u32, u32) {
        let (x0, y0) = (tx * self.tile, ty * self.tile);
        (x0, y0, (x0 + self.tile).min(self.width), (y0 + self.tile).min(self.height))
    }
}

/// A rectangle of tiles, half open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileRect {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// End column.
    pub x1: u32,
    /// End row.
    pub y1: u32,
}

impl TileRect {
    /// Number of tiles.
    #[inline]
    pub fn area(&self) -> u64 {
        u64::from(self.x1 - self.x0) * u64::from(self.y1 - self.y0)
    }
}

impl Splat {
    /// The tiles under the bounding square of the 3-sigma radius (INRIA's rule, with its
    /// truncation towards zero).
    #[inline]
    pub fn tile_rect(&self, grid: &TileGrid) -> TileRect {
        let (r, t) = (self.radius(), grid.tile as f32);
        // Tiles are powers of two: multiplying by the reciprocal rounds like dividing.
        let k = 1.0 / t;
        let low = |m: f32, n: u32| (((m - r) * k) as i32).clamp(0, n as i32) as u32;
        let high = |m: f32, n: u32| (((m + r + (t - 1.0)) * k) as i32).clamp(0, n as i32) as u32;
        TileRect {
            x0: low(self.mean[0], grid.nx),
            y0: low(self.mean[1], grid.ny),
            x1: high(self.mean[0], grid.nx),
            y1: high(self.mean[1], grid.ny),
        }
    }
}

/// Tiles `x0..x1` of row `y`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileRow {
    /// The row.
    pub y: u32,
    /// First column.
    pub x0: u32,
    /// End column.
    pub x1: u32,
}

/// A splat being tested against the tiles of a grid.
#[derive(Debug, Clone, Copy)]
pub struct Cover {
    /// The candidates.
    pub rect: TileRect,
    grid: TileGrid,
    shape: CoverShape,
}

#[derive(Debug, Clone, Copy)]
enum CoverShape {
    Rect,
    Box(Obb),
    Ellipse(Option<Ellipse>),
}

impl Cover {
    /// Prepares `splat` for `test`. A splat with one candidate tile is accepted untested, as in the
    /// published model; one with a singular covariance touches nothing.
    #[inline]
    pub fn new(splat: &Splat, grid: TileGrid, test: Intersection) -> Cover {
        let conic = splat.conic();
        let mut rect = splat.tile_rect(&grid);
        if conic.is_none() {
            rect = TileRect { x0: 0, y0: 0, x1: 0, y1: 0 };
        }
        let shape = match (test, conic) {
            (Intersection::Aabb, _) | (_, None) => CoverShape::Rect,
            _ if rect.area() <= 1 => CoverShape::Rect,
            (Intersection::Obb, _) => CoverShape::Box(Obb::new(splat, grid.tile)),
            (Intersection::Ellipse, Some(conic)) => CoverShape::Ellipse(Ellipse::new(splat, conic)),
        };
        Cover { rect, grid, shape }
    }

    /// Tiles that are tested: all candidates of a splat that has several, unless the rectangle
    /// itself is the test.
    pub fn tests(&self) -> u64 {
        match self.shape {
            CoverShape::Rect => 0,
            CoverShape::Box(_) | CoverShape::Ellipse(_) => self.rect.area(),
        }
    }

    /// The accepted tiles, row by row, top to bottom; rows without a tile are left out.
    pub fn rows(&self) -> impl Iterator<Item = TileRow> + '_ {
        (self.rect.y0..self.rect.y1).filter_map(|y| self.row(y))
    }

    /// The accepted tiles of row `y`; `None` if there is none.
    pub fn row(&self, y: u32) -> Option<TileRow> {
        if !(self.rect.y0..self.rect.y1).contains(&y) {
            return None;
        }
        let (x0, x1) = self.interval(y, self.rect.x0, self.rect.x1);
        (x0 < x1).then_some(TileRow { y, x0, x1 })
    }

    /// [`Cover::row`] for a row of the rectangle.
    #[inline(always)]
    pub(super) fn row_by<S: Simd>(&self, simd: S, y: u32) -> Option<TileRow> {
        let TileRect { x0, x1, .. } = self.rect;
        let (x0, x1) = match &self.shape {
            CoverShape::Box(obb) => obb.meets_row(y)?.interval_by(simd, x0, x1),
            CoverShape::Rect | CoverShape::Ellipse(_) => self.interval(y, x0, x1),
        };
        (x0 < x1).then_some(TileRow { y, x0, x1 })
    }

    fn interval(&self, y: u32, x0: u32, x1: u32) -> (u32, u32) {
        match &self.shape {
            CoverShape::Rect => (x0, x1),
            CoverShape::Box(obb) => obb.meets_row(y).map_or((x0, x0), |row| row.interval(x0, x1)),
            CoverShape::Ellipse(ellipse) => {
                ellipse.and_then(|e| ellipse_tiles(&e, &self.grid, y)).map_or((x0, x0), |(a, b)| {
                    let first = a.clamp(i64::from(x0), i64::from(x1)) as u32;
                    (first, b.clamp(i64::from(first), i64::from(x1)) as u32)
                })
            }
        }
    }
}

/// Up to sixteen splats being tested by their boxes, with the bits of [`Cover::new`].
#[derive(Debug, Clone, Copy)]
pub(super) struct CoverBlock {
    /// First columns, first rows, end columns, end rows.
    rects: [[i32; LANES]; 4],
    boxes: ObbBlock,
    grid: TileGrid,
}

impl CoverBlock {
    /// Prepares `splats` for [`Intersection::Obb`].
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, splats: &[Splat], grid: TileGrid) -> CoverBlock {
        let mean = [
            lanes_of(simd, splats, |splat| splat.mean[0]),
            lanes_of(simd, splats, |splat| splat.mean[1]),
        ];
        let cov = [
            lanes_of(simd, splats, |splat| splat.cov[0]),
            lanes_of(simd, splats, |splat| splat.cov[1]),
            lanes_of(simd, splats, |splat| splat.cov[2]),
        ];
        let rects = tile_rects(simd, &mean, &cov, &grid);
        CoverBlock { rects, boxes: ObbBlock::new(simd, mean, cov, grid.tile), grid }
    }

    /// One of the splats.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Cover {
        let [x0, y0, x1, y1] = &self.rects;
        let of = |side: &[i32; LANES]| side[lane].cast_unsigned();
        let rect = TileRect { x0: of(x0), y0: of(y0), x1: of(x1), y1: of(y1) };
        let shape =
            if rect.area() <= 1 { CoverShape::Rect } else { CoverShape::Box(self.boxes.get(lane)) };
        Cover { rect, grid: self.grid, shape }
    }
}

/// The sides of [`Splat::tile_rect`] of sixteen splats; nothing where [`Splat::conic`] is nothing.
#[inline(always)]
fn tile_rects<S: Simd>(
    simd: S,
    mean: &[f32x16<S>; 2],
    cov: &[f32x16<S>; 3],
    grid: &TileGrid,
) -> [[i32; LANES]; 4] {
    /// The largest radius of [`Splat::radius`].
    const FURTHEST: f32 = i64::MAX as f32;
    let splat = |value: f32| f32x16::splat(simd, value);
    let [a, b, d] = *cov;
    let det = a * d - b * b;
    let is_finite = |value: f32x16<S>| value.abs().simd_lt(splat(f32::INFINITY));
    let is_regular =
        det.simd_ne(splat(0.0)) & is_finite(d / det) & is_finite(b / det) & is_finite(a / det);
    let mid = (a + d) * 0.5;
    let lambda = mid + (mid * mid - det).max_precise(splat(0.1)).sqrt();
    let reach = lambda.sqrt() * 3.0;
    let radius = reach.ceil().max_precise(splat(0.0)).min(splat(FURTHEST));
    let (tile, k) = (grid.tile as f32, 1.0 / grid.tile as f32);
    let side = |edge: f32x16<S>, n: u32| {
        let n = i32x16::splat(simd, n as i32);
        let zero = i32x16::splat(simd, 0);
        let tiles = (edge * k).to_int_precise::<i32x16<S>>().max(zero).min(n);
        is_regular.select(tiles, zero).into()
    };
    let [x, y] = *mean;
    [
        side(x - radius, grid.nx),
        side(y - radius, grid.ny),
        side(x + radius + (tile - 1.0), grid.nx),
        side(y + radius + (tile - 1.0), grid.ny),
    ]
}

/// The tiles of row `y` that hold a pixel which the ellipse may reach, unclipped, half open.
fn ellipse_tiles(ellipse: &Ellipse, grid: &TileGrid, y: u32) -> Option<(i64, i64)> {
    let tile = i64::from(grid.tile);
    let (first, end) = ellipse.columns(i64::from(y) * tile, i64::from(y + 1) * tile)?;
    Some((first.div_euclid(tile), (end - 1).div_euclid(tile) + 1))
}
