//! A made-up 1080p frame for benches: 8,160 tiles and 3.5 million pairs.

use powergs_sim::splat::Counters;
use powergs_sim::workload::{ChunkWork, FrameWorkload, Geometry, PairWork, TileWork};

/// Lists of 0 to about 2,000 entries in a fixed irregular order, mean 430.
pub fn frame(points: u64, geometry: Geometry) -> FrameWorkload {
    let mut w = FrameWorkload {
        geometry,
        width: 1920,
        height: 1088,
        tiles_x: 120,
        tiles_y: 68,
        counters: Counters { points, survivors: points * 9 / 10, ..Counters::default() },
        ..FrameWorkload::empty(geometry)
    };
    let mut state = 12345u32;
    for _ in 0..w.tiles_x * w.tiles_y {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let uniform = f64::from(state >> 8) / f64::from(1 << 24);
        let entries = (2000.0 * uniform.powf(3.65)) as u32;
        let loaded = (entries * 3 / 4).next_multiple_of(geometry.chunk).min(entries);
        let chunk_start = w.chunks.len() as u32;
        for first in (0..loaded).step_by(geometry.chunk as usize) {
            let entries = geometry.chunk.min(loaded - first);
            w.chunks.push(ChunkWork {
                entries,
                skipping: PairWork {
                    subtile_pairs: entries * 2,
                    live_evaluations: entries * 100,
                    ..PairWork::default()
                },
                unskipped: PairWork {
                    subtile_pairs: entries * geometry.subtiles(),
                    ..PairWork::default()
                },
                first_loads: entries / 4,
                ..ChunkWork::default()
            });
        }
        w.tiles.push(TileWork {
            list_start: w.counters.tile_pairs as u32,
            entries,
            loaded,
            chunk_start,
            chunks: w.chunks.len() as u32 - chunk_start,
            pixels: geometry.tile.pow(2),
            alpha_evaluations: u64::from(loaded) * 150,
            blends: u64::from(loaded) * 20,
            complete_after: 0,
            ..TileWork::default()
        });
        w.counters.tile_pairs += u64::from(entries);
    }
    w.counters.intersecting_points = points * 8 / 10;
    w.counters.obb_prepared = points / 2;
    w.counters.obb_tests = w.counters.tile_pairs;
    if points == 0 {
        w.counters = Counters::default();
    }
    w
}
