//! Which splats take part in which tiles of a foveated frame.
//!
//! A tile shows a level, and near the next one a blend of two; a splat has a highest level and is
//! in the tile's list if that is not below the tile's (first) level. The test comes before the
//! intersection test, also for splats with a single candidate tile (`powergs.md` §6.4).

use super::{TileGrid, cover::TileRect};

/// The highest level of a splat.
pub(crate) const LEVEL_MAX: u8 = 3;

/// Rectangles of at most so many tiles are tested tile by tile.
const MANY: u64 = 64;

/// The levels of the tiles of a grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LevelFilter {
    /// The grid.
    pub grid: TileGrid,
    /// The (first) level of every tile, 0 to 3, row-major.
    pub first: Vec<u8>,
    /// Whether the tile blends into the next level.
    pub blends: Vec<bool>,
    /// Per highest level below 3: tiles above and to the left that such a splat takes part in, in
    /// rows of one more than the grid has.
    sums: [Vec<u32>; LEVEL_MAX as usize],
}

impl LevelFilter {
    /// The filter of tiles with these levels.
    ///
    /// # Panics
    /// If there is not one level a tile, or one of level 3 blends.
    pub(crate) fn new(grid: TileGrid, first: Vec<u8>, blends: Vec<bool>) -> LevelFilter {
        assert!(first.len() == grid.len() && blends.len() == grid.len(), "one level a tile");
        let is_last = |(first, blends): (&u8, &bool)| *first >= LEVEL_MAX && *blends;
        assert!(!first.iter().zip(&blends).any(is_last), "nothing follows level 3");
        let sums = std::array::from_fn(|highest| sums(&grid, &first, highest as u8));
        LevelFilter { grid, first, blends, sums }
    }

    /// Whether a splat of this highest level takes part in a tile.
    #[inline]
    pub fn keeps(&self, tile: usize, highest: u8) -> bool {
        self.first[tile] <= highest
    }

    /// How many tiles of `rect` a splat of this highest level takes part in.
    #[inline]
    pub fn count(&self, rect: &TileRect, highest: u8) -> u64 {
        let Some(sums) = self.sums.get(usize::from(highest)) else { return rect.area() };
        let pitch = self.grid.nx as usize + 1;
        let at = |x: u32, y: u32| i64::from(sums[y as usize * pitch + x as usize]);
        let (x0, y0, x1, y1) = (rect.x0, rect.y0, rect.x1, rect.y1);
        (at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0)).max(0) as u64
    }

    /// A bound on the levels (first, last) whose colours a splat needs in the tiles of `rect`.
    /// `None` if it takes part in none of them.
    pub fn span(&self, rect: &TileRect, highest: u8) -> Option<(u8, u8)> {
        if self.count(rect, highest) == 0 {
            return None;
        }
        if rect.area() > MANY {
            return Some((0, highest));
        }
        let mut span = (u8::MAX, 0);
        for y in rect.y0..rect.y1 {
            for x in rect.x0..rect.x1 {
                let tile = self.grid.index(x, y);
                if self.keeps(tile, highest) {
                    let (first, last) = self.needed(tile, highest);
                    span = (span.0.min(first), span.1.max(last));
                }
            }
        }
        Some(span)
    }

    /// The levels, first and last, whose colours a splat needs in a tile that keeps it.
    #[inline]
    pub(crate) fn needed(&self, tile: usize, highest: u8) -> (u8, u8) {
        let first = self.first[tile];
        (first, first + u8::from(self.blends[tile] && highest > first))
    }
}

fn sums(grid: &TileGrid, first: &[u8], highest: u8) -> Vec<u32> {
    let (nx, ny) = (grid.nx as usize, grid.ny as usize);
    let mut sums = vec![0u32; (nx + 1) * (ny + 1)];
    for y in 0..ny {
        let mut row = 0;
        for x in 0..nx {
            row += u32::from(first[y * nx + x] <= highest);
            sums[(y + 1) * (nx + 1) + x + 1] = sums[y * (nx + 1) + x + 1] + row;
        }
    }
    sums
}
