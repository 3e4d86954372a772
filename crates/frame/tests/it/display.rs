//! Display power: the published vector, whites and blues, gradients.

use std::path::Path;

use approx::assert_relative_eq;
use powergs_base::config::embedded::{DISPLAYS, find};
use powergs_base::config::references::is_source;
use powergs_base::picture::{Picture, linear};
use powergs_base::quantity::Watts;
use powergs_frame::display::Display;
use powergs_testkit::display::{linear_slope, mean_linear};
use serde_json::Value;

fn preset(name: &str) -> Display {
    let text = find(DISPLAYS, name).expect("a preset");
    Display::parse(text).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// Values above 1 and a gradient, from the published code in double precision. Ours differs in the
/// order of sums only: 1e-12.
#[test]
fn the_published_tensor_has_its_power_and_gradient() {
    let reference: Value = serde_json::from_str(include_str!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/data/display_power.json"
    )))
    .expect("JSON");
    let tensor = &reference["float_tensor"];
    let (values, gradient) = (numbers(&tensor["value"]), numbers(&tensor["grad"]));
    let n = values.len() / 3;
    let mut display = preset("oled-powergs");
    display.scale = 1.0;
    let mean = |c: usize| values[c * n..(c + 1) * n].iter().map(|v| linear(*v)).sum::<f64>();
    let power = display.power([0, 1, 2].map(|c| mean(c) / n as f64));
    let expected = tensor["power_scale1"].as_f64().expect("a number");
    assert_relative_eq!(power.0, expected, max_relative = 1e-12);
    for (i, (value, slope)) in values.iter().zip(&gradient).enumerate() {
        let ours = display.coefficients()[i / n] * linear_slope(*value) / n as f64;
        assert_relative_eq!(ours, *slope, max_relative = 1e-12);
    }
}

#[test]
fn white_black_and_blue_cost_what_is_published() {
    let powergs = preset("oled-powergs");
    // Published to four decimals.
    assert!((powergs.power([1.0; 3]).0 - 3.0055).abs() < 5e-5);
    assert!((powergs.power([0.0, 0.0, 1.0]).0 - 1.7029).abs() < 5e-5);
    assert_eq!(powergs.power([0.0; 3]), Watts(0.0));
    let d22 = preset("oled-d22");
    assert_eq!(d22.power([0.0; 3]), Watts(0.9772813229));
    let white = 0.2315384684 + 0.2456795914 + 0.5307596369 + 0.9772813229;
    assert_relative_eq!(d22.power([1.0; 3]).0, white, max_relative = 1e-12);
}

#[test]
fn the_slope_is_the_derivative_of_the_curve() {
    for x in [1e-4, 0.02, 0.0404, 0.0405, 0.2, 0.5, 1.0, 1.7] {
        let h = 1e-7;
        let difference = (linear(x + h) - linear(x - h)) / (2.0 * h);
        // Central differences of a smooth curve: h² and rounding, 1e-6 is ample.
        assert_relative_eq!(linear_slope(x), difference, max_relative = 1e-6);
    }
}

#[test]
fn negative_renders_are_black() {
    for x in [-0.01, -0.056, -10.0, f64::NEG_INFINITY] {
        assert_eq!((linear(x), linear_slope(x)), (0.0, 0.0));
    }
    assert_eq!(mean_linear(&[[-1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]), [0.0, 0.0, 1.0]);
    assert_eq!(mean_linear(&[]), [0.0; 3]);
}

#[test]
fn presets_that_make_no_sense_are_refused() {
    let good = find(DISPLAYS, "oled-powergs").expect("a preset");
    let changes = [
        ("scale = 3.0", "scale = 0", "must be above 0"),
        ("scale = 3.0", "scale = nan", "finite"),
        ("red = \"228.5245898 mW\"", "red = 228.5", "a power needs its unit"),
        ("red = \"228.5245898 mW\"", "rde = \"1 mW\"", "did you mean `red`?"),
        ("source = \"powergs\"", "source = \" \"", "where the numbers are from"),
    ];
    for (from, to, because) in changes {
        let error = Display::parse(&good.replace(from, to)).expect_err(to).to_string();
        assert!(error.contains(because), "{error}");
    }
    let dark = good.replace("228.5245898", "0").replace("205.6587915", "0");
    let error = Display::parse(&dark.replace("567.6371534", "0")).expect_err("a dark panel");
    assert!(error.to_string().contains("all zero"), "{error}");
}

/// One's own panel has a source in words; those that come with the program are cited.
#[test]
fn sources_are_words_or_citations() {
    let good = find(DISPLAYS, "oled-powergs").expect("a preset");
    let own = good.replace("source = \"powergs\"", "source = \"own measurement, 2026\"");
    assert_eq!(Display::parse(&own).expect("a panel").source, "own measurement, 2026");
    for file in DISPLAYS {
        let display = Display::parse(file.text).expect("it comes with the program");
        assert!(is_source(&display.source), "{}", file.name);
    }
}

/// The white and the ramp of the reference images, where they are at hand.
#[test]
fn reference_images_cost_what_their_pixels_say() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/reference/img");
    if !Path::new(folder).exists() {
        println!("skipped: ../shared/reference is absent");
        return;
    }
    let open = |name: &str| {
        let bytes = std::fs::read(Path::new(folder).join(name)).expect(name);
        let limits = powergs_pixels::Limits { side: 1 << 12, bytes: 1 << 26 };
        let image = powergs_pixels::decode(&bytes, limits).expect(name);
        let pixels = image.rgba().map(|[r, g, b, _]| [r, g, b]).collect();
        Picture { width: image.width, height: image.height, pixels }
    };
    let display = preset("oled-powergs");
    let white = open("D_white.png");
    assert!((display.power(white.mean_linear_rgb()).0 - 3.0055).abs() < 5e-5);
    for name in ["D_ramp.png", "A_gt.png", "B_mix.png"] {
        let picture = open(name);
        let (displayed, rendered) =
            (display.power(picture.mean_linear_rgb()), display.power(mean_linear(&picture.pixels)));
        // 8-bit values as f32 round to the same bytes; f32 against f64 decoding: 1e-6.
        assert_relative_eq!(displayed.0, rendered.0, max_relative = 1e-6);
    }
}
