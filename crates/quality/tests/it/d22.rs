//! The colour filter of Duinkharjav et al. 2022.

use powergs_base::picture::{Picture, linear};
use powergs_frame::display::d22::{Filter, Gaze, GazeError};
use serde_json::Value;

use super::pictures::{display, numbers, on_threads, shown};

fn triple(value: &Value) -> [f64; 3] {
    numbers(value).try_into().expect("three numbers")
}

/// Published filter, its network in single precision: axes to 1e-7, colours to 2e-6.
#[test]
fn the_published_colours() {
    let text =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/d22_filter.json"));
    let reference: Value = serde_json::from_str(text).expect("JSON");
    let d22 = [231.5384684, 245.6795914, 530.7596369];
    let powergs = [228.5245898, 205.6587915, 567.6371534];
    for (weights, key) in [(d22, "out_srgb_weights_D22"), (powergs, "out_srgb_weights_PowerGS")] {
        let filter = Filter::with_weights(weights);
        for (i, colour) in reference["srgb"].as_array().expect("colours").iter().enumerate() {
            let degrees = reference["ecc_deg"][i].as_f64().expect("an angle");
            let axes = filter.axes(triple(colour), degrees);
            for (a, e) in axes.iter().zip(numbers(&reference["ellipse_semi_axes"][i])) {
                assert!((a - e).abs() < 1e-7, "{i}: {axes:?} {e}");
            }
            let cheap = filter.colour(triple(colour), degrees);
            for (c, e) in cheap.iter().zip(triple(&reference[key][i])) {
                assert!((c - e).abs() < 2e-6, "{i}: {cheap:?} {e}");
            }
        }
    }
}

#[test]
fn luminance_stays_and_power_falls() {
    let panel = display("oled-d22");
    let filter = Filter::new(&panel);
    // Colours far enough from the sides of the gamut that nothing is clipped.
    for colour in [[0.5, 0.5, 0.5], [0.6, 0.5, 0.4], [0.45, 0.55, 0.5], [0.3, 0.35, 0.4]] {
        let cheap = filter.colour(colour, 25.0);
        assert!(cheap.iter().all(|&v| v > 0.0 && v < 1.0), "{cheap:?}");
        let light = |c: [f64; 3]| {
            let [r, g, b] = c.map(linear);
            0.212591496 * r + 0.715171392 * g + 0.072197112 * b
        };
        assert!((light(cheap) - light(colour)).abs() < 1e-12);
        assert!(panel.power(cheap.map(linear)).0 < panel.power(colour.map(linear)).0);
    }
}

#[test]
fn the_fovea_is_left_alone_and_the_periphery_is_not() {
    let picture = shown(200, 120, 3);
    let gaze = Gaze::new(0.25, 0.5, 90.0).expect("a gaze");
    let panel = display("oled-powergs");
    let filtered = Filter::new(&panel).apply(&picture, &gaze);
    let mut changed = 0;
    for y in 0..120 {
        for x in 0..200 {
            let at = (y * 200 + x) as usize;
            let degrees = gaze.eccentricity_deg(x, y, &picture);
            if degrees <= 8.5 {
                assert_eq!(filtered.pixels[at], picture.pixels[at], "{x} {y}");
            } else if filtered.pixels[at] != picture.pixels[at] {
                changed += 1;
            }
        }
    }
    assert!(changed > 15_000, "{changed}");
    let watts = |p: &Picture| panel.power(p.mean_linear_rgb()).0;
    assert!(watts(&filtered) < 0.98 * watts(&picture));
    for threads in [1, 3] {
        let again = on_threads(threads, || Filter::new(&panel).apply(&picture, &gaze));
        assert_eq!(again, filtered);
    }
    let empty = Picture::default();
    assert_eq!(Filter::new(&panel).apply(&empty, &gaze), empty);
}

#[test]
fn angles_are_those_of_the_screen() {
    let picture = Picture { width: 101, height: 51, pixels: vec![[0.0; 3]; 101 * 51] };
    let gaze = Gaze::new(0.5, 0.5, 90.0).expect("a gaze");
    assert!(gaze.eccentricity_deg(50, 25, &picture).abs() < 1e-9);
    // The edge of the screen is at 45 degrees; the middle of the last pixel is half one before.
    let edge = (100.0f64 / 101.0).atan().to_degrees();
    assert!((gaze.eccentricity_deg(100, 25, &picture) - edge).abs() < 1e-9);
    // Pixels are square.
    let [down, right] = [(50, 50), (75, 25)].map(|(x, y)| gaze.eccentricity_deg(x, y, &picture));
    assert!((down - right).abs() < 1e-9);
}

#[test]
fn gazes_and_fields_that_cannot_be_are_refused() {
    for (x, y) in [(-0.1, 0.5), (0.5, 1.1), (f64::NAN, 0.5), (0.5, f64::INFINITY)] {
        assert!(matches!(Gaze::new(x, y, 90.0), Err(GazeError::Gaze { .. })), "{x} {y}");
    }
    for fov in [0.0, 180.0, -90.0, 360.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Gaze::new(0.5, 0.5, fov), Err(GazeError::FieldOfView { .. })), "{fov}");
    }
    assert!(Gaze::new(0.0, 1.0, 179.9).is_ok());
}
