//! Gradients against frozen references and against themselves.

use fearless_simd::{Level, dispatch};
use powergs_frame::splat::Intersection;
use powergs_frame::splat::project::{LANES, View, may_see};
use powergs_raster::train::{Clamp, Gradients, Options, Tape, Which};
use powergs_raster::{Detail, render};
use powergs_scene::{Camera, Gaussians};
use powergs_testkit::scenes::{camera, floats, front_camera, load, random_scene, rows};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

use super::gradient_naive::{BEFORE_SH, Twin};

/// `[coefficient][channel]` per Gaussian to `[channel][coefficient]`.
fn channel_major(sh: &[f64]) -> Vec<f32> {
    sh.chunks(48)
        .flat_map(|g| (0..3).flat_map(move |c| (0..16).map(move |k| g[k * 3 + c] as f32)))
        .collect()
}

fn reference(case: &Value) -> (Gaussians, Camera, Options) {
    let scene = Gaussians {
        means: rows(&case["means"]),
        log_scales: rows(&case["log_scales"]),
        rotations: rows(&case["quats_raw"]),
        logit_opacities: rows::<1>(&case["logit_opacity"]).into_flattened(),
        sh_degree: 3,
        sh: channel_major(&floats(&case["sh"])),
        antialiased: false,
    };
    let tan = ["tanfovx", "tanfovy"].map(|k| case[k].as_f64().unwrap());
    let size = ["W", "H"].map(|k| case[k].as_u64().unwrap() as u32);
    let camera = camera(size[0], size[1], tan, &floats(&case["view"]));
    let background = rows::<3>(&case["bg"])[0];
    (scene, camera, Options { background, ..Options::reference() })
}

/// Planes of red, green and blue to pixels.
fn pixels(planes: &Value) -> Vec<[f32; 3]> {
    let values = floats(planes);
    let n = values.len() / 3;
    (0..n).map(|i| std::array::from_fn(|c| values[c * n + i] as f32)).collect()
}

#[test]
fn reference_gradients_match() {
    for case in load("raster_gradients.json")["cases"].as_array().unwrap() {
        let (scene, camera, options) = reference(case);
        let weights = pixels(&case["loss_weights"]);
        let mut tape = Tape::new();
        let picture = tape.forward(&scene, &camera, &options);
        let image = pixels(&case["image"]);
        let loss: f64 = picture
            .pixels
            .as_flattened()
            .iter()
            .zip(weights.as_flattened())
            .map(|(p, w)| f64::from(*p) * f64::from(*w))
            .sum();
        for (got, want) in picture.pixels.as_flattened().iter().zip(image.as_flattened()) {
            assert!((got - want).abs() < 2e-5, "{got} {want}");
        }
        assert!((loss - case["loss"].as_f64().unwrap()).abs() < 1e-3, "{loss}");
        let mut gradients = Gradients::new();
        tape.backward(&scene, &weights, Which::All, &mut gradients);
        let expected = &case["grad"];
        let sh: Vec<f32> = channel_major(&floats(&expected["sh"]));
        let want = ["means", "log_scales", "quats_raw", "logit_opacity"]
            .map(|k| rows::<1>(&expected[k]).into_flattened());
        let names = ["means", "log_scales", "quats_raw", "logit_opacity", "sh"];
        for (name, (got, want)) in
            names.iter().zip(gradients.flat().iter().zip(want.iter().chain([&sh])))
        {
            let largest = want.iter().fold(0.0f32, |a, b| a.max(b.abs()));
            let worst =
                got.iter().zip(want).map(|(a, b)| (a - b).abs()).fold(0.0f32, f32::max) / largest;
            eprintln!("{name}: {worst:e}");
            assert_eq!(got.len(), want.len());
            // Single against double precision; the reference asks for 1e-3.
            assert!(worst < 1e-4, "{name}: {worst}");
        }
    }
}

/// Numbers between −1 and 1, one per channel.
fn random_weights(seed: u64, pixels: usize) -> Vec<[f32; 3]> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    (0..pixels).map(|_| std::array::from_fn(|_| rng.random_range(-1.0f32..1.0))).collect()
}

fn gradients_of(
    scene: &Gaussians,
    camera: &Camera,
    options: &Options,
    weights: &[[f32; 3]],
    which: Which,
) -> Gradients {
    let (mut tape, mut out) = (Tape::new(), Gradients::new());
    tape.forward(scene, camera, options);
    tape.backward(scene, weights, which, &mut out);
    out
}

/// The gradient of Gaussian `i` by its parameter `k`, counted as in the twin.
fn entry(g: &Gradients, n: usize, i: usize, k: usize) -> f32 {
    match k {
        0..3 => g.means[i][k],
        3..6 => g.log_scales[i][k - 3],
        6..10 => g.rotations[i][k - 6],
        10 => g.logit_opacities[i],
        _ => g.sh[i * n + k - BEFORE_SH],
    }
}

/// Compares a sample of all parameters with the twin, kind by kind.
fn check_against_twin(seed: u64, degree: u8, size: (u32, u32), options: &Options) {
    compare_with_twin(&random_scene(seed, 160, degree), seed, size, options);
}

fn compare_with_twin(scene: &Gaussians, seed: u64, size: (u32, u32), options: &Options) {
    let degree = scene.sh_degree;
    let camera = front_camera(size.0, size.1);
    let weights = random_weights(seed, (size.0 * size.1) as usize);
    let mut tape = Tape::new();
    tape.forward(scene, &camera, options);
    let mut got = Gradients::new();
    tape.backward(scene, &weights, Which::All, &mut got);
    let twin = Twin::new(scene, &camera, options, tape.splats());
    let n = 3 * scene.sh_coefficients();
    // Kinds: mean, log-scale, quaternion, opacity, constant SH, other SH.
    let mut sums = [[0.0f64; 5]; 6];
    for (rank, splat) in tape.splats().iter().enumerate() {
        for k in (rank % 3..BEFORE_SH + n).step_by(3) {
            let kind = match k {
                0..3 => 0,
                3..6 => 1,
                6..10 => 2,
                10 => 3,
                k if (k - BEFORE_SH).is_multiple_of(n / 3) => 4,
                _ => 5,
            };
            let want = twin.derivative(rank, k, &weights);
            let got = f64::from(entry(&got, n, splat.index as usize, k));
            let all = [(got - want).abs(), want.abs(), got * want, got * got, want * want];
            sums[kind].iter_mut().zip(all).for_each(|(sum, v)| *sum += v);
        }
    }
    let kinds = if degree == 0 { 5 } else { 6 };
    for (kind, [difference, size, dot, a, b]) in sums.into_iter().enumerate().take(kinds) {
        eprintln!("kind {kind}: {:e} {:e}", difference / size, 1.0 - dot / (a * b).sqrt());
        assert!(size > 0.1, "kind {kind} is tested");
        // Single precision, with room for a pixel that decides otherwise at a threshold.
        assert!(difference <= 1e-4 * size, "kind {kind}: {difference} of {size}");
        assert!(dot >= 0.9999 * (a * b).sqrt(), "kind {kind}: direction");
    }
}

#[test]
fn gradients_equal_the_twin() {
    let options = Options { background: [0.3, 0.8, 0.1], ..Options::reference() };
    check_against_twin(21, 3, (45, 37), &options);
    check_against_twin(22, 2, (45, 37), &options);
    check_against_twin(23, 1, (33, 20), &Options { clamp: Clamp::PassThrough, ..options });
    check_against_twin(24, 0, (16, 40), &Options { test: Intersection::Aabb, ..options });
}

/// Small splats lose most of their opacity to the low-pass, so that all kinds of parameters but the
/// colours have a part of the gradient that goes through the compensation.
#[test]
fn gradients_of_an_antialiased_model_equal_the_twin() {
    for (seed, shrink) in [(25, 0.0), (26, 1.0)] {
        let mut scene = random_scene(seed, 160, 1);
        scene.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s -= shrink);
        scene.antialiased = true;
        compare_with_twin(&scene, seed, (45, 37), &Options::reference());
    }
}

/// Moves one kind of parameter (0 to 4) of all Gaussians by `step` along `direction`.
fn moved(scene: &Gaussians, kind: usize, direction: &[f32], step: f32) -> Gaussians {
    let mut scene = scene.clone();
    let values = match kind {
        0 => scene.means.as_flattened_mut(),
        1 => scene.log_scales.as_flattened_mut(),
        2 => scene.rotations.as_flattened_mut(),
        3 => &mut scene.logit_opacities,
        _ => &mut scene.sh,
    };
    values.iter_mut().zip(direction).for_each(|(v, d)| *v += step * d);
    scene
}

#[test]
fn finite_differences_agree() {
    // The loss is nonlinear: half the squared distance to grey.
    let camera = front_camera(60, 44);
    let options = Options { background: [0.2, 0.4, 0.3], ..Options::reference() };
    let mut scene = random_scene(31, 150, 3);
    scene.logit_opacities.iter_mut().for_each(|o| *o = o.clamp(-2.0, 2.0));
    let loss = |scene: &Gaussians| -> f64 {
        let mut tape = Tape::new();
        let picture = tape.forward(scene, &camera, &options);
        picture.pixels.as_flattened().iter().map(|v| 0.5 * (f64::from(*v) - 0.5).powi(2)).sum()
    };
    let mut tape = Tape::new();
    let picture = tape.forward(&scene, &camera, &options);
    let by_pixel: Vec<[f32; 3]> = picture.pixels.iter().map(|p| p.map(|v| v - 0.5)).collect();
    let mut gradients = Gradients::new();
    tape.backward(&scene, &by_pixel, Which::All, &mut gradients);
    let mut rng = Pcg64Mcg::seed_from_u64(32);
    for (kind, gradient) in gradients.flat().into_iter().enumerate() {
        // Up the gradient with some noise, so that the slope is not a small difference of large
        // numbers and the order of a list is not the only thing that is seen.
        let length = gradient.iter().map(|g| g * g).sum::<f32>().sqrt();
        let direction: Vec<f32> =
            gradient.iter().map(|g| g / length + rng.random_range(-0.03f32..0.03)).collect();
        let step = 2e-3;
        let slope = (loss(&moved(&scene, kind, &direction, step))
            - loss(&moved(&scene, kind, &direction, -step)))
            / (2.0 * f64::from(step));
        let want: f64 =
            gradient.iter().zip(&direction).map(|(g, d)| f64::from(*g) * f64::from(*d)).sum();
        eprintln!("kind {kind}: {slope} {want}");
        // A splat that grows also reaches new pixels, where α jumps from 0 to 1/255: a slope that
        // the gradient takes for zero (thresholds are constants). The twin has no such part.
        assert!((slope - want).abs() < 0.05 * want.abs(), "kind {kind}: {slope} against {want}");
    }
}

#[test]
fn the_picture_is_that_of_the_forward_rasteriser() {
    let scene = random_scene(41, 3000, 2);
    for size in [(97, 61), (16, 16), (1, 1), (250, 3)] {
        let camera = front_camera(size.0, size.1);
        let background = [0.1, 0.2, 0.9];
        let plain = powergs_raster::Options {
            background,
            ..powergs_raster::Options::reference(Detail::Image)
        };
        let mut tape = Tape::new();
        tape.forward(&scene, &camera, &Options { background, ..Options::reference() });
        let rendered = render(&scene, &camera, &plain);
        assert_eq!(tape.picture(), &rendered.picture);
        assert_eq!(tape.splats(), rendered.splats);
    }
}

fn bits(g: &Gradients) -> Vec<u32> {
    g.flat().iter().flat_map(|list| list.iter().map(|v| v.to_bits())).collect()
}

#[test]
fn threads_do_not_matter() {
    let scene = random_scene(42, 20_000, 3);
    let camera = front_camera(320, 200);
    let weights = random_weights(42, 320 * 200);
    for which in [Which::All, Which::ColourAndOpacity] {
        let with = |n: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            let options = Options::reference();
            pool.install(|| gradients_of(&scene, &camera, &options, &weights, which))
        };
        let (one, two, five) = (with(1), with(2), with(5));
        assert!(bits(&one).iter().any(|&b| b != 0));
        assert_eq!(bits(&one), bits(&two));
        assert_eq!(bits(&one), bits(&five));
    }
}

#[test]
fn a_used_tape_is_as_good_as_a_new_one() {
    let options = Options::reference();
    let (mut tape, mut out) = (Tape::new(), Gradients::new());
    for (seed, n, size) in [(51, 2000, (120, 80)), (52, 300, (50, 90)), (53, 4000, (64, 64))] {
        let scene = random_scene(seed, n, (seed % 4) as u8);
        let camera = front_camera(size.0, size.1);
        let weights = random_weights(seed, (size.0 * size.1) as usize);
        tape.forward(&scene, &camera, &options);
        tape.backward(&scene, &weights, Which::All, &mut out);
        assert_eq!(out, gradients_of(&scene, &camera, &options, &weights, Which::All));
        // And the same view can be differentiated again.
        tape.backward(&scene, &weights, Which::All, &mut out);
        assert_eq!(out, gradients_of(&scene, &camera, &options, &weights, Which::All));
    }
}

#[test]
fn colour_and_opacity_alone_are_those_of_all() {
    let scene = random_scene(43, 2000, 2);
    let camera = front_camera(120, 80);
    let weights = random_weights(43, 120 * 80);
    let options = Options::reference();
    let all = gradients_of(&scene, &camera, &options, &weights, Which::All);
    let some = gradients_of(&scene, &camera, &options, &weights, Which::ColourAndOpacity);
    assert_eq!(some.means, vec![[0.0; 3]; scene.len()]);
    assert_eq!(some.log_scales, vec![[0.0; 3]; scene.len()]);
    assert_eq!(some.rotations, vec![[0.0; 4]; scene.len()]);
    let close = |a: f32, b: f32| (a - b).abs() <= 1e-5 * (a.abs() + 1e-2);
    for (a, b) in all.logit_opacities.iter().zip(&some.logit_opacities) {
        // Other orders of the same sums.
        assert!(close(*a, *b), "{a} {b}");
    }
    let n = scene.sh_coefficients();
    for (k, (a, b)) in all.sh.iter().zip(&some.sh).enumerate() {
        assert!(if k % n == 0 { close(*a, *b) } else { *b == 0.0 }, "{k}: {a} {b}");
    }
    assert!(some.sh.iter().any(|&v| v != 0.0));
}

#[test]
fn instruction_sets_agree() {
    let scene = random_scene(44, 2000, 3);
    let camera = front_camera(97, 61);
    let weights = random_weights(44, 97 * 61);
    let best = Options::reference();
    let plain = Options { level: Level::baseline(), ..best };
    let a = gradients_of(&scene, &camera, &best, &weights, Which::All);
    let b = gradients_of(&scene, &camera, &plain, &weights, Which::All);
    for (a, b) in a.flat().iter().zip(b.flat()) {
        let difference: f32 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
        let size: f32 = a.iter().map(|a| a.abs()).sum();
        // Fused multiply-add rounds once where the baseline rounds twice.
        assert!(difference < 1e-3 * size, "{difference} of {size}");
    }
}

#[test]
fn degenerate_gaussians_have_finite_gradients() {
    let mut scene = random_scene(45, 64, 3);
    for i in 0..64 {
        scene.means[i] = [0.01 * i as f32 - 0.3, 0.0, 2.0];
        match i % 8 {
            0 => scene.log_scales[i] = [-1000.0; 3],
            1 => scene.log_scales[i] = [f32::NEG_INFINITY; 3],
            2 => scene.rotations[i] = [0.0; 4],
            3 => scene.means[i][2] = -3.0,
            4 => scene.log_scales[i] = [10.0, -10.0, -10.0],
            5 => scene.logit_opacities[i] = 90.0,
            6 => scene.logit_opacities[i] = -90.0,
            _ => scene.means[i] = [0.0, 0.0, -0.1],
        }
    }
    let camera = front_camera(40, 40);
    let weights = random_weights(45, 1600);
    let got = gradients_of(&scene, &camera, &Options::reference(), &weights, Which::All);
    for list in got.flat() {
        assert!(list.iter().all(|v| v.is_finite()));
    }
    for i in (0..64).filter(|i| matches!(i % 8, 2 | 3 | 7)) {
        let zero = got.means[i] == [0.0; 3] && got.rotations[i] == [0.0; 4];
        assert!(zero && got.logit_opacities[i] == 0.0, "{i} is not seen");
    }
    assert!(got.means.iter().flatten().any(|&v| v != 0.0));
}

#[test]
fn nothing_visible_has_no_gradient() {
    let mut scene = random_scene(46, 50, 1);
    scene.means.iter_mut().for_each(|m| m[2] = -5.0);
    let options = Options { background: [0.25, 0.5, 1.0], ..Options::reference() };
    let weights = random_weights(46, 400);
    let got = gradients_of(&scene, &front_camera(20, 20), &options, &weights, Which::All);
    assert!(got.flat().iter().all(|list| list.iter().all(|&v| v == 0.0)));
    assert_eq!(got.sh.len(), scene.sh.len());
    let empty = Gaussians::default();
    let none = gradients_of(&empty, &front_camera(20, 20), &options, &weights, Which::All);
    assert!(none.means.is_empty());
}

#[test]
fn a_channel_clamped_to_black_has_no_colour_gradient() {
    let mut scene = random_scene(47, 1, 1);
    scene.means[0] = [0.0, 0.0, 2.0];
    scene.log_scales[0] = [-1.5; 3];
    scene.logit_opacities[0] = 1.0;
    scene.sh = vec![0.0; 12];
    scene.sh[4] = -5.0;
    scene.sh[8] = 0.3;
    let weights = vec![[1.0; 3]; 1024];
    let got =
        gradients_of(&scene, &front_camera(32, 32), &Options::reference(), &weights, Which::All);
    assert!(got.sh[0] > 0.1 && got.sh[8] > 0.1, "{:?}", got.sh);
    assert_eq!(got.sh[4..8], [0.0; 4]);
}

#[test]
fn the_clamp_of_alpha_has_two_gradients() {
    // One splat in one pixel with α = 0.99: no gradient, or that of the unclamped product.
    let mut scene = random_scene(48, 1, 0);
    scene.means[0] = [-0.02, 0.03, 1.9];
    scene.log_scales[0] = [0.0; 3];
    scene.logit_opacities[0] = 6.0;
    scene.sh = vec![1.0; 3];
    let weights = vec![[1.0; 3]; 1];
    let of = |clamp| {
        let options = Options { clamp, ..Options::reference() };
        let got = gradients_of(&scene, &front_camera(1, 1), &options, &weights, Which::All);
        (got.logit_opacities[0], got.sh[0])
    };
    let (exact, pass) = (of(Clamp::Exact), of(Clamp::PassThrough));
    assert_eq!(exact.0, 0.0);
    let opacity = 1.0 / (1.0 + (-6.0f32).exp());
    let colour = 3.0 * (0.5 + 0.282_094_8);
    // s is α T g·c with the clamped α: the published rule.
    let want = 0.99 * (1.0 - opacity) * colour;
    assert!((pass.0 - want).abs() < 1e-3 * want, "{} {want}", pass.0);
    assert_eq!(exact.1, pass.1);
}

/// Whoever trains lets those catch up that may be seen: none of those that are seen is missing.
#[test]
fn whoever_is_seen_may_be_seen() {
    let (mut seen, mut others) = (0, 0);
    for seed in 0..6 {
        let scene = random_scene(seed, 3000, 1);
        let camera = front_camera(200, 120);
        let view = View::new(&camera);
        let rendered = render(&scene, &camera, &powergs_raster::Options::reference(Detail::Image));
        let mut may = vec![false; scene.len()];
        for first in (0..scene.len()).step_by(LANES) {
            let range = first..(first + LANES).min(scene.len());
            let (means, scales) = (&scene.means[range.clone()], &scene.log_scales[range.clone()]);
            let bits = dispatch!(Level::new(), simd => may_see(simd, &view, means, scales));
            for i in range {
                may[i] = bits >> (i - first) & 1 == 1;
            }
        }
        assert!(rendered.splats.iter().all(|splat| may[splat.index as usize]));
        seen += rendered.splats.len();
        others += may.iter().filter(|&&m| !m).count();
    }
    assert!(seen > 100 && others > 100, "{seen} seen, {others} out of sight");
}

#[test]
fn gradients_by_centres_are_those_of_a_shifted_picture() {
    let mut scene = random_scene(17, 60, 1);
    // In the picture: beyond its edge covariances depend on the principal point, too.
    for [x, y, z] in &mut scene.means {
        *z = z.max(1.0);
        (*x, *y) = (x.clamp(-0.3 * *z, 0.3 * *z), y.clamp(-0.3 * *z, 0.3 * *z));
    }
    let camera = front_camera(64, 48);
    // A ramp: the slope is large beside the steps of α at 1/255, which gradients leave out.
    let ramp = |i: usize| ((i % 64) as f32 / 64.0 + 2.0 * (i / 64) as f32 / 48.0).powi(2);
    let weights: Vec<[f32; 3]> = (0..64 * 48).map(|i| [ramp(i); 3]).collect();
    let mut tape = Tape::new();
    let options = Options { clamp: Clamp::Exact, ..Options::reference() };
    let mut loss = |camera: &Camera| -> f64 {
        let picture = tape.forward(&scene, camera, &options);
        let pairs = picture.pixels.as_flattened().iter().zip(weights.as_flattened());
        pairs.map(|(p, w)| f64::from(*p) * f64::from(*w)).sum()
    };
    // All centres move with the principal point, and nothing else does.
    let step = 2e-3;
    let differences = [[step, 0.0], [0.0, step]].map(|[x, y]| {
        let at = |sign: f64| {
            let (cx, cy) = (camera.cx + sign * x, camera.cy + sign * y);
            Camera { cx, cy, ..camera.clone() }
        };
        (loss(&at(1.0)) - loss(&at(-1.0))) / (2.0 * step)
    });
    loss(&camera);
    let slopes = tape.slopes(&weights, Which::All);
    let mut sums = [0.0; 2];
    for (splat, slope) in slopes.by_centre() {
        assert!(slopes.is_seen(splat.index as usize));
        sums.iter_mut().zip(slope).for_each(|(sum, s)| *sum += f64::from(s));
    }
    for (sum, difference) in sums.into_iter().zip(differences) {
        let scale = difference.abs().max(1.0);
        assert!((sum - difference).abs() < 0.05 * scale, "{sums:?} {differences:?}");
    }
}
