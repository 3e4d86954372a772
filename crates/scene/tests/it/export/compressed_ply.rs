//! Compressed PLY: chunks, and fields that have bytes of their own.

use powergs_scene::export::{Target, write};
use powergs_scene::{Format, Gaussians};
use powergs_testkit::scene_files::sample;

use super::{read_back, twice};

#[test]
fn bytes_are_held_the_second_time() {
    for degree in 0..=3 {
        let (once, _, again, second) = twice(&sample(600, degree), Target::CompressedPly);
        assert!(second.rotation.exact && second.opacity.exact && second.colour_rest.exact);
        // Bounds are single precision, and what lies between them is rounded to it again.
        assert!(second.position.largest < 1e-6 && second.scale.largest < 1e-5);
        assert!(second.colour_dc.largest < 1e-5);
        assert_eq!(once.rotations, again.rotations);
    }
}

#[test]
fn a_chunk_of_one_place_is_exact_in_it() {
    let mut scene = sample(513, 0);
    scene.means.fill([0.1, -2e9, 3e-30]);
    scene.log_scales.fill([-4.4, -40.0, 0.7]);
    let export = write(&scene, Target::CompressedPly).unwrap();
    assert!(export.fidelity.position.exact && export.fidelity.scale.exact);
    assert_eq!(read_back(&export).format, Format::CompressedPly);
}

#[test]
fn chunks_have_bounds_of_their_own() {
    // One Gaussian far away costs its chunk digits, and no other.
    let mut scene = sample(512, 0);
    scene.means[300] = [1e6; 3];
    let held: Gaussians = read_back(&write(&scene, Target::CompressedPly).unwrap()).gaussians;
    let worst = |range: std::ops::Range<usize>| {
        let pairs = scene.means[range.clone()].iter().zip(&held.means[range]);
        pairs.flat_map(|(a, b)| (0..3).map(move |i| (a[i] - b[i]).abs())).fold(0.0, f32::max)
    };
    assert!(worst(0..256) < 1.1e-3 && worst(256..512) > 0.1);
}

#[test]
fn harmonics_beyond_four_are_counted() {
    let mut scene = sample(5, 1);
    scene.sh[1] = 4.5;
    scene.sh[2] = -4.0;
    let kept = write(&scene, Target::CompressedPly).unwrap().fidelity.colour_rest;
    assert_eq!((kept.clamped, kept.largest), (1, 0.5));
}
