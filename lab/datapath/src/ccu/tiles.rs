//! Tiles of a splat: which it touches, and its record in each of them, in whole numbers.
//!
//! Places are in 1/256 pixel, coefficients in 2^-16. From tile to tile the places of the middle of
//! the tile along the box, and u and v of the record, change by 16 coefficients: sums that are
//! exact. A tile is met where its middle is within reach along both axes of the image and both
//! axes of the box; touching counts.

use super::programs::projected as at;
use super::unit::fixed;
use super::unit::{Projected, Rounding};
use crate::{NumberFormat, WideFormat};

/// Bits after the point of places and lengths.
pub const PLACE: u32 = 8;
/// Bits of places and lengths.
pub const PLACE_BITS: u32 = 24;
/// Bits after the point of coefficients.
pub const COEFFICIENT: u32 = 16;
/// Bits of coefficients.
pub const COEFFICIENT_BITS: u32 = 19;
/// Side of a tile, pixels.
const TILE: i64 = 16;

/// A splat and one tile that it touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// Column and row of the tile.
    pub tile: [u32; 2],
    /// Sub-tiles of 8 x 8 pixels that it touches: a bit each, row by row.
    pub subtiles: u32,
    /// u and v in the middle of the tile, as the record of the rendering core has them.
    pub local: [u16; 2],
}

/// A splat as the box tests have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Walk {
    /// First and end column, first and end row of the tiles under the square of the radius.
    pub rect: [[i64; 2]; 2],
    mean: [i64; 2],
    reach: [i64; 2],
    half: [i64; 2],
    axis: [i64; 2],
    root: [i64; 3],
}

impl Walk {
    /// The splat `projected`, in an image of so many columns and rows of tiles.
    pub fn new(format: WideFormat, projected: &Projected, tiles: [u32; 2]) -> Walk {
        let place =
            |i: usize, rounding| fixed(format, projected.numbers[i], PLACE, PLACE_BITS, rounding);
        let coefficient = |i: usize| {
            fixed(format, projected.numbers[i], COEFFICIENT, COEFFICIENT_BITS, Rounding::Nearest)
        };
        let floor = |i: usize| place(i, Rounding::Floor);
        let mean = [floor(at::MEAN), floor(at::MEAN + 1)];
        let whole = PLACE_BITS - PLACE;
        let radius = fixed(format, projected.numbers[at::RADIUS], 0, whole, Rounding::Ceiling);
        let radius = radius << PLACE;
        let rect = [0, 1].map(|i| {
            let end = i64::from(tiles[i]);
            let side = TILE << PLACE;
            let low = (mean[i] - radius).div_euclid(side);
            let high = (mean[i] + radius + side - (1 << PLACE)).div_euclid(side);
            [low.clamp(0, end), high.clamp(0, end)]
        });
        Walk {
            rect,
            mean,
            reach: [floor(at::REACH), floor(at::REACH + 1)],
            half: [floor(at::HALF), floor(at::HALF + 1)],
            axis: [coefficient(at::AXIS), coefficient(at::AXIS + 1)],
            root: [0, 1, 2].map(|i| coefficient(at::ROOT + i)),
        }
    }

    /// The mean in the image, in 1/256 pixel, and a, b, c in 2^-16: what u and v in the middle of
    /// any tile are made of.
    pub fn form(&self) -> ([i64; 2], [i64; 3]) {
        (self.mean, self.root)
    }

    /// Tiles under the square.
    pub fn candidates(&self) -> u64 {
        let [x, y] = self.rect.map(|[first, end]| (end - first).max(0) as u64);
        x * y
    }

    /// The tiles that the splat touches, row by row. A single candidate is taken as it is.
    pub fn pairs(&self, narrow: NumberFormat) -> Vec<Pair> {
        let alone = self.candidates() == 1;
        let [cos, sin] = self.axis;
        let [a, b, c] = self.root;
        let (x0, y0) = (self.rect[0][0], self.rect[1][0]);
        let middle = |tile: i64, i: usize| ((TILE * tile + TILE / 2) << PLACE) - self.mean[i];
        let first = [middle(x0, 0), middle(y0, 1)];
        let local = first.map(|place| place - (1 << (PLACE - 1)));
        let times = |place: i64, coefficient: i64| (place * coefficient) >> PLACE;
        let mut row = [
            times(first[0], cos) + times(first[1], sin),
            times(first[1], cos) - times(first[0], sin),
            times(local[0], a) + times(local[1], b),
            times(local[1], c),
        ];
        let mut pairs = Vec::new();
        for ty in self.rect[1][0]..self.rect[1][1] {
            let mut now = row;
            for tx in self.rect[0][0]..self.rect[0][1] {
                let place = [middle(tx, 0), middle(ty, 1)];
                if alone || self.meets(place, [now[0], now[1]], TILE / 2) {
                    pairs.push(Pair {
                        tile: [tx as u32, ty as u32],
                        subtiles: self.subtiles(place, [now[0], now[1]]),
                        local: [of_sum(narrow, now[2]), of_sum(narrow, now[3])],
                    });
                }
                now = [now[0] + TILE * cos, now[1] - TILE * sin, now[2] + TILE * a, now[3]];
            }
            row = [row[0] + TILE * sin, row[1] + TILE * cos, row[2] + TILE * b, row[3] + TILE * c];
        }
        pairs
    }

    /// Whether the box meets the square of half side `half` whose middle is at `place` from the
    /// mean, `along` the axes of the box.
    fn meets(&self, place: [i64; 2], along: [i64; 2], half: i64) -> bool {
        let corner = half * (self.axis[0].abs() + self.axis[1].abs());
        (0..2).all(|i| {
            let reach = (self.half[i] << (COEFFICIENT - PLACE)) + corner;
            place[i].abs() <= self.reach[i] + (half << PLACE) && along[i].abs() <= reach
        })
    }

    fn subtiles(&self, place: [i64; 2], along: [i64; 2]) -> u32 {
        let quarter = TILE / 4;
        let [cos, sin] = self.axis;
        let meets = |bit: u32| {
            let [x, y] = [bit & 1, bit >> 1].map(|far| if far == 1 { quarter } else { -quarter });
            let place = [place[0] + (x << PLACE), place[1] + (y << PLACE)];
            let along = [along[0] + x * cos + y * sin, along[1] + y * cos - x * sin];
            self.meets(place, along, quarter)
        };
        (0..4).map(|bit| u32::from(meets(bit)) << bit).sum()
    }
}

/// A sum of products in 2^-16, rounded and held within an eighth of the largest number.
fn of_sum(format: NumberFormat, sum: i64) -> u16 {
    let rounded = format.from_f64(sum as f64 / f64::from(1u32 << COEFFICIENT));
    let room = format.largest() - (3 << format.mantissa_bits());
    let magnitude = (rounded & !format.sign()).min(room);
    (rounded & format.sign()) | magnitude
}
