//! Closed-form counts of the published PowerGS model: bytes and floating-point operations of one
//! frame, from its counters and the list lengths of its tiles. There is no time in it.
//!
//! The executed formulas of the published code (`powergs`), with P points, S survivors, I points
//! with a tile, N pairs, T tiles tested for O points, per tile the list length Ti and the entries
//! loaded Tl, U points fetched, B entries iterated and K blended by all pixels:
//!
//! | stage | DRAM read | DRAM written | SRAM | FLOP |
//! |---|---|---|---|---|
//! | preprocessing | 6 P + 12 S | 4 N + 10 I | 0 | 47 P + 208 S + 38 O + 48 T |
//! | sorting | 4 Ti | 0 | 8 passes Ti + 1024 ceil(Tl / 256) | 0 |
//! | rendering | 19 Tl + 103 U | 3 pixels | 38 Tl | 133 U + 13 B + 11 K + 6 pixels |
//!
//! A foveated frame with L look-ups of tile levels, n tiles, V1 to V4 loaded splats that need one
//! to four levels, E entries while both levels are open and K2 entries blended for the second one
//! (§2.2) has instead
//!
//! | stage | DRAM read | DRAM write | SRAM | FLOP |
//! |---|---|---|---|---|
//! | preprocessing | 6 P + 13 S | 4 N + 10 I | 2 L + 2 n | 47 P + 208 S + 38 O + 48 T + 94 n |
//! | rendering | 19 Tl + V | 3 pixels | 54 Tl | W + 13 B + E + 11 (K + K2) + 31 pixels |
//!
//! where V = 103 V1 + 128 V2 + 147 V3 + 166 V4, W = 133 V1 + 139 V2 + 142 V3 + 145 V4 and O counts
//! splats with more than one box test. The published code takes V1 to V4 from the look-ups instead
//! of the loads (§10 B4); this does not.
//!
//! passes = ceil(log2(Ti / 256) / 3) for Ti ≥ 256, else 0. The published code does not split reads
//! from writes; the split is ours and changes no sum.

use super::FrameWorkload;
use powergs_frame::splat::{Counters, FoveaCounters};

/// Side of a tile, pixels: the formulas know no other.
pub(crate) const TILE: u32 = 16;

/// Counts of one stage. Real numbers, because padded tile values are means.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StageCounts {
    /// Bytes read from DRAM.
    pub dram_read: f64,
    /// Bytes written to DRAM.
    pub dram_write: f64,
    /// Bytes moved in or out of buffers.
    pub sram: f64,
    /// Floating-point operations.
    pub flops: f64,
}

/// List length and loaded entries of one tile (`T_inter`, `T_load`).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TileLoad {
    /// Entries of the list.
    pub entries: f64,
    /// Entries loaded.
    pub loaded: f64,
}

/// Which values a tile has at the right and lower edge of an image that is no multiple of 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Padding {
    /// Its own.
    TrueTiles,
    /// Those of the published code, which averages 16x16 blocks of the reflected image: edge tiles
    /// are mixed with their neighbours (`powergs` §2.3).
    Reference,
}

/// Counts of a frame that was binned with the reference geometry, in the order of `Phase::WORK`.
pub fn count_frame(workload: &FrameWorkload, padding: Padding) -> [StageCounts; 3] {
    let tiles: Vec<TileLoad> = workload
        .tiles
        .iter()
        .map(|t| TileLoad { entries: f64::from(t.entries), loaded: f64::from(t.loaded) })
        .collect();
    let (width, height) = (workload.width, workload.height);
    let tiles = match padding {
        Padding::TrueTiles => tiles,
        Padding::Reference => pad(&tiles, width, height),
    };
    let pixels = u64::from(width) * u64::from(height);
    match &workload.fovea {
        None => count(&workload.counters, &tiles, pixels),
        Some(fovea) => count_foveated(&workload.counters, &fovea.counters, &tiles, pixels),
    }
}

/// As [`count`], of a foveated frame.
pub fn count_foveated(
    counters: &Counters,
    fovea: &FoveaCounters,
    tiles: &[TileLoad],
    pixels: u64,
) -> [StageCounts; 3] {
    let plain = Counters { obb_prepared: fovea.prepared_published, ..*counters };
    let [mut preprocessing, sorting, mut rendering] = count(&plain, tiles, pixels);
    let loaded: f64 = tiles.iter().map(|t| t.loaded).sum();
    let n = tiles.len() as f64;
    preprocessing.dram_read += counters.survivors as f64;
    preprocessing.sram += 2.0 * fovea.lookups as f64 + 2.0 * n;
    preprocessing.flops += 94.0 * n;
    let weighted = |prices: [f64; 4]| -> f64 {
        prices.iter().zip(fovea.points_by_levels).map(|(price, n)| price * n as f64).sum()
    };
    let used = counters.fetched_points as f64;
    rendering.dram_read += weighted([103.0, 128.0, 147.0, 166.0]) - 103.0 * used;
    rendering.sram += 16.0 * loaded;
    rendering.flops += weighted([133.0, 139.0, 142.0, 145.0]) - 133.0 * used
        + fovea.extra_alpha as f64
        + 11.0 * fovea.blends_2 as f64
        + 25.0 * pixels as f64;
    [preprocessing, sorting, rendering]
}

/// Counts from counters, tile values and the number of pixels.
pub fn count(counters: &Counters, tiles: &[TileLoad], pixels: u64) -> [StageCounts; 3] {
    let [points, survivors, pairs, hits, used, tests, prepared, evaluated, blended, pixels] = [
        counters.points,
        counters.survivors,
        counters.tile_pairs,
        counters.intersecting_points,
        counters.fetched_points,
        counters.obb_tests,
        counters.obb_prepared,
        counters.alpha_evaluations,
        counters.blends,
        pixels,
    ]
    .map(|n| n as f64);
    let sum = |value: fn(&TileLoad) -> f64| tiles.iter().map(value).sum::<f64>();
    let loaded = sum(|t| t.loaded);
    [
        StageCounts {
            dram_read: 6.0 * points + 12.0 * survivors,
            dram_write: 4.0 * pairs + 10.0 * hits,
            sram: 0.0,
            flops: 47.0 * points + 208.0 * survivors + 38.0 * prepared + 48.0 * tests,
        },
        StageCounts {
            dram_read: sum(|t| 4.0 * t.entries),
            dram_write: 0.0,
            sram: sum(|t| 8.0 * passes(t.entries) * t.entries + 1024.0 * (t.loaded / 256.0).ceil()),
            flops: 0.0,
        },
        StageCounts {
            dram_read: 19.0 * loaded + 103.0 * used,
            dram_write: 3.0 * pixels,
            sram: 38.0 * loaded,
            flops: 133.0 * used + 13.0 * evaluated + 11.0 * blended + 6.0 * pixels,
        },
    ]
}

fn passes(entries: f64) -> f64 {
    if entries < 256.0 { 0.0 } else { ((entries / 256.0).log2() / 3.0).ceil() }
}

/// Tile values as the published code averages them. Because values are constant in a tile, a mean
/// over 16x16 pixels is a weighted sum over the few tiles that the reflected rows and columns
/// come from.
pub fn pad(tiles: &[TileLoad], width: u32, height: u32) -> Vec<TileLoad> {
    let (columns, rows) = (sources(width), sources(height));
    assert_eq!(tiles.len(), columns.len() * rows.len(), "one value per tile");
    let mut padded = Vec::with_capacity(tiles.len());
    for row in &rows {
        for column in &columns {
            let mut mean = TileLoad::default();
            for &(ty, n) in row {
                for &(tx, m) in column {
                    let tile = &tiles[ty * columns.len() + tx];
                    let weight = f64::from(n * m) / f64::from(TILE * TILE);
                    mean.entries += weight * tile.entries;
                    mean.loaded += weight * tile.loaded;
                }
            }
            padded.push(mean);
        }
    }
    padded
}

/// Per block of 16 along one axis: which tiles its samples come from, and how many of them.
fn sources(size: u32) -> Vec<Vec<(usize, u32)>> {
    let blocks = size.div_ceil(TILE);
    let block = |b: u32| {
        let mut counts: Vec<(usize, u32)> = Vec::new();
        for x in b * TILE..(b + 1) * TILE {
            let tile = (reflect(x, size) / TILE) as usize;
            match counts.iter_mut().find(|c| c.0 == tile) {
                Some(count) => count.1 += 1,
                None => counts.push((tile, 1)),
            }
        }
        counts
    };
    (0..blocks).map(block).collect()
}

/// Position of sample `x` in an axis of `size` samples that is reflected without its edge sample.
/// Where one reflection is not enough (sizes below 9, which the published code refuses) it goes on.
fn reflect(x: u32, size: u32) -> u32 {
    let period = (2 * (size - 1)).max(1);
    let x = x % period;
    if x < size { x } else { period - x }
}
