//! Foveated pictures against a twin that renders every level whole and mixes pixel by pixel.

use powergs_frame::fovea::{GazeError, Screen, ScreenGaze, TileLevels};
use powergs_frame::splat::{Cover, Intersection, TileGrid};
use powergs_frame::trace::NEVER;
use powergs_raster::{Detail, FoveatedFrame, Options, Rendered, render, render_foveated};
use powergs_scene::{Camera, Foveated, Gaussians};
use powergs_testkit::foveated::{gaze_at, levels};
use powergs_testkit::scenes::front_camera;

fn options() -> Options {
    let background = [0.2, 0.5, 0.9];
    Options { background, ..Options::reference(Detail::Counters) }
}

struct Case {
    parts: [Gaussians; 4],
    camera: Camera,
    frame: FoveatedFrame,
    /// Every level, rendered whole.
    whole: Vec<Rendered>,
    tiles: TileLevels,
}

fn case(seed: u64, size: (u32, u32), gaze: [f32; 2], options: &Options) -> Case {
    case_of(levels(seed, 1500, 2, 0.7), size, gaze, options)
}

fn case_of(parts: [Gaussians; 4], size: (u32, u32), gaze: [f32; 2], options: &Options) -> Case {
    let model = Foveated::compose(&parts).expect("nested levels");
    let camera = front_camera(size.0, size.1);
    let gaze = gaze_at(gaze);
    let frame = render_foveated(&model, &camera, &gaze, options).expect("a gaze");
    let whole = parts.iter().map(|part| render(part, &camera, options)).collect();
    let map = gaze.eccentricity_map([size.0, size.1]).expect("a gaze");
    let tiles = TileLevels::new(&map, TileGrid::new(size.0, size.1, options.tile));
    Case { parts, camera, frame, whole, tiles }
}

impl Case {
    /// The levels that a pixel shows, and the share of the second.
    fn levels_at(&self, x: u32, y: u32) -> (usize, f64) {
        let grid = &self.tiles.grid;
        let tile = &self.tiles.tiles[grid.index(x / grid.tile, y / grid.tile)];
        (usize::from(tile.first), self.tiles.share(x, y))
    }

    fn compare(&self) {
        let (width, height) = (self.camera.width, self.camera.height);
        let mut mixed = [0u32; 4];
        for i in 0..(width * height) as usize {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let (first, share) = self.levels_at(x, y);
            let at = |k: usize| self.whole[k].picture.pixels[i];
            mixed[first] += u32::from(share > 0.0 && share < 1.0);
            for c in 0..3 {
                let second = if share > 0.0 { at(first + 1)[c] } else { 0.0 };
                let want = (1.0 - share) * f64::from(at(first)[c]) + share * f64::from(second);
                let got = f64::from(self.frame.picture.pixels[i][c]);
                // DC differences are added to sums of SH in another order: 1e-7 a blend.
                assert!((got - want).abs() < 2e-5, "pixel {x} {y}: {got} for {want}");
            }
            self.compare_counts(i, (first, share));
        }
        let mut regions = [0u64; 4];
        self.tiles.tiles.iter().for_each(|tile| regions[usize::from(tile.region())] += 1);
        assert!(regions.iter().all(|&n| n > 0), "all regions: {regions:?}");
        assert!(mixed[..3].iter().all(|&n| n > 20), "all seams: {mixed:?}");
    }

    /// Stops are those of the levels alone, named by the same Gaussians.
    fn compare_counts(&self, i: usize, (first, share): (usize, f64)) {
        let frame = &self.frame;
        let [stop_2, extra, blended_2] = [0, 1, 2].map(|k| frame.second[k][i]);
        let of = |level: usize| {
            let whole = &self.whole[level];
            let stop = whole.pixels.stop_rank[i];
            let name =
                (stop != NEVER).then(|| self.place(level, whole.splats[stop as usize].index));
            (name, whole.pixels.blended[i])
        };
        let name = |stop: u32| (stop != NEVER).then(|| frame.splats[stop as usize].index);
        let stop_1 = frame.pixels.stop_rank[i];
        let blended_1 = frame.pixels.blended[i];
        if (share as f32) < 1.0 {
            assert_eq!((name(stop_1), blended_1), of(first), "pixel {i}");
        } else {
            assert_eq!((stop_1, blended_1), (0, 0), "pixel {i} shows the second level only");
        }
        if share as f32 > 0.0 {
            let (stop, blended) = of(first + 1);
            assert_eq!(name(stop_2), stop, "pixel {i}");
            assert_eq!(blended_2 + u32::from(stop.is_some()), blended, "pixel {i}");
        } else {
            assert_eq!((stop_2, blended_2), (0, 0), "pixel {i} shows the first level only");
        }
        let both = share as f32 > 0.0 && (share as f32) < 1.0;
        assert_eq!(extra > 0, both && self.list(i, first) > 0, "pixel {i}");
    }

    /// Entries of the list of the tile of a pixel.
    fn list(&self, i: usize, _: usize) -> u32 {
        let (x, y) = (i as u32 % self.camera.width, i as u32 / self.camera.width);
        let grid = &self.tiles.grid;
        self.frame.tiles[grid.index(x / grid.tile, y / grid.tile)].count.entries
    }

    /// The index in level 1 of Gaussian `i` of a level.
    fn place(&self, level: usize, i: u32) -> u32 {
        let mean = self.parts[level].means[i as usize];
        self.parts[0].means.iter().position(|m| *m == mean).expect("nested") as u32
    }
}

#[test]
fn one_pass_equals_every_level_rendered_whole() {
    for (seed, size, gaze) in [
        (1, (160, 120), [0.5, 0.5]),
        (2, (150, 90), [0.1, 0.9]),
        (3, (161, 97), [1.0, 0.0]),
        (4, (97, 130), [0.3, 0.0]),
    ] {
        case(seed, size, gaze, &options()).compare();
    }
}

#[test]
fn levels_of_an_antialiased_model_are_compensated_alike() {
    let mut parts = levels(5, 1500, 1, 0.7);
    for part in &mut parts {
        part.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s -= 1.0);
        part.antialiased = true;
    }
    case_of(parts, (160, 120), [0.5, 0.5], &options()).compare();
}

#[test]
fn other_tiles_show_their_own_levels() {
    for tile in [32, 64] {
        let options = Options { tile, test: Intersection::Aabb, ..options() };
        let parts = levels(9, 800, 1, 0.7);
        let model = Foveated::compose(&parts).expect("nested levels");
        let camera = front_camera(256, 192);
        let frame = render_foveated(&model, &camera, &gaze_at([0.4, 0.5]), &options).expect("x");
        let map = gaze_at([0.4, 0.5]).eccentricity_map([256, 192]).expect("a gaze");
        let tiles = TileLevels::new(&map, TileGrid::new(256, 192, tile));
        let whole: Vec<_> = parts.iter().map(|p| render(p, &camera, &options)).collect();
        for i in 0..256 * 192usize {
            let (x, y) = (i as u32 % 256, i as u32 / 256);
            let first = usize::from(tiles.tiles[tiles.grid.index(x / tile, y / tile)].first);
            let share = tiles.share(x, y);
            for c in 0..3 {
                let at = |k: usize| f64::from(whole[k.min(3)].picture.pixels[i][c]);
                let want = (1.0 - share) * at(first) + share * at(first + 1);
                let got = f64::from(frame.picture.pixels[i][c]);
                assert!((got - want).abs() < 2e-5, "tile {tile}, pixel {x} {y}: {got} {want}");
            }
        }
    }
}

/// Counters by the definitions: every splat against every tile.
#[test]
fn counters_follow_their_definitions() {
    let case = case(5, (160, 120), [0.3, 0.6], &options());
    let (frame, grid) = (&case.frame, case.tiles.grid);
    let (mut lookups, mut tests, mut pairs, mut prepared) = (0, 0, 0, 0);
    let mut by_levels = [0u64; 4];
    for (rank, splat) in frame.splats.iter().enumerate() {
        let cover = Cover::new(splat, grid, Intersection::Obb);
        let area = cover.rect.area();
        let kept = |x: u32, y: u32| {
            let tile = &case.tiles.tiles[grid.index(x, y)];
            (tile.first <= frame.highest[rank]).then_some(tile)
        };
        let rect = cover.rect;
        let all = (rect.y0..rect.y1).flat_map(|y| (rect.x0..rect.x1).map(move |x| (x, y)));
        let passed = all.clone().filter(|&(x, y)| kept(x, y).is_some()).count() as u64;
        let tested = if area > 1 { passed } else { 0 };
        let accepted = |&(x, y): &(u32, u32)| {
            kept(x, y).is_some() && cover.row(y).is_some_and(|r| (r.x0..r.x1).contains(&x))
        };
        let mine: Vec<(u32, u32)> = all.filter(accepted).collect();
        let needed = mine.iter().flat_map(|&(x, y)| {
            let tile = kept(x, y).expect("kept");
            let second = tile.blends && frame.highest[rank] > tile.first;
            [tile.first, tile.first + u8::from(second)]
        });
        (lookups, tests, pairs) = (lookups + area, tests + tested, pairs + mine.len() as u64);
        prepared += u64::from(tested > 1);
        if let (Some(low), Some(high)) = (needed.clone().min(), needed.max())
            && frame.fetches[rank] > 0
        {
            by_levels[usize::from(high - low)] += 1;
        }
    }
    assert_eq!(frame.fovea.lookups, lookups);
    assert_eq!(frame.counters.obb_tests, tests);
    assert_eq!(frame.counters.tile_pairs, pairs);
    assert_eq!(frame.fovea.prepared_published, prepared);
    assert_eq!(frame.fovea.points_by_levels, by_levels);
    assert_eq!(by_levels.iter().sum::<u64>(), frame.counters.fetched_points);
    assert!(by_levels[1] > 0);
}

/// Where all levels are the same, so is the picture, and no seam is seen.
#[test]
fn equal_levels_make_the_plain_picture() {
    let part = levels(6, 1500, 1, 1.0)[0].clone();
    let parts = [part.clone(), part.clone(), part.clone(), part.clone()];
    let model = Foveated::compose(&parts).expect("nested levels");
    let camera = front_camera(160, 120);
    let plain = render(&part, &camera, &options());
    let frame = render_foveated(&model, &camera, &gaze_at([0.5, 0.2]), &options()).expect("a gaze");
    for (a, b) in plain.picture.pixels.iter().zip(&frame.picture.pixels) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-6), "{a:?} {b:?}");
    }
    assert_eq!(frame.splats, plain.splats);
    assert_eq!(frame.counters.tile_pairs, plain.counters.tile_pairs);
}

/// Without counters, splats that no tile shows are left out early: the same bits all the same.
#[test]
fn detail_does_not_change_the_picture() {
    let parts = levels(11, 3000, 1, 0.5);
    let model = Foveated::compose(&parts).expect("nested levels");
    let camera = front_camera(200, 150);
    for gaze in [[0.5, 0.5], [0.0, 1.0]] {
        let frame = |detail| {
            let options = Options { detail, ..options() };
            render_foveated(&model, &camera, &gaze_at(gaze), &options).expect("a gaze")
        };
        let (image, counted) = (frame(Detail::Image), frame(Detail::Counters));
        assert_eq!(image.picture, counted.picture);
        assert!(image.splats.len() < counted.splats.len(), "some are shown nowhere");
        assert_eq!(image.survivor_bits, counted.survivor_bits);
    }
}

#[test]
fn a_gaze_beside_the_picture_is_refused() {
    let model = Foveated::compose(&levels(1, 10, 0, 0.9)).expect("nested levels");
    let camera = front_camera(32, 32);
    for gaze in [[1.000_001, 0.5], [0.5, -f32::MIN_POSITIVE], [f32::NAN, 0.5]] {
        let gaze = ScreenGaze { point: gaze, screen: Screen::PUBLISHED };
        let refused = render_foveated(&model, &camera, &gaze, &options());
        assert!(matches!(refused, Err(GazeError::Gaze { .. })), "{gaze:?}");
    }
}

/// The same bits for any number of threads.
#[test]
fn threads_do_not_show() {
    let model = Foveated::compose(&levels(8, 5000, 1, 0.7)).expect("nested levels");
    let camera = front_camera(200, 150);
    let one = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let frame = render_foveated(&model, &camera, &gaze_at([0.2, 0.7]), &options());
            frame.expect("a gaze").into_frame(&camera, [0.0; 3])
        })
    };
    let frame = one(1);
    frame.check().expect("a trace frame");
    assert_eq!(frame, one(5));
}
