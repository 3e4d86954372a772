//! Pruning against a brute-force count over pixels.

use powergs_core::workload::{Geometry, bin};
use powergs_frame::splat::{ALPHA_MAX, ALPHA_MIN, TRANSMITTANCE_MIN};
use powergs_optimize::prune::{Score, select, survivors};
use powergs_raster::{Detail, Options, render};
use powergs_scene::Camera;

use super::scenes::tiny;

/// Dominance per fetching tile of every Gaussian, one pixel after the other.
fn brute(scene: &powergs_scene::Gaussians, cameras: &[Camera]) -> Vec<f64> {
    let mut best = vec![0.0f64; scene.len()];
    for camera in cameras {
        let rendered = render(scene, camera, &Options::reference(Detail::Counters));
        let frame = rendered.into_frame(camera, [0.0; 3]);
        let work = bin(&frame, Geometry::REFERENCE);
        let (mut tiles, mut pixels) = (vec![0u32; scene.len()], vec![0u32; scene.len()]);
        for (t, tile) in work.tiles.iter().enumerate() {
            let list = work.list_of(tile);
            for &rank in &list[..tile.loaded as usize] {
                tiles[frame.splats[rank as usize].index as usize] += 1;
            }
            let (tx, ty) = (t as u32 % work.tiles_x * 16, t as u32 / work.tiles_x * 16);
            for y in ty..(ty + 16).min(camera.height) {
                for x in tx..(tx + 16).min(camera.width) {
                    let (mut through, mut most, mut heaviest) = (1.0f32, 0.0f32, None);
                    for &rank in list {
                        let splat = &frame.splats[rank as usize];
                        let [c0, c1, c2] = splat.conic().unwrap();
                        let (dx, dy) = (splat.mean[0] - x as f32, splat.mean[1] - y as f32);
                        let power = -0.5 * (c0 * dx * dx + c2 * dy * dy) - c1 * dx * dy;
                        let alpha = ALPHA_MAX.min(splat.opacity * power.exp());
                        if power > 0.0 || alpha < ALPHA_MIN as f32 {
                            continue;
                        }
                        let left = through * (1.0 - alpha);
                        if left < TRANSMITTANCE_MIN {
                            break;
                        }
                        if alpha * through > most {
                            (most, heaviest) = (alpha * through, Some(splat.index));
                        }
                        through = left;
                    }
                    if let Some(index) = heaviest {
                        pixels[index as usize] += 1;
                    }
                }
            }
        }
        for (i, best) in best.iter_mut().enumerate() {
            if tiles[i] > 0 {
                *best = best.max(f64::from(pixels[i]) / (f64::from(tiles[i]) + 1e-7));
            }
        }
    }
    best
}

#[test]
fn dominance_is_what_a_count_over_pixels_gives() {
    let mut tiny = tiny(1_500, 8, (142, 106));
    // So few Gaussians are made so large that one hides all others.
    tiny.dense.log_scales.iter_mut().flatten().for_each(|s| *s -= 2.0);
    let expected = brute(&tiny.dense, &tiny.cameras);
    let got = Score::Dominance.of(&tiny.dense, &tiny.cameras);
    // What is nowhere the heaviest has a score below zero, in place of zero.
    let differs = |(g, e): &(&f64, &f64)| (g.max(0.0) - **e).abs() > 1e-9;
    let wrong = got.iter().zip(&expected).filter(differs).count();
    // Two splats that weigh the same to the last bit of an exponential may change places.
    assert!(wrong <= 6, "{wrong} of {} differ", got.len());
    let dominant = expected.iter().filter(|e| **e > 0.0).count();
    assert!(dominant > 100, "{dominant} dominate: too few to say anything");
}

#[test]
fn empty_pixels_count_for_nobody() {
    let mut tiny = tiny(50, 24, (64, 48));
    // Everything behind the camera: all pixels are empty.
    let away = tiny.cameras[0].centre - 10.0 * tiny.cameras[0].forward();
    for mean in &mut tiny.dense.means {
        *mean = away.as_vec3().to_array();
    }
    assert_eq!(Score::Dominance.of(&tiny.dense, &tiny.cameras[..1]), vec![-1.0; 50]);
}

#[test]
fn what_is_nowhere_the_heaviest_goes_by_how_much_of_it_is_blended() {
    // Three of a kind behind a fourth that hides them: one of them larger, one out of sight.
    let mut tiny = tiny(4, 24, (64, 48));
    let camera = &tiny.cameras[0];
    let before = camera.centre + 5.0 * camera.forward();
    for i in 0..4 {
        tiny.dense.means[i] = (before + 0.01 * i as f64 * camera.forward()).as_vec3().to_array();
        tiny.dense.logit_opacities[i] = if i == 0 { 2.0 } else { 0.0 };
        tiny.dense.log_scales[i] = [if i == 0 { 1.0 } else { -1.0 - i as f32 }; 3];
    }
    tiny.dense.means[3] = (camera.centre - 10.0 * camera.forward()).as_vec3().to_array();
    let score = Score::Dominance.of(&tiny.dense, &tiny.cameras[..1]);
    assert!(score[0] > 0.0, "{score:?}");
    assert!(
        score[3] == -1.0 && score[2] > -1.0 && score[1] > score[2] && score[1] < 0.0,
        "{score:?}"
    );
    assert_eq!(survivors(&score, 2), [0, 1]);
}

#[test]
fn scores_do_not_depend_on_threads() {
    let tiny = tiny(400, 6, (64, 48));
    for score in [Score::Dominance, Score::LightGaussian] {
        let on = |n: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| score.of(&tiny.dense, &tiny.cameras))
        };
        assert_eq!(on(1), on(3), "{score:?}");
    }
}

#[test]
fn the_least_goes_first_and_ties_go_by_index() {
    assert_eq!(survivors(&[3.0, 0.0, 0.0, 1.0, 0.0], 2), [0, 3, 4]);
    assert_eq!(survivors(&[0.0; 5], 3), [3, 4]);
    assert_eq!(survivors(&[2.0, 1.0], 0), [0, 1]);
    assert_eq!(survivors(&[2.0, 1.0], 9), [0], "one is always left");
    assert!(survivors(&[], 1).is_empty());
}

#[test]
fn a_large_faint_gaussian_outscores_a_small_faint_one() {
    // The volume term of LightGaussian's score.
    let mut tiny = tiny(200, 24, (64, 48));
    let target = tiny.dense.means[0];
    for i in 1..3 {
        tiny.dense.means[i] = target;
        tiny.dense.rotations[i] = tiny.dense.rotations[0];
        tiny.dense.logit_opacities[i] = -2.0;
        tiny.dense.log_scales[i] = [if i == 1 { -3.0 } else { -5.0 }; 3];
    }
    let score = Score::LightGaussian.of(&tiny.dense, &tiny.cameras);
    assert!(score[1] > 4.0 * score[2], "{} and {}", score[1], score[2]);
}

#[test]
fn selecting_keeps_every_list_in_step() {
    let mut scene = tiny(30, 24, (16, 12)).dense;
    let whole = scene.clone();
    select(&mut scene, &[1, 5, 29]);
    assert_eq!(scene.len(), 3);
    assert_eq!(scene.sh.len(), 3 * 48);
    for (to, from) in [1, 5, 29].into_iter().enumerate() {
        assert_eq!(scene.means[to], whole.means[from]);
        assert_eq!(scene.sh_of(to), whole.sh_of(from));
    }
}
