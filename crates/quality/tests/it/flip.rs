//! FLIP: properties that the published definition gives in closed form.

use powergs_base::picture::Picture;
use powergs_quality::flip::colour::{linear_rgb, opponent};
use powergs_quality::flip::{PIXELS_PER_DEGREE, flip, map};

use super::pictures::{noisy, on_threads, shown};

fn plain(colour: [f32; 3]) -> Picture {
    Picture { width: 30, height: 25, pixels: vec![colour; 750] }
}

/// Plain pictures have no features and filters leave them alone: what remains is the HyAB distance
/// of Hunt-adjusted colours. Values from that formula in double precision.
#[test]
fn plain_pictures_differ_as_their_colours() {
    let (black, white) = ([0.0; 3], [1.0; 3]);
    let (red, green, blue) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    for (a, b, expected) in [
        (black, black, 0.0),
        (green, blue, 1.0),
        (black, white, 0.967_379_761_5),
        (red, green, 0.986_662_275_2),
    ] {
        let value = flip(&plain(a), &plain(b), PIXELS_PER_DEGREE);
        // Single precision through an inverse matrix; plain filters keep sums to 1e-6.
        assert!((value - expected).abs() < 2e-5, "{a:?} {b:?}: {value} {expected}");
    }
}

#[test]
fn equal_pictures_do_not_differ_and_order_does_not_matter() {
    let (a, b) = (shown(40, 33, 1), shown(40, 33, 2));
    assert_eq!(flip(&a, &a, PIXELS_PER_DEGREE), 0.0);
    let there = flip(&a, &b, PIXELS_PER_DEGREE);
    assert!(there > 0.01 && there < 1.0, "{there}");
    assert_eq!(there, flip(&b, &a, PIXELS_PER_DEGREE));
}

#[test]
fn values_outside_the_display_are_clamped() {
    let a = noisy(40, 33, 3);
    assert_eq!(flip(&a, &shown(40, 33, 3), PIXELS_PER_DEGREE), 0.0);
}

/// A thin line shows more than the same error spread out would: features raise it. Far from it
/// nothing differs.
#[test]
fn an_edge_counts_around_its_place_only() {
    let grey = Picture { width: 80, height: 40, pixels: vec![[0.5; 3]; 3200] };
    let mut line = grey.clone();
    for y in 0..40 {
        line.pixels[y * 80 + 40] = [0.6; 3];
    }
    let difference = map(&grey, &line, PIXELS_PER_DEGREE);
    let row = &difference[20 * 80..21 * 80];
    assert!(row[40] > 0.1, "{}", row[40]);
    // Beyond both filters, 10 and 9 pixels.
    assert!(row[..29].iter().chain(&row[52..]).all(|&v| v == 0.0), "{row:?}");
    // The line is symmetric, and so is what is seen of it; the square root of the feature
    // difference makes 1e-4 of a rounding of 1e-8.
    for d in 1..12 {
        assert!((row[40 - d] - row[40 + d]).abs() < 1e-3, "{d}");
    }
    assert!(difference.iter().all(|v| (0.0..=1.0).contains(v)));
}

/// From far away less is seen of noise.
#[test]
fn distance_hides_noise() {
    let (a, b) = (shown(64, 64, 4), shown(64, 64, 5));
    let [near, far] = [20.0, 200.0].map(|density| flip(&a, &b, density));
    assert!(far < near, "{near} {far}");
}

#[test]
fn small_pictures_threads_and_broken_values() {
    for size in [(1, 1), (2, 5), (9, 1)] {
        let (a, b) = (shown(size.0, size.1, 6), shown(size.0, size.1, 7));
        assert!((0.0..=1.0).contains(&flip(&a, &b, PIXELS_PER_DEGREE)));
    }
    let (a, b) = (shown(50, 47, 6), shown(50, 47, 7));
    let one = on_threads(1, || map(&a, &b, 67.0));
    assert_eq!(one, on_threads(5, || map(&a, &b, 67.0)));
    for bad in [f32::NAN, f32::INFINITY] {
        let mut broken = a.clone();
        broken.pixels[99][2] = bad;
        assert!(flip(&broken, &a, 67.0).is_nan());
    }
}

#[test]
fn the_matrices_are_inverse() {
    for rgb in [[0.2, 0.7, 0.1], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] {
        let back = linear_rgb(opponent(rgb));
        for (a, b) in rgb.iter().zip(back) {
            assert!((a - b).abs() < 1e-5, "{rgb:?} {back:?}");
        }
    }
}
