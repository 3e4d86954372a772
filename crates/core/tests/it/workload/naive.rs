//! A direct count of a binned frame: per tile, per entry, per sub-tile, per pixel; per record.

use std::collections::{BTreeMap, BTreeSet};

use powergs_core::workload::{
    ChunkWork, Cull, FrameWorkload, Geometry, GroupWork, PairWork, STORAGE_BLOCK, StoragePrefix,
    bin,
};
use powergs_frame::splat::{Cover, TileGrid};
use powergs_frame::trace::{Frame, NEVER};

use super::support::{GEOMETRIES, dense_frame, small_frame};

/// Adds what an entry does in one sub-tile, given whether each of its pixels is live.
fn add(work: &mut PairWork, tile_live: bool, live: &BTreeMap<(u32, u32), bool>) {
    let mut quads: BTreeMap<(u32, u32), (u32, u32)> = BTreeMap::new();
    for (&(x, y), &live) in live {
        let quad = quads.entry((x / 2, y / 2)).or_default();
        quad.0 += 1;
        quad.1 += u32::from(live);
    }
    work.tile_pairs += u32::from(tile_live);
    work.subtile_pairs += u32::from(quads.values().any(|q| q.1 > 0));
    work.quad_evaluations += quads.values().filter(|q| q.1 > 0).map(|q| q.0).sum::<u32>();
    work.live_evaluations += quads.values().map(|q| q.1).sum::<u32>();
    work.pixel_slots += quads.values().map(|q| q.1).max().unwrap_or(0);
}

fn chunks(frame: &Frame, geometry: Geometry, workload: &FrameWorkload) -> Vec<ChunkWork> {
    let camera = &frame.facts.camera;
    let grid = TileGrid::new(camera.width, camera.height, geometry.tile);
    let subgrid = TileGrid::new(camera.width, camera.height, geometry.subtile);
    let covers = |rank: u32, sx: u32, sy: u32| {
        let cover = Cover::new(&frame.splats[rank as usize], subgrid, geometry.test);
        cover.rows().any(|r| r.y == sy && (r.x0..r.x1).contains(&sx))
    };
    let mut seen = BTreeSet::new();
    let mut chunks = Vec::new();
    for (index, tile) in workload.tiles.iter().enumerate() {
        let (x0, y0, x1, y1) = grid.pixels(index as u32 % grid.nx, index as u32 / grid.nx);
        let list = workload.list_of(tile);
        let stays = |x: u32, y: u32, at: usize| {
            let stop = frame.pixels.stop_rank[(y * camera.width + x) as usize];
            stop == NEVER || list[at] <= stop
        };
        let pixels = |(x0, y0, x1, y1): (u32, u32, u32, u32)| {
            (y0..y1).flat_map(move |y| (x0..x1).map(move |x| (x, y)))
        };
        for (c, entries) in list[..tile.loaded as usize].chunks(geometry.chunk as usize).enumerate()
        {
            let mut work = ChunkWork { entries: entries.len() as u32, ..ChunkWork::default() };
            for (i, &rank) in entries.iter().enumerate() {
                let at = c * geometry.chunk as usize + i;
                work.first_loads += u32::from(seen.insert(rank));
                work.group_end = at as u32 + 1;
                let tile_live = pixels((x0, y0, x1, y1)).any(|(x, y)| stays(x, y, at));
                for sy in (y0 / geometry.subtile)..y1.div_ceil(geometry.subtile) {
                    for sx in (x0 / geometry.subtile)..x1.div_ceil(geometry.subtile) {
                        let live = pixels(subgrid.pixels(sx, sy))
                            .map(|(x, y)| ((x, y), stays(x, y, at)))
                            .collect();
                        add(&mut work.unskipped, tile_live, &live);
                        if covers(rank, sx, sy) {
                            add(&mut work.skipping, tile_live, &live);
                        }
                    }
                }
            }
            chunks.push(work);
        }
    }
    chunks
}

/// The groups, and `group_end` of every chunk.
fn groups(workload: &FrameWorkload) -> (Vec<GroupWork>, Vec<u32>) {
    let g = workload.geometry;
    let group = |index: usize| {
        let side = (g.sort_group / g.tile) as usize;
        let nx = workload.tiles_x as usize;
        (index / nx / side, index % nx / side)
    };
    let mut unions: BTreeMap<(usize, usize), BTreeSet<u32>> = BTreeMap::new();
    for (index, tile) in workload.tiles.iter().enumerate() {
        unions.entry(group(index)).or_default().extend(workload.list_of(tile));
    }
    let mut needed: BTreeMap<(usize, usize), u32> = BTreeMap::new();
    let mut ends = Vec::new();
    for (index, tile) in workload.tiles.iter().enumerate() {
        let mut end = 0;
        for chunk in workload.chunks_of(tile) {
            end += chunk.entries as usize;
            let last = workload.list_of(tile)[end - 1];
            let position =
                unions[&group(index)].iter().position(|&r| r == last).unwrap() as u32 + 1;
            ends.push(position);
            let deepest = needed.entry(group(index)).or_default();
            *deepest = position.max(*deepest);
        }
    }
    let work = |(at, union): (&(usize, usize), &BTreeSet<u32>)| {
        let (entries, deepest) = (union.len() as u32, needed.get(at).copied().unwrap_or(0));
        GroupWork { entries, sorted: (deepest.div_ceil(g.chunk) * g.chunk).min(entries) }
    };
    (unions.iter().map(work).collect(), ends)
}

#[test]
fn chunks_and_groups_equal_a_naive_count() {
    let mut early = [0; 3];
    for (seed, geometry) in (21..).zip(GEOMETRIES) {
        let frame = small_frame(seed);
        let workload = bin(&frame, geometry);
        let mut expected = chunks(&frame, geometry, &workload);
        if geometry.sort_group == geometry.tile {
            assert!(workload.groups.is_empty());
        } else {
            let (groups, ends) = groups(&workload);
            assert_eq!(workload.groups, groups, "{geometry:?}");
            for (chunk, end) in expected.iter_mut().zip(ends) {
                chunk.group_end = end;
            }
        }
        assert_eq!(workload.chunks, expected, "{geometry:?}");
        for work in workload.chunks.iter().map(|c| &c.skipping) {
            early[0] += work.tile_pairs - work.subtile_pairs;
            early[1] += work.quad_evaluations - work.live_evaluations;
            early[2] += 4 * work.subtile_pairs - work.pixel_slots;
        }
    }
    assert!(early.iter().all(|&n| n > 0), "some parts stop before the whole: {early:?}");
}

#[test]
fn the_list_of_a_group_is_the_union_of_its_tiles() {
    let frame = dense_frame(29);
    for geometry in GEOMETRIES {
        let w = bin(&frame, geometry);
        let mut unions: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        let side = geometry.tiles_per_group_side();
        for (index, tile) in (0..).zip(&w.tiles) {
            let (x, y) = (index % w.tiles_x, index / w.tiles_x);
            let group = y / side * w.groups_x() + x / side;
            unions.entry(group).or_default().extend(w.list_of(tile));
        }
        assert_eq!(unions.len() as u32, w.groups_x() * w.groups_y());
        for (group, union) in unions {
            assert_eq!(w.group_list(group), Vec::from_iter(union), "{geometry:?} {group}");
        }
    }
}

/// Record by record.
fn storage(frame: &Frame, workload: &FrameWorkload, bits: &[u8]) -> Vec<StoragePrefix> {
    let camera = &frame.facts.camera;
    let grid = TileGrid::new(camera.width, camera.height, workload.geometry.tile);
    let mut sum = StoragePrefix::default();
    let mut out = Vec::new();
    for index in 0..frame.facts.points {
        sum.survivors += u32::from(bits[index as usize / 8] >> (index % 8) & 1);
        if let Some(splat) = frame.splats.iter().find(|s| u64::from(s.index) == index) {
            let cover = Cover::new(splat, grid, workload.geometry.test);
            let pairs: u32 = cover.rows().map(|r| r.x1 - r.x0).sum();
            sum.prepared += u32::from(cover.tests() > 0);
            sum.tests += cover.tests() as u32;
            sum.splats += u32::from(pairs > 0);
            sum.pairs += pairs;
        }
        if (index + 1) % STORAGE_BLOCK == 0 || index + 1 == frame.facts.points {
            out.push(sum);
        }
    }
    out
}

#[test]
fn storage_order_equals_a_naive_count() {
    for geometry in GEOMETRIES {
        let frame = small_frame(27);
        let w = bin(&frame, geometry);
        let bits = frame.survivor_bits.clone().unwrap();
        assert_eq!(w.storage, storage(&frame, &w, &bits), "{geometry:?}");
        let with_tile: BTreeSet<u32> = w.list.iter().copied().collect();
        let mut slots: Vec<(u32, u32)> = Vec::new();
        for (rank, splat) in (0..).zip(&frame.splats) {
            assert_eq!(
                (w.index[rank as usize], w.depth[rank as usize]),
                (splat.index, splat.depth)
            );
            match with_tile.contains(&rank) {
                true => slots.push((splat.index, w.slot[rank as usize])),
                false => assert_eq!(w.slot[rank as usize], u32::MAX),
            }
        }
        slots.sort_unstable();
        assert!(slots.iter().map(|s| s.1).eq(0..slots.len() as u32), "storage order, without gaps");
        for tile in &w.tiles {
            let slots = w.list_of(tile).iter().map(|&rank| w.slot[rank as usize]);
            assert_eq!(tile.complete_after, slots.max().map_or(0, |slot| slot + 1));
        }
    }
}

/// What is inside the frustum, or shown, is projected; of a trace that does not say it, what is
/// shown.
#[test]
fn the_frustum_is_what_is_inside_or_shown() {
    let mut frame = small_frame(31);
    let geometry = Geometry { cull: Cull::Frustum, ..Geometry::REFERENCE };
    let survivors = frame.survivor_bits.clone().unwrap();
    let bits: Vec<u8> = survivors.iter().map(|byte| byte & 0x35).collect();
    let shown = |bits: Option<&[u8]>| {
        let mut all = bits.map_or_else(|| vec![0; survivors.len()], <[u8]>::to_vec);
        frame.splats.iter().for_each(|s| all[s.index as usize / 8] |= 1 << (s.index % 8));
        all
    };
    let (with, without) = (shown(Some(&bits)), shown(None));
    assert!(with != bits && with != without && with != survivors, "each says something else");
    for (said, expected) in [(Some(bits), with), (None, without)] {
        frame.frustum_bits = said;
        let w = bin(&frame, geometry);
        assert_eq!(w.storage, storage(&frame, &w, &expected));
        let count: u64 = expected.iter().map(|byte| u64::from(byte.count_ones())).sum();
        assert_eq!(w.counters.survivors, count);
        let depth = bin(&frame, Geometry::REFERENCE);
        assert_eq!(depth.counters.survivors, frame.facts.survivors);
        assert_eq!((w.list, w.slot), (depth.list, depth.slot), "the picture is the same");
    }
}

#[test]
fn survivors_are_spread_where_the_trace_does_not_say_which() {
    let mut frame = small_frame(28);
    frame.survivor_bits = None;
    frame.facts.survivors = frame.facts.points.midpoint(frame.splats.len() as u64);
    let w = bin(&frame, Geometry::REFERENCE);
    let last = w.storage.last().unwrap();
    assert_eq!(u64::from(last.survivors), frame.facts.survivors);
    let mut before = StoragePrefix::default();
    for (i, own) in w.storage.iter().enumerate() {
        let shown = frame.splats.iter().filter(|s| s.index as usize / 32 == i).count() as u32;
        let survivors = own.survivors - before.survivors;
        // Half of the records that are not shown, give or take the one that is not yet due.
        let records = (frame.facts.points as u32 - 32 * i as u32).min(32);
        assert!(survivors >= shown && survivors <= shown + (records - shown).div_ceil(2) + 1);
        before = *own;
    }
}

#[test]
fn a_scene_that_claims_to_be_huge_takes_little_room() {
    let mut frame = small_frame(27);
    let small = bin(&frame, Geometry::REFERENCE);
    frame.survivor_bits = None;
    frame.facts.points = u64::from(u32::MAX);
    let huge = bin(&frame, Geometry::REFERENCE);
    assert!(huge.storage.is_empty());
    assert_eq!(huge.slot, small.slot);
}
