//! The tiles that a splat touches: bounding rectangle, then a test row by row.

use fearless_simd::Simd;

use super::obb::Obb;
use super::{Ellipse, Intersection, Splat};

/// The tiles of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
    shape: Shape,
}

#[derive(Debug, Clone, Copy)]
enum Shape {
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
            (Intersection::Aabb, _) | (_, None) => Shape::Rect,
            _ if rect.area() <= 1 => Shape::Rect,
            (Intersection::Obb, _) => Shape::Box(Obb::new(splat, grid.tile)),
            (Intersection::Ellipse, Some(conic)) => Shape::Ellipse(Ellipse::new(splat, conic)),
        };
        Cover { rect, grid, shape }
    }

    /// Tiles that are tested: all candidates of a splat that has several, unless the rectangle
    /// itself is the test.
    pub fn tests(&self) -> u64 {
        match self.shape {
            Shape::Rect => 0,
            Shape::Box(_) | Shape::Ellipse(_) => self.rect.area(),
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
            Shape::Box(obb) => obb.meets_row(y)?.interval_by(simd, x0, x1),
            Shape::Rect | Shape::Ellipse(_) => self.interval(y, x0, x1),
        };
        (x0 < x1).then_some(TileRow { y, x0, x1 })
    }

    fn interval(&self, y: u32, x0: u32, x1: u32) -> (u32, u32) {
        match &self.shape {
            Shape::Rect => (x0, x1),
            Shape::Box(obb) => obb.meets_row(y).map_or((x0, x0), |row| row.interval(x0, x1)),
            Shape::Ellipse(ellipse) => {
                ellipse.and_then(|e| ellipse_tiles(&e, &self.grid, y)).map_or((x0, x0), |(a, b)| {
                    let first = a.clamp(i64::from(x0), i64::from(x1)) as u32;
                    (first, b.clamp(i64::from(first), i64::from(x1)) as u32)
                })
            }
        }
    }
}

/// The tiles of row `y` that hold a pixel which the ellipse may reach, unclipped, half open.
fn ellipse_tiles(ellipse: &Ellipse, grid: &TileGrid, y: u32) -> Option<(i64, i64)> {
    let tile = i64::from(grid.tile);
    let (first, end) = ellipse.columns(i64::from(y) * tile, i64::from(y + 1) * tile)?;
    Some((first.div_euclid(tile), (end - 1).div_euclid(tile) + 1))
}
