//! Frames of which not all pixels are rendered (A141, A142, A143), against loops that know only
//! pixels.

use std::collections::HashMap;
use std::ops::AddAssign;

use powergs_core::flow::over::pixels::{
    PixelOrigin, PixelSummary, RENDERED_PIXELS, SomePixels, SomeRegions,
};
use powergs_core::flow::resident::work::{Region, RegionShape, ResidentFrame};
use powergs_core::flow::tile_wise::blended::pixel_origins;
use powergs_core::flow::tile_wise::{FoveaSpec, PixelSource, SamplePattern};
use powergs_core::flow::{FrameTask, History};
use powergs_core::kernel::Memo;
use powergs_core::machine::Machine;
use powergs_core::sim::{SimError, Timed, time};
use powergs_core::workload::{FrameDetail, FrameWorkload, Geometry, STORAGE_BLOCK, bin_for};
use powergs_frame::scene::Camera;
use powergs_frame::splat::{Splat, TRANSMITTANCE_MIN};
use powergs_frame::trace::Frame;
use powergs_testkit::scenes::{front_camera, random_scene};

use crate::pipeline::support::{Dice, gscore};
use crate::workload::support::rendered;

const PIXELS: FrameDetail = FrameDetail { pixels: true, whole: false };

fn geometry() -> Geometry {
    Geometry { subtile: 4, chunk: 16, ..Geometry::REFERENCE }
}

fn machine(source: PixelSource, change: impl Fn(&mut Machine)) -> Machine {
    let mut machine = gscore();
    let m = machine.tiles_mut();
    m.fovea = FoveaSpec::default();
    m.geometry = geometry();
    m.pixels.source = source;
    change(&mut machine);
    machine
}

/// Frames of a camera that turns and moves by so much from one to the next, in front of a scene
/// that stops some pixels and not others.
fn path(seed: u64, frames: usize, step: f64) -> Vec<Frame> {
    let mut scene = random_scene(seed, 400, 0);
    for (mean, opacity) in scene.means.iter().zip(&mut scene.logit_opacities) {
        *opacity = if mean[0] > 0.6 { -6.0 } else { *opacity + 2.0 };
    }
    let one = |i: usize| {
        let mut camera = front_camera(75, 51);
        camera.centre.x += step * i as f64;
        camera.world_to_camera *= glam::DMat3::from_rotation_y(0.3 * step * i as f64);
        rendered(&scene, &camera).1
    };
    (0..frames).map(one).collect()
}

fn binned(frames: &[Frame]) -> Vec<FrameWorkload> {
    frames.iter().map(|frame| bin_for(frame, geometry(), PIXELS)).collect()
}

/// What frames render, one after the other.
fn some(machine: &Machine, frames: &[FrameWorkload]) -> Vec<SomePixels> {
    let mut history = History::default();
    let filter = machine.tiles().pixel_filter().expect("a source");
    let of = |w| SomePixels::of(filter, w, None, &mut history, true);
    frames.iter().map(of).collect()
}

/// What a pixel blends: list positions and scene indices, the depth behind which less than half of
/// the light is left, and what is left in the end.
fn blended(w: &FrameWorkload, x: u32, y: u32) -> (Vec<(u32, u32)>, f32, f32) {
    let tile = &w.tiles[(y / 16 * w.tiles_x + x / 16) as usize];
    let splats = &w.pixels.as_ref().expect("asked for").splats;
    let (mut seen, mut light, mut depth) = (Vec::new(), 1.0f32, f32::INFINITY);
    for (at, &rank) in (0..).zip(w.list_of(tile)) {
        let alpha = alpha(&splats[rank as usize], x, y);
        if alpha == 0.0 {
            continue;
        }
        seen.push((at, w.index[rank as usize]));
        let rest = light * (1.0 - alpha);
        if rest < 0.5 && depth == f32::INFINITY {
            depth = w.depth[rank as usize];
        }
        if rest < TRANSMITTANCE_MIN {
            break;
        }
        light = rest;
    }
    (seen, depth, light)
}

/// The opacity of a splat in a pixel, as the rasteriser has it.
pub(crate) fn alpha(splat: &Splat, x: u32, y: u32) -> f32 {
    let [c0, c1, c2] = splat.conic().expect("a proper splat");
    let [dx, dy] = [x as f32 - splat.mean[0], y as f32 - splat.mean[1]];
    let power = -0.5 * (c0 * dx * dx + c2 * dy * dy) - c1 * dx * dy;
    let alpha = (splat.opacity * power.exp()).min(0.99);
    if power > 0.0 || alpha < 1.0 / 255.0 { 0.0 } else { alpha }
}

fn places(w: &FrameWorkload) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (width, height) = (w.width, w.height);
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// Where a point of the world, or with `None` what is infinitely far in this direction, is seen.
fn seen_at(camera: &Camera, world: glam::DVec3, far: bool) -> Option<([f64; 2], f64)> {
    let point = if far { world } else { world - camera.centre };
    let p = camera.world_to_camera * point;
    let at = [camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy];
    (p.z > 0.0).then_some((at, p.z))
}

#[test]
fn pixels_come_to_where_their_points_are() {
    let mut moved = [0, 0, 0];
    for seed in 1..4 {
        let frames = path(seed, 2, 0.05);
        let w = binned(&frames);
        let machine = machine(PixelSource::Warped, |m| m.tiles_mut().pixels.holes = 0.1);
        let found = &some(&machine, &w)[1];
        let [old, new] = [0, 1].map(|i| &frames[i].facts.camera);
        // Each pixel of the new frame, and the nearest of the old one that comes there.
        let mut from: HashMap<(u32, u32), (f64, u32)> = HashMap::new();
        for (source, (x, y)) in (0..).zip(places(&w[0])) {
            let depth = f64::from(blended(&w[0], x, y).1);
            let ray = glam::DVec3::new(
                (f64::from(x) + 0.5 - old.cx) / old.fx,
                (f64::from(y) + 0.5 - old.cy) / old.fy,
                1.0,
            );
            let turned = old.world_to_camera.transpose() * ray;
            let far = depth.is_infinite();
            let point = if far { turned } else { old.centre + turned * depth };
            let Some(([x, y], z)) = seen_at(new, point, far) else { continue };
            let inside = x >= 0.0 && y >= 0.0 && x < 75.0 && y < 51.0;
            if inside {
                let z = if far { f64::INFINITY } else { z };
                let nearest = from.entry((x as u32, y as u32)).or_insert((z, source));
                if z < nearest.0 {
                    *nearest = (z, source);
                }
            }
        }
        let mut expected = PixelSummary { pixels: 75 * 51, ..PixelSummary::default() };
        for (i, tile) in w[1].tiles.iter().enumerate() {
            let (x0, y0, x1, y1) = w[1].pixels_of(i);
            let area = || (y0..y1).flat_map(move |y| (x0..x1).map(move |x| (x, y)));
            let missing = area().filter(|place| !from.contains_key(place)).count() as u64;
            let anew = missing as f64 > 0.1 * f64::from(tile.pixels);
            let made = found.made.as_ref().expect("a part of it");
            assert_eq!(made.tiles[i].entries, if anew { tile.entries } else { 0 });
            for (x, y) in area() {
                let origin = found.origins[(y * 75 + x) as usize];
                let there = from.get(&(x, y)).map(|(_, source)| PixelOrigin::Moved(*source));
                let there = there.unwrap_or(PixelOrigin::Filled);
                // Points that are equally deep in 32 bits and not in 64.
                let same = origin == there
                    || matches!((origin, there), (PixelOrigin::Moved(_), PixelOrigin::Moved(_)));
                assert!(if anew { origin == PixelOrigin::Rendered } else { same }, "{x} {y}");
                moved[2] += usize::from(!anew && origin != there);
            }
            let pixels = u64::from(tile.pixels);
            match anew {
                true => expected.rendered += pixels,
                false => {
                    expected.taken += pixels - missing;
                    expected.filled += missing;
                }
            }
            moved[usize::from(anew)] += 1;
        }
        assert_eq!(found.summary, expected);
    }
    assert!(moved[0] > 5 && moved[1] > 5 && moved[2] < 5, "{moved:?}");
}

#[test]
fn a_camera_that_stands_still_takes_everything() {
    let w = binned(&path(1, 1, 0.0)).remove(0);
    let machine = machine(PixelSource::Warped, |m| m.tiles_mut().pixels.period = 3);
    let frames = [0, 1, 2, 3, 4].map(|_| w.clone());
    let found = some(&machine, &frames);
    for (i, found) in found.iter().enumerate() {
        let all = u64::from(w.width * w.height);
        let whole = i % 3 == 0;
        assert_eq!(found.summary.rendered, if whole { all } else { 0 }, "frame {i}");
        assert_eq!(found.summary.taken, if whole { 0 } else { all });
        assert_eq!(found.made.is_none(), whole);
        let own = (0..).map(PixelOrigin::Moved);
        assert!(whole || found.origins.iter().copied().eq(own.take(all as usize)));
    }
    let made = found[1].made.as_ref().expect("nothing of it");
    assert_eq!((made.list.len(), made.counters.tile_pairs, made.counters.blends), (0, 0, 0));
    assert_eq!(made.counters.survivors, w.counters.survivors);
    assert!(made.slot.iter().all(|&slot| slot == u32::MAX));
}

#[test]
fn what_was_filled_in_is_not_moved_on() {
    let frames = path(2, 4, 0.04);
    let w = binned(&frames);
    let machine = machine(PixelSource::Warped, |m| {
        m.tiles_mut().pixels.holes = 1.0;
        m.tiles_mut().pixels.period = 100;
    });
    let found = some(&machine, &w);
    for i in 2..4 {
        for origin in &found[i].origins {
            if let PixelOrigin::Moved(from) = origin {
                assert_ne!(found[i - 1].origins[*from as usize], PixelOrigin::Filled);
            }
        }
        assert!(found[i].summary.filled > found[i - 1].summary.filled);
    }
}

#[test]
fn all_of_the_lists_are_the_frame() {
    let w = binned(&path(3, 1, 0.0)).remove(0);
    let machine = machine(PixelSource::Sampled, |m| {
        (m.tiles_mut().pixels.stride, m.tiles_mut().pixels.period) = (1, 0);
    });
    let found = some(&machine, std::slice::from_ref(&w)).remove(0);
    let made = *found.made.expect("samples");
    // Hardware with sub-tile skipping is counted where frames are binned alone.
    let evaluations = w.alpha_evaluations_executed;
    assert_eq!(FrameWorkload { alpha_evaluations_executed: evaluations, ..made }, w);
}

#[test]
fn a_sample_is_one_pixel_in_a_square() {
    let w = binned(&path(4, 1, 0.0)).remove(0);
    for (pattern, stride) in
        [(SamplePattern::Grid, 8), (SamplePattern::Random, 8), (SamplePattern::Unseen, 20)]
    {
        let machine = machine(PixelSource::Sampled, |m| {
            let p = &mut m.tiles_mut().pixels;
            (p.pattern, p.stride, p.period) = (pattern, stride, 3);
        });
        let found = some(&machine, &[w.clone(), w.clone(), w.clone(), w.clone()]);
        assert!(found[0].made.is_none() && found[3].made.is_none(), "one in three is whole");
        let chosen = |found: &SomePixels| {
            let made = found.made.as_ref().expect("samples");
            let iterated = &made.pixels.as_ref().expect("asked for").iterated;
            let own = &w.pixels.as_ref().expect("asked for").iterated;
            let mut chosen = Vec::new();
            for (i, (x, y)) in places(&w).enumerate() {
                let unseen = pattern == SamplePattern::Unseen && blended(&w, x, y).2 > 0.5;
                if iterated[i] > 0 && !unseen {
                    assert_eq!(iterated[i], own[i], "it goes as far as ever");
                    chosen.push((x, y));
                }
                assert!(!unseen || iterated[i] == own[i]);
            }
            let mut cells: Vec<_> = chosen.iter().map(|(x, y)| (x / stride, y / stride)).collect();
            cells.sort_unstable();
            assert!(cells.windows(2).all(|two| two[0] != two[1]), "one of each square");
            let blends: u64 = places(&w)
                .zip(iterated)
                .filter(|(_, iterated)| **iterated > 0)
                .map(|((x, y), _)| blended(&w, x, y).0.len() as u64)
                .sum();
            assert_eq!(made.counters.blends, blends);
            let finished: u64 = made.tiles.iter().map(|tile| u64::from(tile.pixels)).sum();
            assert_eq!(finished, found.summary.rendered);
            chosen
        };
        let (first, second) = (chosen(&found[1]), chosen(&found[2]));
        assert_eq!(first == second, pattern == SamplePattern::Grid);
    }
}

#[test]
fn pixels_stop_where_their_first_gaussians_are_known() {
    let frames = binned(&path(5, 3, 0.01));
    let (ids, ways, entries) = (12, 2, 64);
    let machine = machine(PixelSource::Cached, |m| {
        let p = &mut m.tiles_mut().pixels;
        (p.ids, p.ways, p.region) = (ids, ways, 32);
        p.buffer.capacity = powergs_base::quantity::Bytes(entries * p.entry.0);
    });
    let found = some(&machine, &frames);
    // Without sets: a cache that forgets knows no more than one that does not.
    let mut known: HashMap<(u32, u32), Vec<Vec<u32>>> = HashMap::new();
    let (mut hits, mut lookups) = (0, 0);
    for (number, (w, found)) in (0u32..).zip(frames.iter().zip(&found)) {
        let made = found.made.as_ref().expect("it stops sooner");
        let iterated = &made.pixels.as_ref().expect("asked for").iterated;
        let own = &w.pixels.as_ref().expect("asked for").iterated;
        let (mut looked, mut hit) = (0, 0);
        // Regions go tile by tile.
        for tile in 0..w.tiles.len() {
            let (x0, y0, x1, y1) = w.pixels_of(tile);
            for (x, y) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))) {
                let i = (y * w.width + x) as usize;
                let seen = blended(w, x, y).0;
                let Some(first) = seen.get(..ids as usize) else {
                    assert_eq!((found.origins[i], iterated[i]), (PixelOrigin::Rendered, own[i]));
                    continue;
                };
                looked += 1;
                let key: Vec<u32> = first.iter().map(|(_, index)| *index).collect();
                let region = known.entry((x / 32, y / 32)).or_default();
                match found.origins[i] {
                    PixelOrigin::Known { frame, pixel } => {
                        hit += 1;
                        assert!(region.contains(&key), "nobody has left this");
                        assert_eq!(iterated[i], first[ids as usize - 1].0 + 1);
                        let (px, py) = (pixel % w.width, pixel / w.width);
                        let there = blended(&frames[frame as usize], px, py).0;
                        let there = there[..ids as usize].iter().map(|(_, index)| *index);
                        assert!(there.eq(key.iter().copied()) && frame <= number);
                    }
                    _ => assert_eq!(iterated[i], own[i]),
                }
                region.push(key);
            }
        }
        assert_eq!((found.summary.lookups, found.summary.hits), (looked, hit));
        (hits, lookups) = (hits + hit, lookups + looked);
        let held: u64 = found.blocks.iter().map(|block| block.write).sum();
        assert!(found.blocks.iter().all(|block| block.write <= entries * 13) && held > 0);
    }
    assert!(hits > lookups / 10 && hits < lookups, "{hits} of {lookups}");
    // More room knows more, and all of it again in the same frame.
    let wide = |capacity: u64| {
        let mut machine = machine.clone();
        machine.tiles_mut().pixels.buffer.capacity = powergs_base::quantity::Bytes(capacity);
        some(&machine, &frames).iter().map(|found| found.summary.hits).sum::<u64>()
    };
    let all = wide(1 << 20);
    assert!(all > hits, "{all} and {hits} of {lookups}");
}

/// Takes frames through a machine, one after the other.
fn run(machine: &Machine, frames: &[Frame]) -> Vec<Result<Timed, SimError>> {
    let flow = machine.flow();
    let mut history = History::default();
    let of = |frame: &Frame| {
        let work = flow.work_key(machine).prepare(frame);
        let memo = Memo::default();
        let before = flow.hand_over(machine, &*work, None, &mut history);
        let task =
            FrameTask { before: before.as_ref(), ..FrameTask::first(machine, &*work, &memo) };
        time(&task)
    };
    frames.iter().map(of).collect()
}

#[test]
fn regions_of_the_size_of_tiles_are_rendered_as_tiles_are() {
    let (mut rendered, mut moved) = (0, 0);
    for seed in 1..4 {
        let w = binned(&path(seed, 3, 0.05));
        let machine = machine(PixelSource::Warped, |m| m.tiles_mut().pixels.holes = 0.1);
        let filter = machine.tiles().pixel_filter().expect("a source");
        let (tiles, mut history) = (some(&machine, &w), History::default());
        for (frame, tiles) in w.iter().zip(&tiles) {
            let regions = SomeRegions::of(filter, frame, [16; 2], None, &mut history);
            assert_eq!(regions.summary, tiles.summary);
            assert_eq!(regions.blocks, tiles.blocks);
            assert_eq!(regions.wanted.is_some(), tiles.made.is_some());
            let (Some(wanted), Some(made)) = (&regions.wanted, &tiles.made) else { continue };
            for ((&wanted, made), whole) in wanted.iter().zip(&made.tiles).zip(&frame.tiles) {
                assert_eq!(made.entries, if wanted { whole.entries } else { 0 });
                [&mut moved, &mut rendered][usize::from(wanted)].add_assign(1);
            }
        }
    }
    assert!(rendered > 10 && moved > 10, "{rendered} {moved}");
}

#[test]
fn a_part_of_the_regions_has_what_is_in_them() {
    let mut dice = Dice::new(3);
    for frame in path(2, 3, 0.1) {
        let shape =
            RegionShape { width: 25, height: 17, ..RegionShape::of(&[0, 0, 0, 4, 0, 1, 0]) };
        let whole = ResidentFrame::new(&frame, shape);
        assert_eq!(whole.with_some(&vec![true; whole.regions.len()]), whole);
        let wanted: Vec<bool> = whole.regions.iter().map(|_| dice.roll(0, 1) == 1).collect();
        let part = whole.with_some(&wanted);
        let lists = |of: &ResidentFrame| -> Vec<Vec<u32>> {
            let list = |r: &Region| {
                let own = &of.entries[r.start as usize..][..r.entries as usize];
                own.iter().map(|entry| of.index[of.slot[entry.rank as usize] as usize]).collect()
            };
            of.regions.iter().map(list).collect()
        };
        let mut expected = lists(&whole);
        let mut keep = wanted.iter();
        expected.retain(|_| *keep.next().expect("each has one"));
        assert_eq!(lists(&part), expected);
        let mut seen: Vec<u32> = expected.iter().flatten().copied().collect();
        let entries = |to: usize| seen.iter().filter(|&&i| (i as usize) < to).count() as u64;
        for (i, (own, of_whole)) in part.storage.iter().zip(&whole.storage).enumerate() {
            let to = if i + 1 == part.storage.len() {
                usize::MAX
            } else {
                (i + 1) * STORAGE_BLOCK as usize
            };
            assert_eq!(own.entries, entries(to), "{i}");
            // The front looks at all that are shown.
            assert_eq!([own.survivors, own.rows], [of_whole.survivors, of_whole.rows]);
        }
        assert_eq!(part.counters.tile_pairs, seen.len() as u64);
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(part.index, seen);
        assert_eq!(part.storage.last().map(|all| all.splats), Some(seen.len() as u64));
    }
}

#[test]
fn what_is_moved_is_read_and_written_once_and_takes_its_time() {
    let frames = path(6, 2, 0.02);
    let w = binned(&frames);
    let machine =
        |rate: u32| machine(PixelSource::Warped, |m| m.tiles_mut().pixels.per_cycle = rate);
    let (slow, fast) = (machine(1), machine(64));
    let summary = some(&slow, &w)[1].summary;
    let timed = run(&slow, &frames).remove(1).expect("it runs");
    let bytes = slow.tiles().record.pixel.0 + 4;
    let served = timed.outcome.served.stages[2];
    // Pixels that are rendered have their depth too.
    assert_eq!(served.write, summary.pixels * bytes);
    assert_eq!(timed.outcome.measured, summary.measured());
    let cycles = |timed: &Timed| timed.outcome.timing.frame;
    let quick = run(&fast, &frames).remove(1).expect("it runs");
    let gain = cycles(&timed) - cycles(&quick);
    assert!(gain > summary.pixels / 2 && gain < summary.pixels, "{gain}");
    // A sample writes no other pixels.
    let sampled = self::machine(PixelSource::Sampled, |m| m.tiles_mut().pixels.period = 0);
    let timed = run(&sampled, &frames[..1]).remove(0).expect("it runs");
    let pixels = timed.outcome.measured.count(&RENDERED_PIXELS).expect("a part");
    assert_eq!(timed.outcome.served.stages[2].write, pixels * sampled.tiles().record.pixel.0);
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let frames = path(1, 2, 0.01);
    let refused = |machine: &Machine, words: &[&str]| {
        let error = run(machine, &frames).remove(0).expect_err("refused").to_string();
        words.iter().for_each(|word| assert!(error.contains(word), "{error} lacks {word}"));
    };
    let large = machine(PixelSource::Sampled, |m| m.tiles_mut().pixels.stride = 64);
    refused(&large, &["pixels.stride", "64", "75x51", "51"]);
    let few = machine(PixelSource::Warped, |m| {
        m.tiles_mut().pixels.buffer.capacity = powergs_base::quantity::Bytes(20);
    });
    refused(&few, &["20 parts of the image", "40 B", "pixels.buffer.capacity"]);
    let one = machine(PixelSource::Warped, |_| {});
    let error = one.flow().goes_over(&one, 1).expect_err("one frame");
    assert!(error.contains("--path-frames") && error.contains("pixels.period"), "{error}");
    assert!(one.flow().goes_over(&one, 2).is_ok());
}

#[test]
fn machines_without_a_source_have_no_origins() {
    let w = binned(&path(1, 1, 0.0)).remove(0);
    let all = machine(PixelSource::All, |_| {});
    assert!(pixel_origins(&all, &w, None, &mut History::default()).is_none());
}
