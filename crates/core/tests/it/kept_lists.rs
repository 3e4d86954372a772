//! Frames that go through lists of frames before (A134).

use powergs_core::flow::over::kept_order::KeptOrder;
use powergs_core::flow::tile_wise::measures;
use powergs_core::flow::tile_wise::{FoveaSpec, GsuImpl, GsuSpec};
use powergs_core::flow::{FrameTask, History};
use powergs_core::kernel::Memo;
use powergs_core::machine::Machine;
use powergs_core::sim::{Timed, time};
use powergs_core::workload::{FrameDetail, FrameWorkload, Geometry, bin_for};
use powergs_frame::splat::{ALPHA_MAX, Splat, TRANSMITTANCE_MIN};
use powergs_frame::trace::Frame;
use powergs_testkit::scenes::{front_camera, random_scene};

use crate::pipeline::support::gscore;
use crate::workload::support::{rendered, small_frames};

const PIXELS: FrameDetail = FrameDetail { pixels: true, whole: false };

fn geometry() -> Geometry {
    Geometry { subtile: 4, chunk: 16, ..Geometry::REFERENCE }
}

fn machine(way: GsuImpl) -> Machine {
    let mut machine = gscore();
    let m = machine.tiles_mut();
    m.fovea = FoveaSpec::default();
    m.geometry = geometry();
    m.record.entry_bitmap = false;
    (m.gsu.implementation, m.gsu.fan_in, m.gsu.reuse_period, m.gsu.margin) = (way, 2, 3, 16);
    machine
}

fn gsu(way: GsuImpl, margin: u32) -> GsuSpec {
    GsuSpec { margin, ..machine(way).tiles().gsu.clone() }
}

fn binned(frame: &Frame) -> FrameWorkload {
    bin_for(frame, geometry(), PIXELS)
}

/// A frame, and one of a camera that has turned: depths change, and with them the order.
fn turned_frames(seed: u64) -> [FrameWorkload; 2] {
    let mut scene = random_scene(seed, 500, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    [0.0, 0.05].map(|angle| {
        let mut camera = front_camera(75, 51);
        camera.world_to_camera *= glam::DMat3::from_rotation_y(angle);
        binned(&rendered(&scene, &camera).1)
    })
}

/// What frames do one after the other.
fn kept(gsu: &GsuSpec, frames: &[FrameWorkload]) -> Vec<KeptOrder> {
    let mut history = History::default();
    let keeping = gsu.keeping().expect("lists are kept");
    let of = |frame| KeptOrder::of(keeping, frame, None, &mut history);
    frames.iter().map(of).collect()
}

fn indices(w: &FrameWorkload, tile: usize) -> Vec<u32> {
    w.list_of(&w.tiles[tile]).iter().map(|&rank| w.index[rank as usize]).collect()
}

/// The opacity of a splat in a pixel, as the rasteriser has it.
fn alpha(splat: &Splat, x: u32, y: u32) -> f32 {
    let [c0, c1, c2] = splat.conic().expect("a proper splat");
    let [dx, dy] = [x as f32 - splat.mean[0], y as f32 - splat.mean[1]];
    let power = -0.5 * (c0 * dx * dx + c2 * dy * dy) - c1 * dx * dy;
    let alpha = (splat.opacity * power.exp()).min(ALPHA_MAX);
    if power > 0.0 || alpha < 1.0 / 255.0 { 0.0 } else { alpha }
}

#[test]
fn lists_of_a_camera_that_stands_still_are_those_of_the_frame() {
    for seed in 1..5 {
        let frame = binned(&small_frames(seed)[0]);
        let found = kept(&gsu(GsuImpl::Last, 0), &[frame.clone(), frame.clone()]);
        assert!(found[0].made.is_none() && found[0].summary.is_none());
        let made = found[1].made.as_ref().expect("lists of before");
        assert_eq!(made.list, frame.list);
        assert_eq!(made.bitmaps, frame.bitmaps);
        // Blended again in the same order, every pixel stops where the rasteriser stopped it.
        assert_eq!(made.pixels, frame.pixels);
        assert_eq!(made.stops, frame.stops);
        assert_eq!(made.chunks, frame.chunks);
        assert_eq!(made.tiles, frame.tiles);
        assert_eq!(made.counters.fetched_points, frame.counters.fetched_points);
        let summary = found[1].summary.expect("compared");
        assert_eq!((summary.new, summary.gone, summary.out_of_order), (0, 0, 0));
        // A margin of nothing is no margin.
        let shared = kept(&gsu(GsuImpl::Shared, 0), &[frame.clone(), frame.clone()]);
        for found in shared {
            assert_eq!(found.made.expect("a table").list, frame.list);
        }
    }
}

#[test]
fn a_moved_frame_is_blended_in_the_order_of_before() {
    let (mut stale, mut stops) = (0, 0);
    for seed in 1..5 {
        let [old, new] = turned_frames(seed);
        let found = kept(&gsu(GsuImpl::Last, 0), &[old.clone(), new.clone()]);
        let made = found[1].made.as_ref().expect("lists of before");
        let splats = &new.pixels.as_ref().expect("asked for").splats;
        let iterated = &made.pixels.as_ref().expect("asked for").iterated;
        for tile in 0..new.tiles.len() {
            let there = |index: &u32| {
                let rank = new.index.iter().position(|known| known == index)?;
                (new.slot[rank] != u32::MAX).then_some(rank)
            };
            let expected: Vec<usize> = indices(&old, tile).iter().filter_map(there).collect();
            let list = made.list_of(&made.tiles[tile]);
            assert_eq!(list.iter().map(|&rank| rank as usize).collect::<Vec<_>>(), expected);
            assert_eq!(found[1].lists.read[tile] as usize, indices(&old, tile).len());
            assert_eq!(found[1].lists.sorted[tile], new.tiles[tile].entries);
            stale += expected.windows(2).filter(|pair| pair[0] > pair[1]).count();
            let own = new.list_of(&new.tiles[tile]);
            let (x0, y0, x1, y1) = new.pixels_of(tile);
            for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                let (mut light, mut stop) = (1.0f32, expected.len());
                for (at, &rank) in expected.iter().enumerate() {
                    let is_own = own.contains(&(rank as u32));
                    let alpha = if is_own { alpha(&splats[rank], x, y) } else { 0.0 };
                    let rest = light * (1.0 - alpha);
                    if rest < TRANSMITTANCE_MIN {
                        stop = at + 1;
                        break;
                    }
                    light = rest;
                }
                assert_eq!(iterated[(y * new.width + x) as usize] as usize, stop, "{x} {y}");
                stops += usize::from(stop < expected.len());
            }
        }
        assert_eq!(found[1].summary.expect("compared").out_of_order, {
            let tiles = 0..made.tiles.len();
            let pairs = |tile| made.list_of(&made.tiles[tile]).windows(2).filter(|p| p[0] > p[1]);
            tiles.map(|tile| pairs(tile).count() as u64).sum::<u64>()
        });
    }
    assert!(stale > 10 && stops > 100, "{stale} {stops}");
}

#[test]
fn a_margin_has_what_comes_into_a_tile() {
    let frames = small_frames(3).map(|frame| binned(&frame));
    let missing = |way, margin| kept(&gsu(way, margin), &frames)[1].summary.expect("kept").new;
    let (last, narrow, wide) =
        (missing(GsuImpl::Last, 0), missing(GsuImpl::Shared, 0), missing(GsuImpl::Shared, 16));
    assert!(last > 10 && narrow == last && wide * 4 < last, "{last} {narrow} {wide}");
    let found = kept(&gsu(GsuImpl::Shared, 5), &frames);
    let table = found[0].made.as_ref().expect("a table");
    for tile in 0..frames[0].tiles.len() {
        let all = indices(table, tile);
        assert!(indices(&frames[0], tile).iter().all(|own| all.contains(own)));
    }
    // Once a period there is a new table.
    let four: Vec<FrameWorkload> = frames.iter().chain(&frames).cloned().collect();
    let sorts = kept(&gsu(GsuImpl::Shared, 5), &four);
    let sorts: Vec<bool> = sorts.iter().map(|frame| frame.lists.written() > 0).collect();
    assert_eq!(sorts, [true, false, false, true]);
}

/// Takes frames through a machine, one after the other.
fn run(machine: &Machine, frames: &[Frame]) -> Vec<Timed> {
    let flow = machine.flow();
    let mut history = History::default();
    let of = |frame: &Frame| {
        let work = flow.work_key(machine).prepare(frame);
        let memo = Memo::default();
        let before = flow.hand_over(machine, &*work, None, &mut history);
        let task =
            FrameTask { before: before.as_ref(), ..FrameTask::first(machine, &*work, &memo) };
        time(&task).expect("it runs")
    };
    frames.iter().map(of).collect()
}

#[test]
fn what_is_kept_is_read_and_written_once() {
    let frames = small_frames(2);
    let [old, new] = [0, 1].map(|i| binned(&frames[i]).counters.tile_pairs);
    let last = run(&machine(GsuImpl::Last), &frames);
    let key = machine(GsuImpl::Last).tiles().list_entry();
    let bytes = |timed: &Timed| {
        let served = timed.outcome.served.stages;
        [served[0].write, served[1].read, served[1].write]
    };
    let merge = run(&machine(GsuImpl::Merge), &frames);
    let records = |i: usize, pairs: u64| bytes(&merge[i])[0] - pairs * key;
    assert_eq!(bytes(&last[0]), [records(0, old) + old * key, old * key, old * key]);
    let written = records(1, new) + new * key;
    assert_eq!(bytes(&last[1]), [written, (old + new) * key, new * key]);
    let shared = run(&machine(GsuImpl::Shared), &frames);
    let [made, taken] = [&shared[0], &shared[1]].map(bytes);
    let table = made[2];
    assert!(table > old * key && made[1] == table);
    assert_eq!(taken, [records(1, new), table, 0]);
    assert!(shared[1].outcome.measured.count(&measures::KEPT) > Some(0));
    let cycles = |timed: &Timed| timed.outcome.timing.frame;
    assert!(cycles(&shared[1]) < cycles(&merge[1]));
}

#[test]
fn what_contradicts_kept_lists_names_both_keys() {
    for way in [GsuImpl::Last, GsuImpl::Shared] {
        assert!(machine(way).contradictions().is_empty());
        let refused = |change: fn(&mut Machine), key: &str| {
            let mut machine = machine(way);
            change(&mut machine);
            let found = machine.contradictions();
            let all: Vec<String> = found.iter().map(|problem| format!("{problem:?}")).collect();
            let both = |text: &&String| text.contains("gsu.impl") && text.contains(key);
            assert!(all.iter().any(|text| both(&text)), "{key}: {all:?}");
        };
        refused(|m| m.tiles_mut().record.entry_bitmap = true, "record.entry-bitmap");
        refused(|m| m.tiles_mut().geometry.sort_group = 64, "geometry.sort-group");
        refused(|m| m.tiles_mut().fovea.accumulators = 1, "fovea.accumulators");
        refused(
            |m| {
                let stereo = &mut m.tiles_mut().stereo;
                stereo.implementation = powergs_core::flow::tile_wise::StereoImpl::Shared;
            },
            "stereo.impl",
        );
    }
}
