//! The feature cache against one that searches.

use std::collections::BTreeSet;

use powergs_base::quantity::Bytes;
use powergs_core::workload::cache::{CacheShape, Victims, replay};
use powergs_core::workload::order::{TileOrder, tiles};
use powergs_core::workload::{FrameWorkload, Geometry, bin};

use super::support::dense_frame;

fn workload(seed: u64) -> FrameWorkload {
    bin(&dense_frame(seed), Geometry { chunk: 64, ..Geometry::REFERENCE })
}

/// Hits per chunk, loads, hits, first loads.
type Counts = (Vec<u32>, u64, u64, u64);

fn naive(w: &FrameWorkload, shape: CacheShape, order: &[u32]) -> Counts {
    let mut sets: Vec<Vec<u32>> = vec![Vec::new(); shape.sets as usize];
    let mut seen = BTreeSet::new();
    let (mut hits, mut loads, mut first) = (vec![0; w.chunks.len()], 0, 0);
    for &index in order {
        let tile = w.tiles[index as usize];
        for (i, &rank) in w.list_of(&tile)[..tile.loaded as usize].iter().enumerate() {
            let chunk = tile.chunk_start as usize + i / w.geometry.chunk as usize;
            let slot = w.slot[rank as usize];
            let set = &mut sets[(slot % shape.sets) as usize];
            loads += 1;
            first += u64::from(seen.insert(slot));
            if let Some(at) = set.iter().position(|&s| s == slot) {
                set.remove(at);
                hits[chunk] += 1;
            }
            set.insert(0, slot);
            set.truncate(shape.ways as usize);
        }
    }
    let sum = hits.iter().map(|&n| u64::from(n)).sum();
    (hits, loads, sum, first)
}

#[test]
fn hits_equal_a_naive_count() {
    let w = workload(31);
    for (sets, ways) in [(1, 1), (1, 100), (64, 4), (37, 3), (500, 1), (16, 0), (100_000, 2)] {
        let shape = CacheShape { sets, ways };
        for order in [TileOrder::Raster, TileOrder::Hilbert] {
            let order = tiles(w.tiles_x, w.tiles_y, order);
            let r = replay(&w, shape, Victims::Lru, &order);
            assert_eq!(
                (r.hits, r.loads, r.hit_loads, r.first_loads),
                naive(&w, shape, &order),
                "{shape:?}"
            );
        }
    }
}

#[test]
fn an_endless_cache_misses_first_loads_only() {
    let w = workload(32);
    let order = tiles(w.tiles_x, w.tiles_y, TileOrder::Raster);
    let r = replay(&w, CacheShape { sets: 1, ways: u32::MAX }, Victims::Lru, &order);
    assert_eq!(r.loads - r.hit_loads, r.first_loads);
    assert_eq!((r.loads, r.first_loads), (w.counters.tile_loads, w.counters.fetched_points));
    for (chunk, hits) in w.chunks.iter().zip(&r.hits) {
        assert_eq!(chunk.entries - hits, chunk.first_loads, "raster order: those of the binning");
    }
}

#[test]
fn the_least_recently_used_is_a_stack() {
    // Of a fully associative cache, a larger one holds everything that a smaller one does.
    let w = workload(33);
    let order = tiles(w.tiles_x, w.tiles_y, TileOrder::Morton);
    let mut before = 0;
    for ways in [0, 1, 10, 100, 1000, 10_000] {
        let hits = replay(&w, CacheShape { sets: 1, ways }, Victims::Lru, &order).hit_loads;
        assert!(hits >= before, "{ways} ways");
        before = hits;
    }
    assert!(before > 0);
}

#[test]
fn shapes_follow_from_bytes() {
    let shape = |capacity, pitch, ways| CacheShape::new(Bytes(capacity), Bytes(pitch), ways);
    assert_eq!(shape(32 << 10, 32, 4), CacheShape { sets: 256, ways: 4 });
    assert_eq!(shape(1000, 24, 4), CacheShape { sets: 10, ways: 4 });
    assert_eq!(shape(50, 24, 4), CacheShape { sets: 1, ways: 2 });
    assert_eq!(shape(0, 24, 4), CacheShape { sets: 1, ways: 0 });
}

/// The same by searching: of a full set the record leaves whose next tile is furthest.
fn naive_furthest(w: &FrameWorkload, shape: CacheShape, bits: u32, order: &[u32]) -> Counts {
    let lists: Vec<&[u32]> = order.iter().map(|&i| w.list_of(&w.tiles[i as usize])).collect();
    let far = |rank: u32, now: usize| {
        let next = (now + 1..lists.len()).find(|&tile| lists[tile].contains(&rank));
        next.filter(|&tile| ((tile - now) as u64) < (1 << bits) - 1).unwrap_or(usize::MAX)
    };
    // Record, next tile.
    let mut sets: Vec<Vec<(u32, usize)>> = vec![Vec::new(); shape.sets as usize];
    let mut seen = BTreeSet::new();
    let (mut hits, mut loads, mut first) = (vec![0; w.chunks.len()], 0, 0);
    for (now, &index) in order.iter().enumerate() {
        let tile = w.tiles[index as usize];
        for (i, &rank) in lists[now][..tile.loaded as usize].iter().enumerate() {
            let chunk = tile.chunk_start as usize + i / w.geometry.chunk as usize;
            let slot = w.slot[rank as usize];
            let set = &mut sets[(slot % shape.sets) as usize];
            loads += 1;
            first += u64::from(seen.insert(slot));
            let known = set.iter().position(|&(s, _)| s == slot);
            hits[chunk] += u32::from(known.is_some());
            known.map(|at| set.remove(at));
            set.push((slot, far(rank, now)));
            if set.len() > shape.ways as usize {
                for (_, next) in set.iter_mut() {
                    if *next < now {
                        *next = usize::MAX;
                    }
                }
                // Of those that are equally far an old one with the largest number leaves; the new
                // one only if it is the furthest or as far.
                let newest = set.len() - 1;
                let furthest = set.iter().map(|&(_, next)| next).max().expect("records");
                let leaves = (0..newest).filter(|&at| set[at].1 == furthest);
                let leaves = leaves.max_by_key(|&at| set[at].0);
                let leaves = leaves.filter(|_| set[newest].1 < furthest).unwrap_or(newest);
                set.remove(leaves);
            }
        }
    }
    let sum = hits.iter().map(|&n| u64::from(n)).sum();
    (hits, loads, sum, first)
}

#[test]
fn the_furthest_next_tile_leaves() {
    let w = workload(34);
    for (sets, ways) in [(1, 1), (64, 4), (37, 3), (500, 1), (16, 0)] {
        let shape = CacheShape { sets, ways };
        for (bits, order) in
            [(16, TileOrder::Raster), (2, TileOrder::Raster), (9, TileOrder::Hilbert)]
        {
            let order = tiles(w.tiles_x, w.tiles_y, order);
            let r = replay(&w, shape, Victims::Furthest { bits }, &order);
            let naive = naive_furthest(&w, shape, bits, &order);
            assert_eq!((r.hits, r.loads, r.hit_loads, r.first_loads), naive, "{shape:?}, {bits}");
        }
    }
}

#[test]
fn foresight_hits_more_than_age() {
    let w = workload(35);
    let order = tiles(w.tiles_x, w.tiles_y, TileOrder::Raster);
    for ways in [1, 4, 16] {
        let hits = |victims| replay(&w, CacheShape { sets: 16, ways }, victims, &order).hit_loads;
        let (age, far) = (hits(Victims::Lru), hits(Victims::Furthest { bits: 16 }));
        assert!(far > age, "{ways} ways: {far} against {age}");
    }
}
