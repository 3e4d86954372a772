//! Curves through samples, and the optimum.

use powergs_optimize::fit::{
    Fit, FitError, OptimumPlace, Sample, Shape, fit, optimum, read_samples,
};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

fn samples(rho: &[f64], display: &[f64], render: &[f64]) -> Vec<Sample> {
    let of = |i: usize| Sample { rho: rho[i], display_w: display[i], render_w: render[i] };
    (0..rho.len()).map(of).collect()
}

/// Samples of given curves: the drop is `s x / (t + (1 − t) x)` of the range.
fn made(display: impl Fn(f64) -> f64, render: impl Fn(f64) -> f64) -> Vec<Sample> {
    (0..=6)
        .map(|i| f64::from(i) / 6.0)
        .map(|u| Sample { rho: 0.9 * u, display_w: display(1.0 - u), render_w: render(u) })
        .collect()
}

/// Curves within 1e-3 of their range and optima within 2e-3, as the reference states; the closed
/// form on parameters that agree is far closer.
#[test]
fn the_published_fits_and_optima() {
    let text =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/isoquality_fit.json"));
    let reference: Value = serde_json::from_str(text).expect("JSON");
    for case in reference["cases"].as_array().expect("cases") {
        let name = case["name"].as_str().expect("a name");
        let list = |key: &str| numbers(&case[key]);
        let number = |key: &str| case[key].as_f64().expect(key);
        let fitted = fit(&samples(&list("rho"), &list("display"), &list("render"))).expect("a fit");
        let (display_range, render_range) =
            (number("d_max") - number("d_min"), number("r_max") - number("r_min"));
        for (i, rho) in list("curve_rho").into_iter().enumerate() {
            let d = fitted.display_w(rho) - list("curve_display")[i];
            let r = fitted.render_w(rho) - list("curve_render")[i];
            assert!(d.abs() < 1e-5 * display_range, "{name} display at {rho}: {d}");
            assert!(r.abs() < 1e-5 * render_range, "{name} render at {rho}: {r}");
        }
        let best = optimum(&fitted);
        assert!((best.rho - number("optimum_clean_clamped")).abs() < 1e-4, "{name}: {best:?}");
        assert!((best.total_w() - number("min_total")).abs() < 1e-5, "{name}: {best:?}");
        for (ours, key) in [
            (fitted.display.r2, "r2_display"),
            (fitted.render.r2, "r2_render"),
            (fitted.display.mre, "mre_display"),
            (fitted.render.mre, "mre_render"),
        ] {
            // Noiseless samples: both solvers stop somewhere below 1e-8.
            assert!((ours.expect(key) - number(key)).abs() < 1e-6, "{name} {key}: {ours:?}");
        }
        let heuristic = number("heuristic_best_rho");
        assert!((best.best_sample_rho - heuristic).abs() < 0.11, "{name}: near the best sample");
    }
}

/// The minimum of the fitted total on a fine grid, which the closed form must not miss.
fn grid(fitted: &Fit) -> f64 {
    let (low, high) = (fitted.rho_min(), fitted.rho_max());
    (0..=20_000)
        .map(|i| low + (high - low) * f64::from(i) / 20_000.0)
        .map(|rho| fitted.total_w(rho))
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn the_closed_form_is_the_minimum_for_all_bends() {
    let curve = |t: f64, s: f64| move |x: f64| 1.0 - s * x / (t + (1.0 - t) * x);
    for (td, tr) in [(0.05, 0.3), (0.3, 0.05), (0.5, 0.5), (0.9, 0.2), (0.2, 0.9), (0.99, 0.99)] {
        for ratio in [0.05, 0.3, 1.0, 3.0, 20.0] {
            let (d, r) = (curve(td, 0.6), curve(tr, 0.8));
            let fitted = fit(&made(|x| ratio * d(x), r)).expect("a fit");
            let best = optimum(&fitted);
            let least = grid(&fitted);
            // The grid is 5e-5 wide and the curve flat there.
            assert!(best.total_w() <= least + 1e-9 * ratio.max(1.0), "{td} {tr} {ratio}: {best:?}");
            assert!(best.total_w() >= least - 1e-6 * ratio.max(1.0), "{td} {tr} {ratio}: {best:?}");
        }
    }
}

#[test]
fn the_ends_of_the_range_are_found_and_said() {
    // Rendering falls twice as steeply as display rises, everywhere; and the other way round.
    let fitted = fit(&made(|x| 2.0 - x, |x| 3.0 - 2.0 * x)).expect("a fit");
    let best = optimum(&fitted);
    assert_eq!((best.place, best.rho), (OptimumPlace::MostPruned, 0.9));
    assert!(fitted.notes().iter().any(|n| n.contains("largest rho")), "{:?}", fitted.notes());
    let best = optimum(&fit(&made(|x| 3.0 - 2.0 * x, |x| 2.0 - x)).expect("a fit"));
    assert_eq!((best.place, best.rho), (OptimumPlace::LeastPruned, 0.0));
    // No rendering power to save, no display power to save, neither.
    assert_eq!(
        optimum(&fit(&made(|x| 2.0 - x, |_| 1.0)).unwrap()).place,
        OptimumPlace::LeastPruned
    );
    assert_eq!(optimum(&fit(&made(|_| 1.0, |x| 2.0 - x)).unwrap()).place, OptimumPlace::MostPruned);
    let fitted = fit(&made(|_| 1.0, |_| 2.0)).expect("a fit");
    assert_eq!(optimum(&fitted).place, OptimumPlace::Anywhere);
    assert_eq!((fitted.display.shape(), fitted.display.r2), (Shape::Flat, None));
    assert_eq!(fitted.display.mre, Some(0.0));
}

#[test]
fn straight_lines_are_fitted_and_said() {
    let fitted = fit(&made(|x| 2.0 - x, |x| 3.0 - 2.0 * x)).expect("a fit");
    assert_eq!(fitted.display.shape(), Shape::Straight);
    assert!(fitted.display.r2.unwrap() > 1.0 - 1e-12);
    assert!(fitted.notes()[0].contains("V and K are not determined"), "{:?}", fitted.notes());
    // Concave data: the model has no such curve; the nearest is a straight line.
    let fitted = fit(&made(|x| 2.0 - x * x * x, |x| 3.0 - 2.0 * x)).expect("a fit");
    assert_eq!(fitted.display.shape(), Shape::Straight);
    assert!(fitted.display.r2.unwrap() < 0.9);
    assert!(fitted.notes()[0].contains("bends the other way"), "{:?}", fitted.notes());
}

#[test]
fn steps_and_rising_power_are_said() {
    // The display saves everything with the first pruned Gaussian: K is 0.
    let step = |x: f64| if x == 0.0 { 2.0 } else { 1.0 };
    let fitted = fit(&made(step, |x| 3.0 - x)).expect("a fit");
    assert_eq!(fitted.display.shape(), Shape::Step, "{:?}", fitted.display);
    assert!((fitted.display.v() - 1.0).abs() < 1e-6);
    let best = optimum(&fitted);
    assert!(best.rho > 0.89 && best.total_w() < 3.01, "{best:?}");
    // Rendering power that rises with pruning is fitted by a poor curve, and said.
    let fitted = fit(&made(|x| 2.0 - x, |x| 1.0 + x)).expect("a fit");
    assert!(fitted.render.r2.unwrap() < 0.5);
    assert!(fitted.notes().iter().any(|n| n.starts_with("render power")), "{:?}", fitted.notes());
}

#[test]
fn an_optimum_far_from_the_best_sample_is_not_trusted() {
    let mut data = made(|x| 2.0 - 0.9 * x / (0.2 + 0.8 * x), |x| 2.0 - 0.9 * x / (0.2 + 0.8 * x));
    // One sample that is far too good.
    data[0].render_w = 0.1;
    let best = optimum(&fit(&data).expect("a fit"));
    assert!(!best.is_trusted() && best.chosen_rho() == 0.0, "{best:?}");
}

#[test]
fn order_and_repetition_change_nothing() {
    let data = made(|x| 2.0 - 0.9 * x / (0.2 + 0.8 * x), |x| 2.0 - x / (0.5 + 0.5 * x));
    let forward = optimum(&fit(&data).unwrap());
    let reversed: Vec<Sample> = data.iter().rev().copied().collect();
    assert_eq!(optimum(&fit(&reversed).unwrap()).rho, forward.rho);
    let twice: Vec<Sample> = data.iter().chain(&data).copied().collect();
    assert!((optimum(&fit(&twice).unwrap()).rho - forward.rho).abs() < 1e-6);
}

#[test]
fn samples_that_cannot_be_are_refused() {
    let good = made(|x| 2.0 - x, |x| 3.0 - x);
    assert_eq!(fit(&[]), Err(FitError::TooFew { distinct: 0 }));
    let same = [good[1]; 9];
    assert_eq!(fit(&same), Err(FitError::TooFew { distinct: 1 }));
    assert_eq!(fit(&good[..2]), Err(FitError::TooFew { distinct: 2 }));
    for bad in [f64::NAN, f64::INFINITY, -1.0, 1e10] {
        for field in 0..3 {
            let mut data = good.clone();
            match field {
                0 => data[2].rho = bad,
                1 => data[2].display_w = bad,
                _ => data[2].render_w = bad,
            }
            let error = fit(&data).expect_err("refused").to_string();
            assert!(error.contains("sample 2"), "{error}");
        }
    }
}

#[test]
fn tables_are_read_and_bad_ones_refused() {
    let text =
        "name,render_w, rho ,display_w,passed\na,3,0,1,true\nb,2,0.5,1.5,false\nc,1,1e-1,2,1\n";
    let (read, left_out) = read_samples(text.as_bytes()).expect("a table");
    assert_eq!(read, samples(&[0.0, 0.1], &[1.0, 2.0], &[3.0, 1.0]));
    assert_eq!(left_out, 1);
    for (text, because) in [
        ("", "no column `rho`"),
        ("rho,display_w\n0,1\n", "no column `render_w`"),
        ("rho,display_w,render_w\n0,1\n", "found record with 2 fields"),
        ("rho,display_w,render_w\n0,1,2\n0.1,x,2\n", "line 3, column `display_w`: `x`"),
        ("rho,display_w,render_w\n0,1,nan\n", "is not a finite number"),
        ("rho,display_w,render_w\n0,1,1e999\n", "is not a finite number"),
        ("rho,display_w,render_w,passed\n0,1,2,maybe\n", "is not true or false"),
    ] {
        let error = read_samples(text.as_bytes()).expect_err(text).to_string();
        assert!(error.contains(because), "{text}: {error}");
    }
    let binary = [b"rho,display_w,render_w\n0,1,".as_slice(), &[0xff, 0xfe, b'\n']].concat();
    assert!(read_samples(binary.as_slice()).is_err());
    let long = "rho,display_w,render_w\n".to_owned() + &"0,1,2\n".repeat(100_001);
    assert!(read_samples(long.as_bytes()).unwrap_err().to_string().contains("not a table"));
}
