//! Orders: in which tiles are dealt, and in which a sorter leaves the entries of a list.

mod check;
mod inversions;
mod key;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use check::{PivotRule, SortCheck, Sorter, check, sorted_lists};
use inversions::count as inversions;
pub use key::DepthKey;

/// Order of tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TileOrder {
    /// Row by row.
    Raster,
    /// Z-order curve.
    Morton,
    /// Hilbert curve.
    Hilbert,
}

/// Every tile of a grid once, as row-major indices, in `order`. Curves are those of the smallest
/// square with a power of two tiles a side that holds the grid; its other tiles are left out, so
/// that steps of the Hilbert curve may be longer than one tile where the grid is no such square.
pub fn tiles(tiles_x: u32, tiles_y: u32, order: TileOrder) -> Vec<u32> {
    let mut indices: Vec<u32> = (0..tiles_x * tiles_y).collect();
    let bits = tiles_x.max(tiles_y).max(1).next_power_of_two().ilog2();
    match order {
        TileOrder::Raster => {}
        TileOrder::Morton => {
            indices.sort_by_cached_key(|&i| spread(i % tiles_x) | spread(i / tiles_x) << 1);
        }
        TileOrder::Hilbert => {
            indices.sort_by_cached_key(|&i| hilbert(bits, i % tiles_x, i / tiles_x));
        }
    }
    indices
}

/// The bits of `x`, a zero before each.
fn spread(x: u32) -> u64 {
    (0..u32::BITS).map(|bit| u64::from(x >> bit & 1) << (2 * bit)).sum()
}

/// How far along the Hilbert curve of a square of 2^bits tiles a side tile (x, y) is. It begins at
/// (0, 0). From the largest quadrant to the smallest: count the quadrants that come before, and
/// turn the own one so that its curve begins at its corner (0, 0) and ends at its upper right.
fn hilbert(bits: u32, mut x: u32, mut y: u32) -> u64 {
    let mut distance = 0;
    for bit in (0..bits).rev() {
        let (right, below) = (x >> bit & 1, y >> bit & 1);
        distance = distance << 2 | u64::from((3 * right) ^ below);
        let last = (1 << bit) - 1;
        (x, y) = (x & last, y & last);
        if below == 0 {
            if right == 1 {
                (x, y) = (last - x, last - y);
            }
            (x, y) = (y, x);
        }
    }
    distance
}
