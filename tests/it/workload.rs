//! Does binning count what the rasteriser does?

use powergs_sim::raster::{Detail, Options, Rendered, render};
use powergs_sim::scene::{Camera, Gaussians};
use powergs_sim::splat::{Cover, Intersection, TileGrid};
use powergs_sim::trace::{Frame, NEVER};
use powergs_sim::workload::{ChunkWork, FrameWorkload, Geometry, bin};

use crate::raster::support::{front_camera, random_scene};

fn rendered(scene: &Gaussians, camera: &Camera) -> (Rendered, Frame) {
    let rendered = render(scene, camera, &Options::reference(Detail::Counters));
    let frame = rendered.clone().into_frame(camera, [0.0; 3]);
    (rendered, frame)
}

fn dense_scene(seed: u64) -> (Gaussians, Camera) {
    // Opaque enough that pixels stop, dense enough that tiles have several chunks of 64.
    let mut scene = random_scene(seed, 6000, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 1.0);
    (scene, front_camera(150, 90))
}

#[test]
fn reference_geometry_equals_the_rasteriser() {
    let (scene, camera) = dense_scene(20);
    let (rendered, frame) = rendered(&scene, &camera);
    let workload = bin(&frame, Geometry::REFERENCE);
    assert_eq!(workload.counters, rendered.counters);
    assert!(rendered.pixels.stop_rank.iter().any(|&r| r != NEVER), "some pixels stop");
    for (tile, count) in workload.tiles.iter().zip(&rendered.tiles) {
        assert_eq!(
            (tile.entries, tile.loaded, tile.alpha_evaluations, tile.blends),
            (count.entries, count.loaded, count.alpha_evaluations, count.blends)
        );
    }
}

#[test]
fn lists_equal_the_frozen_reference() {
    let (case, scene, camera, options) = crate::raster::reference::forward_input();
    let rendered = render(&scene, &camera, &options);
    let frame = rendered.into_frame(&camera, options.background);
    let workload = bin(&frame, Geometry::REFERENCE);
    let lists = case["correct_obb"]["tile_lists"].as_array().unwrap();
    assert_eq!(lists.len(), workload.tiles.len());
    for (tile, expected) in workload.tiles.iter().zip(lists) {
        let range = tile.list_start as usize..(tile.list_start + tile.entries) as usize;
        let indices: Vec<u32> =
            workload.list[range].iter().map(|&r| frame.splats[r as usize].index).collect();
        assert_eq!(indices, crate::raster::reference::ints(expected));
    }
}

/// Counts one frame in the most direct way: per tile, per entry, per sub-tile, per pixel.
fn naive_chunks(frame: &Frame, geometry: Geometry, workload: &FrameWorkload) -> Vec<ChunkWork> {
    let camera = &frame.facts.camera;
    let grid = TileGrid::new(camera.width, camera.height, geometry.tile);
    let subgrid = TileGrid::new(camera.width, camera.height, geometry.subtile);
    let covers = |rank: u32, sx: u32, sy: u32| {
        let cover = Cover::new(&frame.splats[rank as usize], subgrid, geometry.test);
        cover.rows().any(|r| r.y == sy && (r.x0..r.x1).contains(&sx))
    };
    let mut seen = std::collections::HashSet::new();
    let mut chunks = Vec::new();
    for (index, tile) in workload.tiles.iter().enumerate() {
        let (tx, ty) = (index as u32 % grid.nx, index as u32 / grid.nx);
        let (x0, y0, x1, y1) = grid.pixels(tx, ty);
        let list = &workload.list[tile.list_start as usize..][..tile.entries as usize];
        let iterated = |x: u32, y: u32| {
            let stop = frame.pixels.stop_rank[(y * camera.width + x) as usize];
            list.iter().position(|&r| stop != NEVER && r > stop).unwrap_or(list.len()) as u32
        };
        for (c, entries) in list[..tile.loaded as usize].chunks(geometry.chunk as usize).enumerate()
        {
            let mut work = ChunkWork { entries: entries.len() as u32, ..ChunkWork::default() };
            for (i, &rank) in entries.iter().enumerate() {
                let at = c as u32 * geometry.chunk + i as u32;
                work.first_loads += u32::from(seen.insert(rank));
                for sy in (y0 / geometry.subtile)..y1.div_ceil(geometry.subtile) {
                    for sx in (x0 / geometry.subtile)..x1.div_ceil(geometry.subtile) {
                        let (px0, py0, px1, py1) = subgrid.pixels(sx, sy);
                        let live = (py0..py1)
                            .flat_map(|y| (px0..px1).map(move |x| (x, y)))
                            .filter(|&(x, y)| at < iterated(x, y))
                            .count() as u32;
                        work.subtile_pairs_unskipped += u32::from(live > 0);
                        if covers(rank, sx, sy) {
                            work.subtile_pairs += u32::from(live > 0);
                            work.live_evaluations += live;
                        }
                    }
                }
            }
            chunks.push(work);
        }
    }
    chunks
}

#[test]
fn chunks_equal_a_naive_count() {
    let mut scene = random_scene(21, 500, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    let (_, frame) = rendered(&scene, &front_camera(75, 50));
    for (tile, subtile, chunk, test) in [
        (16, 8, 32, Intersection::Obb),
        (32, 4, 50, Intersection::Obb),
        (8, 8, 7, Intersection::Aabb),
        (64, 16, 256, Intersection::Ellipse),
    ] {
        let geometry = Geometry { tile, subtile, sort_group: tile, chunk, test };
        let workload = bin(&frame, geometry);
        assert_eq!(workload.chunks, naive_chunks(&frame, geometry, &workload), "{geometry:?}");
    }
}

#[test]
fn totals_close() {
    let (scene, camera) = dense_scene(22);
    let (_, frame) = rendered(&scene, &camera);
    for tile in [8, 16, 32, 64] {
        for test in [Intersection::Aabb, Intersection::Obb, Intersection::Ellipse] {
            let geometry = Geometry { tile, subtile: 8, sort_group: tile, chunk: 64, test };
            let w = bin(&frame, geometry);
            let pairs: u64 = w.tiles.iter().map(|t| u64::from(t.entries)).sum();
            assert_eq!(pairs, w.counters.tile_pairs);
            assert_eq!(pairs as usize, w.list.len());
            let loads: u64 = w.chunks.iter().map(|c| u64::from(c.entries)).sum();
            assert_eq!(loads, w.counters.tile_loads);
            let first: u64 = w.chunks.iter().map(|c| u64::from(c.first_loads)).sum();
            assert_eq!(first, w.counters.fetched_points);
            let live: u64 = w.chunks.iter().map(|c| u64::from(c.live_evaluations)).sum();
            assert!(live <= w.alpha_evaluations_executed);
            assert!(w.counters.blends <= w.counters.alpha_evaluations);
            let pixels: u32 = w.tiles.iter().map(|t| t.pixels).sum();
            assert_eq!(pixels, camera.width * camera.height);
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let (scene, camera) = dense_scene(23);
    let (_, frame) = rendered(&scene, &camera);
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| bin(&frame, Geometry::REFERENCE))
    };
    assert_eq!(with(1), with(7));
}

#[test]
fn an_empty_frame_has_no_work() {
    let mut scene = random_scene(24, 10, 0);
    scene.means.iter_mut().for_each(|m| m[2] = -1.0);
    let (_, frame) = rendered(&scene, &front_camera(40, 24));
    let w = bin(&frame, Geometry::REFERENCE);
    assert_eq!((w.list.len(), w.chunks.len()), (0, 0));
    assert_eq!(w.tiles.len(), 6);
    assert_eq!(w.counters.alpha_evaluations, 0);
}
