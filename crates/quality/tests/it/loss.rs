//! The training loss and L1, PSNR, SSIM.

use approx::assert_relative_eq;
use powergs_base::picture::Picture;
use powergs_frame::display::Display;
use powergs_quality::{Loss, likeness};
use powergs_testkit::display::{linear_slope, mean_linear};
use serde_json::Value;

use super::pictures::{display, from_planes, noisy, numbers, on_threads, shown};

fn evaluate(picture: &Picture, reference: &Picture, lambda: f64) -> (f64, Vec<[f32; 3]>) {
    let mut gradient = vec![[f32::NAN; 3]; picture.pixels.len()];
    let parts = Loss::new(picture.width, picture.height).evaluate(
        picture,
        reference,
        lambda,
        &display("oled-powergs"),
        &mut gradient,
    );
    (parts.total, gradient)
}

/// Published code in double precision. The loss is a mean of 960 values in single precision: 1e-6;
/// the gradient is compared in units of its largest entry: 2e-5.
#[test]
fn the_published_loss_and_gradient() {
    let text =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/ssim_psnr.json"));
    let case = &serde_json::from_str::<Value>(text).expect("JSON")["loss_grad"];
    let picture = from_planes(&case["shape"], &case["image"]);
    let reference = from_planes(&case["shape"], &case["gt"]);
    let (total, gradient) = evaluate(&picture, &reference, 0.0);
    assert_relative_eq!(total, case["loss"].as_f64().unwrap(), max_relative = 1e-6);
    let ssim = likeness(&picture, &reference).ssim;
    assert_relative_eq!(ssim, case["ssim"].as_f64().unwrap(), max_relative = 1e-6);
    let expected = numbers(&case["grad"]);
    let largest = expected.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    let n = gradient.len();
    for (i, e) in expected.iter().enumerate() {
        let got = f64::from(gradient[i % n][i / n]);
        assert!((got - e).abs() < 2e-5 * largest, "{i}: {got} {e}");
    }
}

/// SSIM straight from its definition, in double precision.
fn naive_ssim(a: &Picture, b: &Picture, clamped: bool) -> f64 {
    let weight: Vec<f64> = (-5..=5).map(|d| (-f64::from(d * d) / 4.5).exp()).collect();
    let sum: f64 = weight.iter().sum();
    let value = |p: &Picture, x: i64, y: i64, c: usize| {
        if x < 0 || y < 0 || x >= i64::from(p.width) || y >= i64::from(p.height) {
            return 0.0;
        }
        let v = p.pixels[(y * i64::from(p.width) + x) as usize][c];
        f64::from(if clamped { v.clamp(0.0, 1.0) } else { v })
    };
    let mut total = 0.0;
    for i in 0..a.pixels.len() as i64 * 3 {
        let (c, x, y) = ((i % 3) as usize, i / 3 % i64::from(a.width), i / 3 / i64::from(a.width));
        let mut m = [0.0; 5];
        for dy in -5..=5 {
            for dx in -5..=5 {
                let w = weight[(dx + 5) as usize] * weight[(dy + 5) as usize] / (sum * sum);
                let (p, q) = (value(a, x + dx, y + dy, c), value(b, x + dx, y + dy, c));
                for (m, v) in m.iter_mut().zip([p, q, p * p, q * q, p * q]) {
                    *m += w * v;
                }
            }
        }
        let [p, q, pp, qq, pq] = m;
        total += (2.0 * p * q + 1e-4) * (2.0 * (pq - p * q) + 9e-4)
            / ((p * p + q * q + 1e-4) * (pp - p * p + qq - q * q + 9e-4));
    }
    total / (a.pixels.len() * 3) as f64
}

/// Sizes below the window, below a SIMD vector, and not a multiple of it.
#[test]
fn all_parts_equal_a_naive_evaluation() {
    let panel = display("oled-d22");
    for (width, height) in [(1, 1), (2, 3), (5, 7), (6, 40), (33, 12), (37, 41)] {
        let (a, b) = (noisy(width, height, 1), shown(width, height, 2));
        let mut gradient = vec![[0.0; 3]; a.pixels.len()];
        let parts = Loss::new(width, height).evaluate(&a, &b, 0.7, &panel, &mut gradient);
        let pairs =
            || a.pixels.as_flattened().iter().zip(b.pixels.as_flattened()).map(|(p, q)| (*p, *q));
        let n = (3 * a.pixels.len()) as f64;
        let l1 = pairs().map(|(p, q)| f64::from(p - q).abs()).sum::<f64>() / n;
        let square =
            pairs().map(|(p, q)| f64::from(p.clamp(0.0, 1.0) - q).powi(2)).sum::<f64>() / n;
        let ssim = naive_ssim(&a, &b, false);
        let watts = panel.power(mean_linear(&a.pixels)).0;
        // Single precision throughout; SSIM divides differences of squares: 2e-6 absolute.
        assert_relative_eq!(parts.l1, l1, max_relative = 1e-6);
        assert_relative_eq!(parts.psnr_db, -10.0 * square.log10(), max_relative = 1e-6);
        assert!((parts.ssim - ssim).abs() < 2e-6, "{} {ssim}", parts.ssim);
        assert_relative_eq!(parts.display_w, watts, max_relative = 1e-6);
        let total = 0.8 * parts.l1 + 0.2 * (1.0 - parts.ssim) + 0.7 * parts.display_w;
        assert_relative_eq!(parts.total, total, max_relative = 1e-12);
        let metric = likeness(&a, &b);
        assert!((metric.ssim - naive_ssim(&a, &b, true)).abs() < 2e-6);
        assert_relative_eq!(metric.psnr_db, parts.psnr_db, max_relative = 1e-12);
    }
}

/// Central differences of the naive loss in double precision, at pixels in the corners, on an
/// edge, inside; with and without the display.
#[test]
fn the_gradient_is_the_derivative() {
    let (width, height) = (23, 19);
    let (a, b) = (noisy(width, height, 3), shown(width, height, 4));
    let panel = display("oled-powergs");
    let n = (3 * a.pixels.len()) as f64;
    for lambda in [0.0, 0.5] {
        let (_, gradient) = evaluate(&a, &b, lambda);
        for (x, y, c) in [(0, 0, 0), (22, 18, 2), (11, 0, 1), (12, 9, 0), (5, 6, 2), (0, 13, 1)] {
            let at = (y * width + x) as usize;
            let mut moved = a.clone();
            let mut value = |step: f32| {
                moved.pixels[at][c] = a.pixels[at][c] + step;
                0.2 * (1.0 - naive_ssim(&moved, &b, false))
            };
            let h = 1e-3;
            let structure = (value(h) - value(-h)) / (2.0 * f64::from(h));
            let v = a.pixels[at][c];
            let sign = f64::from((v - b.pixels[at][c]).signum());
            let light = lambda * panel.coefficients()[c] * linear_slope(f64::from(v)) * 3.0 / n;
            let expected = structure + 0.8 * sign / n + light;
            // The step is a rounded f32, its square enters: 1e-3 of the L1 part.
            let got = f64::from(gradient[at][c]);
            assert!((got - expected).abs() < 1e-3 * 0.8 / n, "{x} {y} {c}: {got} {expected}");
        }
    }
}

#[test]
fn the_display_gradient_is_that_of_the_panel() {
    // All 8-bit values and some beyond, against double precision.
    let values = (0..255).map(|v| v as f32 / 255.0).chain([1.0, 1.3, 7.5, 100.0, -0.01, -3.0]);
    let pixels: Vec<_> = values.map(|v| [v; 3]).collect();
    let picture = Picture { width: pixels.len() as u32, height: 1, pixels };
    let panel = display("oled-powergs");
    let mut with = vec![[0.0; 3]; picture.pixels.len()];
    let lambda = 1e6;
    Loss::new(picture.width, 1).evaluate(&picture, &picture, lambda, &panel, &mut with);
    for (pixel, gradient) in picture.pixels.iter().zip(&with) {
        for c in 0..3 {
            let by_srgb = linear_slope(f64::from(pixel[c]));
            let slope = panel.coefficients()[c] * by_srgb / picture.pixels.len() as f64;
            // The rest of the gradient is 0 for equal pictures, but for rounding of SSIM.
            assert_relative_eq!(
                f64::from(gradient[c]),
                lambda * slope,
                max_relative = 2e-6,
                epsilon = 1e-3
            );
        }
    }
}

#[test]
fn threads_change_nothing() {
    let (a, b) = (noisy(61, 83, 5), shown(61, 83, 6));
    let one = on_threads(1, || evaluate(&a, &b, 0.3));
    for threads in [2, 3, 8] {
        assert_eq!(one, on_threads(threads, || evaluate(&a, &b, 0.3)), "{threads} threads");
    }
}

#[test]
fn a_work_space_forgets_what_it_saw() {
    let (a, b) = (noisy(40, 30, 7), shown(40, 30, 8));
    let mut loss = Loss::new(40, 30);
    let panel: Display = display("oled-powergs");
    let mut first = vec![[0.0; 3]; a.pixels.len()];
    let before = loss.evaluate(&a, &b, 0.1, &panel, &mut first);
    let mut poisoned = a.clone();
    poisoned.pixels[17] = [f32::NAN; 3];
    let mut again = first.clone();
    let bad = loss.evaluate(&poisoned, &b, 0.1, &panel, &mut again);
    assert!(bad.total.is_nan() && again[17][0].is_nan(), "NaN shows");
    assert_eq!(loss.evaluate(&a, &b, 0.1, &panel, &mut again), before);
    assert_eq!(first, again);
}

#[test]
fn equal_pictures_are_perfect() {
    let a = shown(20, 20, 9);
    let same = likeness(&a, &a);
    assert_eq!((same.l1, same.mse, same.psnr_db), (0.0, 0.0, f64::INFINITY));
    assert!((same.ssim - 1.0).abs() < 1e-7, "{}", same.ssim);
    let mut broken = a.clone();
    broken.pixels[3][1] = f32::INFINITY;
    assert!(likeness(&broken, &a).ssim.is_nan() && likeness(&a, &broken).psnr_db.is_nan());
}
