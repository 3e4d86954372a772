//! Two eyes of a pair on machines that share something between them (A132).

use powergs_core::flow::over::second_eye::{FirstView, NoSecond, derived, shared};
use powergs_core::flow::tile_wise::{FoveaSpec, StereoImpl};
use powergs_core::flow::{FrameTask, History};
use powergs_core::kernel::Memo;
use powergs_core::machine::Machine;
use powergs_core::sim::{SimError, Timed, time};
use powergs_core::workload::{FrameDetail, FrameWorkload, Geometry, bin_for};
use powergs_frame::splat::Splat;
use powergs_frame::trace::Frame;
use powergs_scene::camera::edit::stereo;
use powergs_testkit::scenes::{front_camera, random_scene};

use crate::pipeline::support::gscore;
use crate::workload::support::rendered;

/// Both views of a scene that stops pixels.
fn pair(seed: u64, distance: f64) -> [Frame; 2] {
    let mut scene = random_scene(seed, 500, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    stereo(&front_camera(75, 51), distance).map(|camera| {
        let mut frame = rendered(&scene, &camera).1;
        frame.facts.camera.eye = camera.eye;
        frame
    })
}

const PIXELS: FrameDetail = FrameDetail { pixels: true, whole: false };

fn geometry(chunk: u32) -> Geometry {
    Geometry { subtile: 4, chunk, ..Geometry::REFERENCE }
}

/// With the margin of the rasteriser's ellipse.
fn reaches(splat: &Splat, x: u32, y: u32) -> bool {
    let Some(conic) = splat.conic() else { return false };
    let [c0, c1, c2] = conic.map(f64::from);
    let exact = 2.0 * (255.0 * f64::from(splat.opacity)).ln();
    let level = exact + 2e-3 + 1e-6 * exact * (c0 * c2 / (c0 * c2 - c1 * c1)).abs();
    let [dx, dy] = [x, y].map(f64::from);
    let (dx, dy) = (dx - f64::from(splat.mean[0]), dy - f64::from(splat.mean[1]));
    c0 * dx * dx + 2.0 * c1 * dx * dy + c2 * dy * dy <= level
}

/// The opacity of a splat in a pixel, where it is not too faint to be blended.
fn alpha(splat: &Splat, x: u32, y: u32) -> f64 {
    let [c0, c1, c2] = splat.conic().expect("a proper splat").map(f64::from);
    let [dx, dy] = [f64::from(x), f64::from(y)];
    let (dx, dy) = (dx - f64::from(splat.mean[0]), dy - f64::from(splat.mean[1]));
    let power = -0.5 * (c0 * dx * dx + 2.0 * c1 * dx * dy + c2 * dy * dy);
    let alpha = (f64::from(splat.opacity) * power.exp()).min(0.99);
    if alpha < 1.0 / 255.0 { 0.0 } else { alpha }
}

/// Whether an entry blends in a pixel.
fn blends(w: &FrameWorkload, rank: u32, at: u32, x: u32, y: u32) -> bool {
    let pixels = w.pixels.as_ref().expect("asked for");
    pixels.iterated[(y * w.width + x) as usize] > at && reaches(&pixels.splats[rank as usize], x, y)
}

/// Whether a splat of the scene blends in a sub-tile of a view, by column and row; beside the image
/// it counts as if it did.
fn blends_in(w: &FrameWorkload, index: u32, column: i64, row: u32) -> bool {
    let n = w.geometry.subtile;
    if column < 0 || column >= i64::from(w.width.div_ceil(n)) {
        return true;
    }
    let (x0, y0) = (column as u32 * n, row * n);
    let tile = (y0 / w.geometry.tile * w.tiles_x + x0 / w.geometry.tile) as usize;
    let list = w.list_of(&w.tiles[tile]);
    let Some(at) = list.iter().position(|&rank| w.index[rank as usize] == index) else {
        return false;
    };
    let pixels =
        (y0..(y0 + n).min(w.height)).flat_map(|y| (x0..(x0 + n).min(w.width)).map(move |x| (x, y)));
    pixels.into_iter().any(|(x, y)| blends(w, list[at], at as u32, x, y))
}

#[test]
fn second_views_have_what_blends_under_them_in_the_first() {
    let (mut kept, mut gone, mut lost, mut changes) = (0, 0, 0, 0);
    for (seed, reach) in [(1, 64.0), (2, 64.0), (3, 1.5), (4, 3.0)] {
        let [left, right] = pair(seed, 0.05).map(|frame| bin_for(&frame, geometry(16), PIXELS));
        let first = FirstView::new(&left, true);
        let (made, summary) = derived(&first, &right, reach).expect("a pair");
        let (mut own_lost, mut changed) = (0u64, [0; 2]);
        // Light that is left in each pixel, and the weights of what is lost, and cut off.
        let mut light = vec![1.0f64; (right.width * right.height) as usize];
        let mut lost_weights = vec![[0.0f64; 2]; light.len()];
        let splats = |w: &FrameWorkload| w.pixels.as_ref().expect("asked for").splats.clone();
        let (of_left, of_right) = (splats(&left), splats(&right));
        for (tile, work) in right.tiles.iter().enumerate() {
            let (x0, y0, x1, y1) = right.pixels_of(tile);
            let mut expected = Vec::new();
            for (at, &rank) in (0u32..).zip(right.list_of(work)) {
                let (index, splat) = (right.index[rank as usize], &of_right[rank as usize]);
                let before = of_left.iter().find(|splat| splat.index == index);
                let shift = before.map(|before| before.mean[0] - splat.mean[0]);
                let is_handed_on = |s: u32| {
                    let Some(shift) = shift else { return true };
                    let (x, row) = (i64::from(x0 + s % 4 * 4), y0 / 4 + s / 4);
                    let columns = [x, x + 3]
                        .map(|x| ((x as f64 + f64::from(shift)).round() as i64).div_euclid(4));
                    let mut columns = columns[0]..=columns[1];
                    shift.abs() <= reach && columns.any(|c| blends_in(&left, index, c, row))
                };
                let bits = work.list_start as usize + at as usize;
                let has = |s: u32| right.bitmaps[2 * bits + s as usize / 8] >> (s % 8) & 1 == 1;
                let own: Vec<u32> = (0..16).filter(|&s| has(s) && is_handed_on(s)).collect();
                for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                    let s = (y - y0) / 4 * 4 + (x - x0) / 4;
                    if !blends(&right, rank, at, x, y) {
                        continue;
                    }
                    let pixel = (y * right.width + x) as usize;
                    let weight = light[pixel] * alpha(splat, x, y);
                    light[pixel] -= weight;
                    if !own.contains(&s) {
                        own_lost += 1;
                        lost_weights[pixel][0] += weight;
                        let is_far = shift.is_some_and(|shift| shift.abs() > reach);
                        lost_weights[pixel][1] += if is_far { weight } else { 0.0 };
                    }
                }
                if own.is_empty() {
                    gone += 1;
                } else {
                    expected.push((rank, own));
                }
            }
            let new = &made.tiles[tile];
            let found: Vec<(u32, Vec<u32>)> = (0..new.entries)
                .map(|at| {
                    let bits = &made.bitmaps[2 * (new.list_start + at) as usize..][..2];
                    let has = |s: &u32| bits[*s as usize / 8] >> (s % 8) & 1 == 1;
                    (made.list_of(new)[at as usize], (0..16).filter(has).collect())
                })
                .collect();
            assert_eq!(found, expected, "seed {seed} tile {tile}");
            kept += found.len();
            let chunks = made.chunks_of(new).iter().map(|chunk| chunk.entries).sum::<u32>();
            assert_eq!(chunks, new.loaded);
        }
        for weights in &lost_weights {
            (0..2).for_each(|k| changed[k] += u64::from(weights[k] >= 1.0 / 255.0));
        }
        assert_eq!(summary.lost_blends, own_lost);
        assert_eq!([summary.changed_pixels, summary.cut_off_pixels], changed);
        assert_eq!(summary.entries, right.list.len() as u64);
        assert!(summary.largest_disparity <= reach);
        lost += own_lost;
        changes += changed[0];
    }
    let all = [kept as u64, gone, lost, changes];
    assert!(kept > 1000 && gone > 1000 && lost > 100 && changes > 100, "{all:?}");
}

#[test]
fn views_that_are_no_pair_are_refused() {
    let [left, right] = pair(1, 0.05).map(|frame| bin_for(&frame, geometry(16), PIXELS));
    let other = bin_for(&pair(1, 0.05)[1], Geometry { chunk: 8, ..right.geometry }, PIXELS);
    let first = FirstView::new(&left, true);
    assert_eq!(derived(&first, &other, 64.0).unwrap_err(), NoSecond::Different);
    assert_eq!(shared(&first, &other).unwrap_err(), NoSecond::Different);
    // An eye that is higher.
    let mut scene = random_scene(1, 500, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    let mut camera = front_camera(75, 51);
    camera.centre.y += 0.2;
    let higher = bin_for(&rendered(&scene, &camera).1, right.geometry, PIXELS);
    assert!(matches!(derived(&first, &higher, 64.0), Err(NoSecond::Rows(rows)) if rows > 1.0));
}

fn machine(way: StereoImpl, lag: u32) -> Machine {
    let mut machine = gscore();
    let m = machine.tiles_mut();
    m.fovea = FoveaSpec::default();
    m.geometry = geometry(64);
    (m.stereo.implementation, m.stereo.lag) = (way, lag);
    machine
}

/// Takes frames through a machine, one after the other.
fn run(machine: &Machine, frames: &[Frame]) -> Vec<Result<Timed, SimError>> {
    let flow = machine.flow();
    let mut history = History::default();
    let of = |frame: &Frame| {
        let work = flow.work_key(machine).prepare(frame);
        let memo = Memo::default();
        let before = flow.hand_over(machine, &*work, frame.facts.camera.eye, &mut history);
        let task =
            FrameTask { before: before.as_ref(), ..FrameTask::first(machine, &*work, &memo) };
        time(&task)
    };
    frames.iter().map(of).collect()
}

fn cycles(timed: &Result<Timed, SimError>) -> u64 {
    timed.as_ref().expect("it runs").outcome.timing.frame
}

#[test]
fn the_second_eye_is_cheaper_the_more_it_takes_over() {
    let frames = pair(5, 0.02);
    let all = [StereoImpl::Separate, StereoImpl::Shared, StereoImpl::Derived]
        .map(|way| run(&machine(way, 4), &frames));
    let [separate, shared, derived] = &all;
    // The first eye is as any frame.
    assert_eq!(cycles(&separate[0]), cycles(&shared[0]));
    assert_eq!(cycles(&separate[0]), cycles(&derived[0]));
    assert!(cycles(&shared[1]) < cycles(&separate[1]));
    assert!(cycles(&derived[1]) < cycles(&shared[1]));
}

#[test]
fn what_cannot_be_a_second_eye_names_both_sides() {
    let refusal = |machine: &Machine, frames: &[Frame]| {
        let errors = run(machine, frames).into_iter().filter_map(Result::err);
        errors.map(|error| error.to_string()).next().expect("a refusal")
    };
    let [mut left, right] = pair(5, 0.02);
    let derived = machine(StereoImpl::Derived, 4);
    let text = refusal(&derived, std::slice::from_ref(&right));
    assert!(text.contains("`stereo.impl` = \"derived\"") && text.contains("--stereo"), "{text}");
    left.facts.camera.eye = None;
    assert!(refusal(&derived, &[left]).contains("half of a pair"));
    // Far more than a tile between the eyes.
    let text = refusal(&machine(StereoImpl::Derived, 1), &pair(5, 2.0));
    assert!(text.contains("`stereo.lag` = 1") && text.contains("geometry.tile"), "{text}");
    let mut levels = machine(StereoImpl::Derived, 4);
    levels.tiles_mut().fovea.accumulators = 1;
    let found = levels.contradictions();
    assert!(found.iter().any(|problem| format!("{problem:?}").contains("fovea.accumulators")));
}
