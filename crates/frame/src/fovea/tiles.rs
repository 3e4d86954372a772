//! The level of every tile, and how tiles blend into the next level.
//!
//! Source: `powergs.md` §6.1 and §6.4 in the corrected form of §10 (B10, B24): the level of a pixel
//! is measured from the middle of its tile and with its sign, and a tile blends as soon as a part
//! of it is beyond the middle between two levels. The published code measures from the corner that
//! is nearest to the gaze and takes an absolute value, so that its seams are not symmetric.

use super::EccentricityMap;
use crate::splat::TileGrid;
use crate::splat::levels::{LEVEL_MAX, LevelFilter};

/// The levels of one tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileLevel {
    /// Level in the middle, 0 to 3.9.
    pub level: f64,
    /// Change of the level per tile to the right and downwards: central differences, one-sided at
    /// the border, 0 without a neighbour.
    pub slope: [f64; 2],
    /// The level that all of the tile shows at least: the (first) one.
    pub first: u8,
    /// Whether a part of it shows the next one too.
    pub blends: bool,
}

impl TileLevel {
    fn new(level: f64, slope: [f64; 2]) -> TileLevel {
        let reach = 0.5 * (slope[0].abs() + slope[1].abs());
        let first = ((level - reach).max(0.0) as u8).min(LEVEL_MAX);
        let blends = first < LEVEL_MAX && level + reach > f64::from(first) + 0.5;
        TileLevel { level, slope, first, blends }
    }

    /// The share of the second level at a place, in tiles from the middle of the tile: 0 where only
    /// the first level is seen, 1 where only the second is.
    #[inline]
    pub fn share(&self, [dx, dy]: [f64; 2]) -> f64 {
        if !self.blends {
            return 0.0;
        }
        let level = self.level + self.slope[0] * dx + self.slope[1] * dy;
        let x = ((level - f64::from(self.first) - 0.5) / 0.5).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// The region that the tile belongs to: 0 for R1 to 3 for R4.
    pub fn region(&self) -> u8 {
        (self.level as u8).min(LEVEL_MAX)
    }
}

/// The levels of the tiles of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct TileLevels {
    /// The grid.
    pub grid: TileGrid,
    /// Tiles, row-major.
    pub tiles: Vec<TileLevel>,
}

impl TileLevels {
    /// The levels of the tiles of `grid`.
    pub fn new(map: &EccentricityMap, grid: TileGrid) -> TileLevels {
        let side = f64::from(grid.tile);
        let at =
            |x: u32, y: u32| map.level((f64::from(x) + 0.5) * side, (f64::from(y) + 0.5) * side);
        let (nx, ny) = (grid.nx, grid.ny);
        let levels: Vec<f64> = (0..ny).flat_map(|y| (0..nx).map(move |x| at(x, y))).collect();
        let slope = |i: u32, n: u32, at: &dyn Fn(u32) -> f64| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(n - 1));
            let steps = after - before;
            if steps == 0 { 0.0 } else { (at(after) - at(before)) / f64::from(steps) }
        };
        let tile = |x: u32, y: u32| {
            let level = |x: u32, y: u32| levels[grid.index(x, y)];
            let slopes = [slope(x, nx, &|x| level(x, y)), slope(y, ny, &|y| level(x, y))];
            TileLevel::new(level(x, y), slopes)
        };
        let tile = &tile;
        let tiles = (0..ny).flat_map(|y| (0..nx).map(move |x| tile(x, y))).collect();
        TileLevels { grid, tiles }
    }

    /// The filter that decides which splats take part in which tiles.
    pub fn filter(&self) -> LevelFilter {
        let first = self.tiles.iter().map(|t| t.first).collect();
        LevelFilter::new(self.grid, first, self.tiles.iter().map(|t| t.blends).collect())
    }

    /// The share of the second level at a pixel; pixel centres are at integer coordinates.
    pub fn share(&self, x: u32, y: u32) -> f64 {
        let side = f64::from(self.grid.tile);
        let (tx, ty) = (x / self.grid.tile, y / self.grid.tile);
        let offset = |p: u32, t: u32| f64::from(p) / side - f64::from(t) - 0.5;
        self.tiles[self.grid.index(tx, ty)].share([offset(x, tx), offset(y, ty)])
    }
}
