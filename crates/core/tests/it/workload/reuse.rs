//! Order reuse against a direct count, over a sequence of frames.

use powergs_core::workload::reuse::{KEEP, SortedLists, update};
use powergs_core::workload::{FrameWorkload, bin};
use powergs_frame::trace::Frame;
use powergs_raster::{Detail, Options, render};
use powergs_scene::Camera;

use super::support::{GEOMETRIES, dense_scene};

/// Frames of a camera that moves sideways and turns.
fn frames(n: usize, step: f64) -> Vec<Frame> {
    let (scene, camera) = dense_scene(51);
    let frame = |i: usize| {
        let at = step * i as f64;
        let mut camera = camera.clone();
        camera.centre.x += at;
        camera.world_to_camera *= glam::DMat3::from_rotation_y(0.3 * at);
        render(&scene, &camera, &Options::reference(Detail::Counters)).into_frame(&camera, [0.0; 3])
    };
    (0..n).map(frame).collect()
}

/// Scene indices of the lists of `w`, exactly ordered.
fn lists(w: &FrameWorkload) -> Vec<Vec<u32>> {
    let list = |g| w.group_list(g).into_iter().map(|rank| w.index[rank as usize]).collect();
    (0..w.groups_x() * w.groups_y()).map(list).collect()
}

struct Naive {
    updated: Vec<Vec<u32>>,
    shifts: Vec<usize>,
}

/// Compares one frame with what `found` says, and gives the order that comes out.
fn compare(
    old: &[Vec<u32>],
    w: &FrameWorkload,
    first: usize,
    found: &powergs_core::workload::reuse::Reuse,
) -> Naive {
    let mut naive = Naive { updated: Vec::new(), shifts: Vec::new() };
    for ((old, exact), found) in old.iter().zip(lists(w)).zip(&found.lists) {
        let place = |index: &u32| exact.iter().position(|e| e == index);
        let kept: Vec<usize> = old.iter().filter_map(place).collect();
        let mut ordered = kept.clone();
        ordered.sort_unstable();
        let shift =
            |(i, at): (usize, &usize)| i.abs_diff(ordered.iter().position(|o| o == at).unwrap());
        naive.shifts.extend(kept.iter().enumerate().map(shift));
        let mut updated = kept.clone();
        for at in (0..exact.len()).filter(|at| !kept.contains(at)) {
            // Before the first old entry that is farther, behind the new ones that are nearer.
            let from = updated.iter().position(|u| *u > at && kept.contains(u));
            updated.insert(from.unwrap_or(updated.len()), at);
        }
        let first = first.min(updated.len());
        updated[..first].sort_unstable();
        updated[first..].chunks_mut(w.geometry.chunk as usize).for_each(<[usize]>::sort_unstable);
        assert_eq!(found.kept as usize, kept.len());
        assert_eq!(found.new as usize, exact.len() - kept.len());
        assert_eq!(found.gone as usize, old.len() - kept.len());
        let adjacent = updated.windows(2).filter(|w| w[0] > w[1]).count();
        assert_eq!(found.out_of_order as usize, adjacent);
        naive.updated.push(updated.iter().map(|&at| exact[at]).collect());
    }
    naive.shifts.sort_unstable();
    naive
}

#[test]
fn updates_equal_a_direct_count() {
    let frames = frames(4, 0.15);
    for geometry in GEOMETRIES {
        let workloads: Vec<FrameWorkload> = frames.iter().map(|f| bin(f, geometry)).collect();
        let mut order = SortedLists::exact(&workloads[0]);
        let mut old = lists(&workloads[0]);
        let chunk = geometry.chunk as usize;
        for (age, w) in (1..).zip(&workloads[1..]) {
            let (reuse, next) = update(&order, w);
            let first = if age % 2 == 1 { chunk } else { chunk.div_ceil(2) };
            let naive = compare(&old, w, first, &reuse);
            for (group, list) in (0..).zip(&naive.updated) {
                assert_eq!(next.list(group), list, "{geometry:?} {group}");
            }
            let s = reuse.summary;
            let n = naive.shifts.len();
            assert_eq!(s.kept, n as u64);

            assert_eq!(s.rank_shift_p99 as usize, naive.shifts[(n * 99).div_ceil(100) - 1]);
            let keeps = |l: &&powergs_core::workload::reuse::ListReuse| {
                f64::from(l.kept) > KEEP * f64::from(l.kept + l.gone)
            };
            assert_eq!(s.keeping, reuse.lists.iter().filter(keeps).count() as u64);
            assert_eq!(next.age(), age);
            (order, old) = (next, naive.updated);
        }
    }
}

#[test]
fn the_same_frame_again_reuses_everything() {
    let frame = &frames(1, 0.0)[0];
    let w = bin(frame, GEOMETRIES[0]);
    let exact = SortedLists::exact(&w);
    let (reuse, next) = update(&exact, &w);
    let s = reuse.summary;
    assert_eq!((s.kept, s.new, s.gone), (w.counters.tile_pairs, 0, 0));
    assert_eq!((s.out_of_order, s.rank_shift_p99), (0, 0));
    assert_eq!(s.keeping, s.old_lists);
    assert!((0..w.tiles.len() as u32).all(|g| next.list(g) == exact.list(g)));
}

#[test]
fn nothing_is_reused_across_image_sizes_and_geometries() {
    let (scene, camera) = dense_scene(52);
    let frame = |camera: &Camera| {
        render(&scene, camera, &Options::reference(Detail::Counters)).into_frame(camera, [0.0; 3])
    };
    let (small, large) = (frame(&camera), frame(&Camera { width: 170, ..camera.clone() }));
    let old = SortedLists::exact(&bin(&small, GEOMETRIES[0]));
    for w in [bin(&large, GEOMETRIES[0]), bin(&small, GEOMETRIES[1])] {
        let (reuse, next) = update(&old, &w);
        assert_eq!((reuse.summary.kept, reuse.summary.old_lists), (0, 0));
        assert_eq!(reuse.summary.out_of_order, 0, "new entries are sorted");
        assert!(lists(&w).iter().zip(0..).all(|(list, g)| next.list(g) == list));
    }
}
