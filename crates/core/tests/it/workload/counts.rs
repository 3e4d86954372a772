//! Counters against the rasteriser's, totals, threads.

use powergs_core::workload::{Geometry, bin};
use powergs_frame::splat::Intersection;
use powergs_frame::trace::NEVER;
use powergs_raster::{Detail, Options, render};
use powergs_testkit::scenes::{front_camera, random_scene};

use super::support::{dense_scene, rendered};

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
    let (case, scene, camera, background) = powergs_testkit::scenes::forward_input();
    let options = Options { background, ..Options::reference(Detail::Dominance) };
    let rendered = render(&scene, &camera, &options);
    let frame = rendered.into_frame(&camera, options.background);
    let workload = bin(&frame, Geometry::REFERENCE);
    let lists = case["correct_obb"]["tile_lists"].as_array().unwrap();
    assert_eq!(lists.len(), workload.tiles.len());
    for (tile, expected) in workload.tiles.iter().zip(lists) {
        let range = tile.list_start as usize..(tile.list_start + tile.entries) as usize;
        let indices: Vec<u32> =
            workload.list[range].iter().map(|&r| frame.splats[r as usize].index).collect();
        assert_eq!(indices, powergs_testkit::scenes::ints(expected));
    }
}

#[test]
fn totals_close() {
    let (scene, camera) = dense_scene(22);
    let (_, frame) = rendered(&scene, &camera);
    for tile in [8, 16, 32, 64] {
        for test in [Intersection::Aabb, Intersection::Obb, Intersection::Ellipse] {
            let geometry = Geometry {
                tile,
                subtile: 8,
                sort_group: tile,
                chunk: 64,
                test,
                ..Geometry::REFERENCE
            };
            let w = bin(&frame, geometry);
            let pairs: u64 = w.tiles.iter().map(|t| u64::from(t.entries)).sum();
            assert_eq!(pairs, w.counters.tile_pairs);
            assert_eq!(pairs as usize, w.list.len());
            let loads: u64 = w.chunks.iter().map(|c| u64::from(c.entries)).sum();
            assert_eq!(loads, w.counters.tile_loads);
            let first: u64 = w.chunks.iter().map(|c| u64::from(c.first_loads)).sum();
            assert_eq!(first, w.counters.fetched_points);
            let live: u64 = w.chunks.iter().map(|c| u64::from(c.skipping.live_evaluations)).sum();
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
