//! What is measured once per geometry: binning, the order check, the feature cache, order reuse.
//!
//! `cargo bench --bench workload` prints medians on all threads for a 1080p frame with about a
//! million visible splats, and what the measures find there and on the trained scenes of
//! `../shared/data` (skipped where that is absent). `docs/model.md` quotes them.

mod scenes;

use std::path::Path;
use std::time::Instant;

use powergs_sim::quantity::Bytes;
use powergs_sim::raster::{Detail, Options, render};
use powergs_sim::scene::camera::edit;
use powergs_sim::scene::files::open_cameras;
use powergs_sim::scene::{Camera, Gaussians, OneFile, read};
use powergs_sim::splat::Intersection;
use powergs_sim::trace::Frame;
use powergs_sim::workload::cache::{CacheShape, Victims, replay};
use powergs_sim::workload::order::{DepthKey, PivotRule, Sorter, TileOrder, check, tiles};
use powergs_sim::workload::reuse::{SortedLists, update};
use powergs_sim::workload::{FrameWorkload, Geometry, bin};

use scenes::{Case, synthetic};

/// Gaussians of the synthetic scene; a bit more than a quarter of them are visible.
const POINTS: usize = 3_700_000;

/// Repetitions of one measurement; the median is reported.
const ROUNDS: usize = 5;

fn median_ms<T>(mut work: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let start = Instant::now();
        drop(work());
        start.elapsed().as_secs_f64() * 1e3
    };
    let mut times: Vec<f64> = (0..ROUNDS).map(time).collect();
    times.sort_by(f64::total_cmp);
    times[ROUNDS / 2]
}

fn frame(scene: &Gaussians, camera: &Camera) -> Frame {
    render(scene, camera, &Options::reference(Detail::Counters)).into_frame(camera, [0.0; 3])
}

fn trained(folder: &str, model: &str) -> Option<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(folder);
    let bytes = std::fs::read(folder.join(model)).ok()?;
    let scene = read(&OneFile(&bytes), "model.ply", None).ok()?.gaussians;
    let file = open_cameras(&folder.join("cameras.json"), None, None).ok()?;
    Some(Case { scene, camera: edit::resized(&file.cameras[3], 1920, 1080) })
}

/// `--test` is passed by `cargo test --benches`: nothing to time there.
fn main() {
    if std::env::args().any(|a| a == "--test") {
        return;
    }
    let mut cases = vec![("synthetic", synthetic("garden", POINTS, (1920, 1080)))];
    let room = trained("snowmiku-posed", "point_cloud.ply").map(|case| ("room", case));
    let object = trained("playcanvas-playbot", "playbot_lod1_sh2.ply").map(|case| ("object", case));
    cases.extend([room, object].into_iter().flatten());
    for (name, case) in cases {
        let frame = frame(&case.scene, &case.camera);
        let w = bin(&frame, Geometry::REFERENCE);
        println!("{name}: {} visible splats, {} pairs", frame.splats.len(), w.list.len());
        binning(&frame);
        sorting(&w);
        caching(&w);
        reusing(&w, &case);
        let neo = Geometry { tile: 64, sort_group: 64, ..Geometry::REFERENCE };
        reusing(&bin(&frame, neo), &case);
    }
}

fn binning(frame: &Frame) {
    let reference = Geometry::REFERENCE;
    for geometry in [
        reference,
        Geometry { subtile: 4, test: Intersection::Ellipse, ..reference },
        Geometry { sort_group: 64, ..reference },
        Geometry { tile: 64, sort_group: 64, ..reference },
    ] {
        let Geometry { tile, subtile, sort_group, test, .. } = geometry;
        let w = bin(frame, geometry);
        let sum = |of: fn(&powergs_sim::workload::PairWork) -> u32| -> [f64; 2] {
            let all = |c: &powergs_sim::workload::ChunkWork| [of(&c.skipping), of(&c.unskipped)];
            let add = |s: [f64; 2], n: [u32; 2]| [s[0] + f64::from(n[0]), s[1] + f64::from(n[1])];
            w.chunks.iter().map(all).fold([0.0; 2], add).map(|n| n / 1e6)
        };
        println!(
            "  bin {tile}/{subtile}/{sort_group} {test:?}: {:.0} ms; millions skipping and not: \
             tile {:.2?}, sub-tile {:.2?}, quad {:.1?}, pixel {:.1?}, slots {:.1?}",
            median_ms(|| bin(frame, geometry)),
            sum(|c| c.tile_pairs),
            sum(|c| c.subtile_pairs),
            sum(|c| c.quad_evaluations),
            sum(|c| c.live_evaluations),
            sum(|c| c.pixel_slots),
        );
    }
}

fn sorting(w: &FrameWorkload) {
    for key in [DepthKey::Fp16, DepthKey::Bf16, DepthKey::Fp32] {
        for rule in [PivotRule::Range, PivotRule::Quantile] {
            let sorter = Sorter { key, pivots: 7, rule };
            let c = check(w, sorter);
            println!(
                "  sort {key:?} {rule:?}: {:.0} ms; {} entries, {} neighbours, {} pairs ({} by \
                 pivots), {} equal, displacement {}, {} oversized, longest {}",
                median_ms(|| check(w, sorter)),
                c.entries,
                c.adjacent_pairs,
                c.inverted_pairs,
                c.inverted_pairs - c.inverted_by_precision,
                c.equal_key_pairs,
                c.displacement,
                c.oversized_entries,
                c.longest_part,
            );
        }
    }
}

fn caching(w: &FrameWorkload) {
    for (kib, ways) in [(8, 4), (32, 4), (128, 4), (128, 4096), (1 << 20, 4)] {
        let shape = CacheShape::new(Bytes(kib << 10), Bytes(32), ways);
        for order in [TileOrder::Raster, TileOrder::Morton, TileOrder::Hilbert] {
            let list = tiles(w.tiles_x, w.tiles_y, order);
            let r = replay(w, shape, Victims::Lru, &list);
            println!(
                "  cache {kib} KiB {ways} ways {order:?}: {:.0} ms; {} loads, hits {:.1} %, first \
                 {:.1} %",
                median_ms(|| replay(w, shape, Victims::Lru, &list)),
                r.loads,
                100.0 * r.hit_loads as f64 / r.loads as f64,
                100.0 * r.first_loads as f64 / r.loads as f64,
            );
        }
    }
}

/// A turn of 0.1, a third of a degree and one degree a frame, four frames: 9, 30 and 90 degrees a
/// second at 90 frames a second.
fn reusing(first: &FrameWorkload, case: &Case) {
    let tile = first.geometry.tile;
    for degrees in [0.1f64, 0.333, 1.0] {
        let mut order = SortedLists::exact(first);
        for i in 1..=4 {
            let mut camera = case.camera.clone();
            let turn = glam::DMat3::from_rotation_y((degrees * f64::from(i)).to_radians());
            camera.world_to_camera = turn * camera.world_to_camera;
            let w = bin(&frame(&case.scene, &camera), first.geometry);
            let (reuse, next) = update(&order, &w);
            let s = reuse.summary;
            println!(
                "  reuse {tile} {degrees} degrees, frame {i}: {:.0} ms; kept {} new {} gone {}, \
                 {:.1} % of lists keep, shift p99 {}, {} neighbours out of order",
                median_ms(|| update(&order, &w)),
                s.kept,
                s.new,
                s.gone,
                100.0 * s.keeping as f64 / s.old_lists.max(1) as f64,
                s.rank_shift_p99,
                s.out_of_order,
            );
            order = next;
        }
    }
}
