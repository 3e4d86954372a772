//! The rasteriser against its naive twin, and against itself with other threads, tiles and
//! instruction sets.

use fearless_simd::Level;
use powergs_frame::splat::Intersection;
use powergs_frame::splat::project::{colours, inside_frustum};
use powergs_frame::trace::{Frame, NEVER};
use powergs_raster::{Canvas, Detail, Options, render};
use powergs_scene::Camera;
use powergs_testkit::scenes::{front_camera, random_scene};

use super::naive;

#[test]
fn projection_equals_the_twin() {
    let scene = random_scene(1, 3000, 1);
    let camera = front_camera(150, 90);
    let rendered = render(&scene, &camera, &Options::reference(Detail::Image));
    assert!(rendered.splats.len() > 500, "{} visible", rendered.splats.len());
    for splat in &rendered.splats {
        let (depth, mean, cov) = naive::project(&scene, &camera, splat.index as usize);
        assert!((f64::from(splat.depth) - depth).abs() < 1e-5 * depth.max(1.0));
        // Positions far off the image carry f32 rounding in proportion.
        let size = mean[0].abs().max(mean[1].abs()).max(100.0);
        for k in 0..2 {
            assert!((f64::from(splat.mean[k]) - mean[k]).abs() < 2e-5 * size, "{splat:?} {mean:?}");
        }
        let scale = cov[0].max(cov[2]);
        for k in 0..3 {
            assert!((f64::from(splat.cov[k]) - cov[k]).abs() < 3e-5 * scale, "{splat:?} {cov:?}");
        }
    }
}

/// Small splats are spread by the low-pass, and their opacity falls as the area grows; large ones
/// stay as they are.
#[test]
fn opacities_of_an_antialiased_model_equal_the_twin() {
    let mut scene = random_scene(7, 3000, 0);
    scene.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s -= 1.0);
    scene.antialiased = true;
    let camera = front_camera(150, 90);
    let rendered = render(&scene, &camera, &Options::reference(Detail::Image));
    let (mut low, mut high) = (1.0f64, 0.0f64);
    for splat in &rendered.splats {
        let (_, _, [a, b, d]) = naive::project(&scene, &camera, splat.index as usize);
        let own = (a - 0.3) * (d - 0.3) - b * b;
        let factor = (own.max(0.0) / (a * d - b * b)).sqrt();
        let logit = f64::from(scene.logit_opacities[splat.index as usize]);
        let want = factor / (1.0 + (-logit).exp());
        // The twin itself loses the small difference of large numbers of thin splats.
        assert!((f64::from(splat.opacity) - want).abs() < 2e-5, "{splat:?} {want}");
        (low, high) = (low.min(factor), high.max(factor));
    }
    assert!(low < 0.05 && high > 0.9, "{low} to {high}");
}

#[test]
fn survivors_are_those_beyond_the_near_plane() {
    let scene = random_scene(2, 999, 0);
    let camera = front_camera(64, 64);
    let rendered = render(&scene, &camera, &Options::reference(Detail::Counters));
    for i in 0..scene.len() {
        let (depth, ..) = naive::project(&scene, &camera, i);
        if (depth - 0.2).abs() > 1e-5 {
            let bit = rendered.survivor_bits[i / 8] >> (i % 8) & 1;
            assert_eq!(bit == 1, depth > 0.2, "Gaussian {i} at {depth}");
        }
    }
}

#[test]
fn the_frustum_ends_outside_of_the_picture() {
    let scene = random_scene(3, 999, 0);
    let camera = Camera { cx: 20.0, ..front_camera(64, 48) };
    let frame = Canvas::default().frame(&scene, &camera, &Options::reference(Detail::Counters));
    let bits = frame.frustum_bits.expect("rendered frames know it");
    let mut inside = 0;
    for i in 0..scene.len() {
        let (depth, mean, ..) = naive::project(&scene, &camera, i);
        // How far the nearest limit is: of the near plane, in front of it of the picture.
        let beyond = |at: f64, size: f64| (-0.15 * size - at).max(at - 1.15 * size);
        let [x, y] = mean.map(|at| at + 0.5);
        let outside = beyond(x, 64.0).max(beyond(y, 48.0));
        if (depth - 0.2).abs() > 1e-5 && outside.abs() > 1e-3 {
            let bit = bits[i / 8] >> (i % 8) & 1;
            assert_eq!(bit == 1, depth > 0.2 && outside < 0.0, "Gaussian {i} at {x} {y} {depth}");
            inside += u32::from(bit);
        }
    }
    assert!((50..950).contains(&inside), "{inside}");
}

/// Compares every pixel with the twin. Decisions at a threshold may fall the other way where the
/// exact value is within f32 rounding of it: at most a few pixels.
fn check_against_twin(seed: u64, size: (u32, u32), options: &Options) {
    let scene = random_scene(seed, 2500, 2);
    let camera = front_camera(size.0, size.1);
    let rendered = render(&scene, &camera, options);
    let eye = camera.centre.to_array().map(|v| v as f32);
    let colours = colours(&scene, eye, options.level);
    let (mut flips, mut evaluated) = (0, 0u64);
    for ty in 0..size.1.div_ceil(options.tile) {
        for tx in 0..size.0.div_ceil(options.tile) {
            let list: Vec<u32> = (0..rendered.splats.len() as u32)
                .filter(|&r| {
                    naive::accepted(&rendered.splats[r as usize], &camera, options, tx, ty)
                })
                .collect();
            let tile = &rendered.tiles[(ty * size.0.div_ceil(options.tile) + tx) as usize];
            assert_eq!(tile.entries as usize, list.len(), "tile {tx},{ty}");
            let mut most = 0;
            for y in ty * options.tile..((ty + 1) * options.tile).min(size.1) {
                for x in tx * options.tile..((tx + 1) * options.tile).min(size.0) {
                    let want =
                        naive::blend(&list, &rendered.splats, &colours, (x, y), options.background);
                    let i = (y * size.0 + x) as usize;
                    evaluated += 1;
                    most = most.max(want.iterated);
                    let stop = want.stop_rank.unwrap_or(NEVER);
                    let same = rendered.pixels.stop_rank[i] == stop
                        && rendered.pixels.blended[i] == want.blended
                        && rendered.iterated[i] == want.iterated;
                    flips += u32::from(!same);
                    let difference = (0..3)
                        .map(|c| (f64::from(rendered.picture.pixels[i][c]) - want.colour[c]).abs())
                        .fold(0.0, f64::max);
                    // A flipped decision moves a pixel by at most one contribution at a threshold.
                    let bound = if same { 1e-5 } else { 8e-3 };
                    assert!(difference < bound, "pixel {x},{y}: {difference}");
                }
            }
            let batches = most.div_ceil(options.chunk).max(u32::from(!list.is_empty()));
            let loaded = (batches * options.chunk).min(list.len() as u32);
            assert!(tile.loaded == loaded || flips > 0, "T_load of tile {tx},{ty}");
        }
    }
    assert!(u64::from(flips) * 1000 <= evaluated, "{flips} of {evaluated} pixels decide otherwise");
}

#[test]
fn pixels_equal_the_twin() {
    let options = Options { background: [0.3, 0.1, 0.6], ..Options::reference(Detail::Dominance) };
    check_against_twin(3, (150, 90), &options);
    check_against_twin(4, (33, 65), &options);
}

#[test]
fn pixels_equal_the_twin_at_other_tilings() {
    for (tile, chunk, test) in [
        (8, 64, Intersection::Obb),
        (32, 100, Intersection::Obb),
        (64, 256, Intersection::Aabb),
        (16, 16, Intersection::Aabb),
    ] {
        let options = Options { tile, chunk, test, ..Options::reference(Detail::Dominance) };
        check_against_twin(5, (100, 70), &options);
    }
}

#[test]
fn exact_ellipse_lists_give_the_same_image_as_the_square() {
    // The ellipse drops only what cannot reach α = 1/255, so pictures and blends are equal.
    let scene = random_scene(6, 4000, 1);
    let camera = front_camera(160, 120);
    let square = Options { test: Intersection::Aabb, ..Options::reference(Detail::Counters) };
    let exact = Options { test: Intersection::Ellipse, ..square };
    let (a, b) = (render(&scene, &camera, &square), render(&scene, &camera, &exact));
    assert_eq!(a.picture, b.picture);
    assert_eq!(a.pixels, b.pixels);
    assert!(b.counters.tile_pairs * 10 < a.counters.tile_pairs * 9, "it does drop pairs");
}

#[test]
fn hits_are_the_pixels_that_a_splat_is_blended_into() {
    let scene = random_scene(11, 2500, 1);
    let camera = front_camera(150, 90);
    let options = Options::reference(Detail::Hits);
    let rendered = render(&scene, &camera, &options);
    let eye = camera.centre.to_array().map(|v| v as f32);
    let colours = colours(&scene, eye, options.level);
    let mut want = vec![0u32; rendered.splats.len()];
    for y in 0..camera.height {
        for x in 0..camera.width {
            let tile = (x / options.tile, y / options.tile);
            let list: Vec<u32> = (0..want.len() as u32)
                .filter(|&r| {
                    let splat = &rendered.splats[r as usize];
                    naive::accepted(splat, &camera, &options, tile.0, tile.1)
                })
                .collect();
            let pixel = naive::blend(&list, &rendered.splats, &colours, (x, y), [0.0; 3]);
            pixel.hits.iter().for_each(|&rank| want[rank as usize] += 1);
        }
    }
    let off: u32 = rendered.hits.iter().zip(&want).map(|(a, b)| a.abs_diff(*b)).sum();
    let all: u32 = want.iter().sum();
    assert!(all > 20_000 && off * 2000 <= all, "{off} of {all} pixels decide otherwise");
    // Blends of the counters hold the splat that a pixel stops at, and this does not.
    let counted = render(&scene, &camera, &Options::reference(Detail::Counters));
    let stopped = counted.pixels.stop_rank.iter().filter(|&&rank| rank != NEVER).count() as u64;
    let hits: u64 = rendered.hits.iter().map(|&n| u64::from(n)).sum();
    assert_eq!(hits, counted.counters.blends - stopped);
    assert!(stopped > 0 && rendered.picture == counted.picture);
    // Weights add up to what the background does not show.
    let black = render(&scene, &camera, &Options::reference(Detail::Dominance));
    let white = render(
        &scene,
        &camera,
        &Options { background: [1.0; 3], ..Options::reference(Detail::Image) },
    );
    let covered = |(a, b): (&[f32; 3], &[f32; 3])| 1.0 - f64::from(b[0] - a[0]);
    let pixels = black.picture.pixels.iter().zip(&white.picture.pixels);
    let (weights, covered) = (black.weights.iter().sum::<f64>(), pixels.map(covered).sum::<f64>());
    assert!((weights / covered - 1.0).abs() < 1e-3, "{weights} of {covered}");
    assert_eq!(black.weights.len(), rendered.splats.len());
}

#[test]
fn threads_do_not_matter() {
    let scene = random_scene(7, 20_000, 3);
    let camera = front_camera(320, 200);
    let options = Options::reference(Detail::Dominance);
    let render_with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| render(&scene, &camera, &options))
    };
    let (one, five) = (render_with(1), render_with(5));
    assert_eq!(one.picture, five.picture);
    assert_eq!(one.splats, five.splats);
    assert_eq!(one.pixels, five.pixels);
    assert_eq!((one.counters, one.fetches), (five.counters, five.fetches));
    assert_eq!(one.dominance, five.dominance);
}

#[test]
fn frames_before_do_not_matter() {
    let mut hidden = random_scene(10, 50, 0);
    hidden.means.iter_mut().for_each(|m| m[2] = -5.0);
    let scenes = [
        random_scene(7, 9_000, 3),
        random_scene(8, 300, 0),
        random_scene(9, 3000, 1),
        hidden,
        random_scene(8, 0, 0),
    ];
    let details = [Detail::Dominance, Detail::Image, Detail::Counters, Detail::Hits];
    let cameras = [(320, 200), (33, 97), (150, 16)].map(|(w, h)| front_camera(w, h));
    let mut canvas = Canvas::new();
    for i in 0..60 {
        let (scene, camera) = (&scenes[i % 5], &cameras[i / 2 % 3]);
        let options = Options {
            tile: [16, 32, 8][i / 5 % 3],
            chunk: [256, 1, 16][i / 3 % 3],
            test: [Intersection::Obb, Intersection::Ellipse, Intersection::Aabb][i / 4 % 3],
            ..Options::reference(details[i * 7 / 3 % 4])
        };
        let fresh = format!("{:?}", render(scene, camera, &options));
        assert!(format!("{:?}", canvas.render(scene, camera, &options)) == fresh, "frame {i}");
        if i % 4 == 1 {
            let counted = Options::reference(Detail::Counters);
            let frame = render(scene, camera, &counted).into_frame(camera, [0.0; 3]);
            let frustum_bits = Some(inside_frustum(scene, camera));
            let frame = Frame { frustum_bits, ..frame };
            assert!(canvas.frame(scene, camera, &counted) == frame, "frame {i}");
        }
    }
}

#[test]
fn detail_does_not_change_the_image() {
    let scene = random_scene(8, 3000, 0);
    let camera = front_camera(97, 61);
    let image = render(&scene, &camera, &Options::reference(Detail::Image));
    let counters = render(&scene, &camera, &Options::reference(Detail::Counters));
    let dominance = render(&scene, &camera, &Options::reference(Detail::Dominance));
    assert_eq!(image.picture, counters.picture);
    assert_eq!(image.picture, dominance.picture);
    assert_eq!(counters.counters, dominance.counters);
    let owned: u64 = dominance.dominance.iter().map(|&n| u64::from(n)).sum();
    let lit = dominance.picture.pixels.iter().filter(|p| p.iter().any(|&c| c > 0.0)).count();
    assert!(owned >= lit as u64, "every lit pixel has an owner");
}

#[test]
fn instruction_sets_agree() {
    let scene = random_scene(9, 3000, 3);
    let camera = front_camera(97, 61);
    let best = render(&scene, &camera, &Options::reference(Detail::Counters));
    let plain = Options { level: Level::baseline(), ..Options::reference(Detail::Counters) };
    let base = render(&scene, &camera, &plain);
    let worst = best
        .picture
        .pixels
        .iter()
        .zip(&base.picture.pixels)
        .flat_map(|(a, b)| (0..3).map(move |c| (a[c] - b[c]).abs()))
        .fold(0.0f32, f32::max);
    // Fused multiply-add rounds once where the baseline rounds twice.
    assert!(worst < 1e-2, "{worst}");
    let mean: f32 = best
        .picture
        .pixels
        .iter()
        .zip(&base.picture.pixels)
        .map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f32>())
        .sum::<f32>()
        / (3 * best.picture.pixels.len()) as f32;
    assert!(mean < 2e-6, "{mean}");
}

#[test]
fn nothing_visible_is_background() {
    let mut scene = random_scene(10, 50, 0);
    scene.means.iter_mut().for_each(|m| m[2] = -5.0);
    let options = Options { background: [0.25, 0.5, 1.0], ..Options::reference(Detail::Counters) };
    let rendered = render(&scene, &front_camera(20, 20), &options);
    assert!(rendered.picture.pixels.iter().all(|&p| p == options.background));
    assert_eq!(rendered.counters.survivors, 0);
    assert_eq!(rendered.counters.tile_loads, 0);
}
