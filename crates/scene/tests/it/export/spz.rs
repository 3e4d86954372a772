//! SPZ: its own values are held exactly, others within half a step.

use powergs_scene::Format;
use powergs_scene::export::{Files, Target, write};
use powergs_testkit::scene_files::{self as encode, sample};

use super::{read_back, twice};
use crate::scene::read_bytes;

#[test]
fn what_was_read_from_spz_is_written_exactly() {
    for version in [3, 4] {
        for degree in 0..=3 {
            let scene = read_bytes(&encode::spz(&sample(500, degree), version, &[])).unwrap();
            let export = write(&scene.gaussians, Target::Spz).unwrap();
            let read = read_back(&export);
            assert_eq!(read.format, Format::Spz(3));
            assert_eq!(read.gaussians, scene.gaussians);
            assert!(export.fidelity.is_exact(), "{:?}", export.fidelity);
        }
    }
}

#[test]
fn axes_are_right_up_back_in_the_file() {
    // A reader that is told that the axes are those of PLY finds y and z turned.
    let scene = sample(50, 3);
    let Files::One(bytes) = write(&scene, Target::Spz).unwrap().files else { panic!("one file") };
    let mut plain = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&bytes[..]), &mut plain).unwrap();
    assert_eq!(&plain[..8], b"NGSP\x03\0\0\0");
    let bits = plain[13];
    let word = |at: usize| i32::from_le_bytes([0, plain[at], plain[at + 1], plain[at + 2]]) >> 8;
    let unit = 2_f64.powi(bits.into());
    for (i, mean) in scene.means.iter().enumerate() {
        let turned = [mean[0], -mean[1], -mean[2]].map(f64::from);
        for (axis, value) in turned.iter().enumerate() {
            let stored = f64::from(word(16 + 9 * i + 3 * axis)) / unit;
            assert!((stored - value).abs() <= 0.5 / unit);
        }
    }
}

#[test]
fn ends_of_ranges_are_counted() {
    let mut scene = sample(20, 1);
    scene.log_scales[3] = [-10.5, 6.5, -9.9];
    scene.sh[0] = 4.0;
    scene.sh[1] = -1.5;
    scene.sh[2] = 1.2;
    let kept = write(&scene, Target::Spz).unwrap().fidelity;
    assert_eq!((kept.scale.clamped, kept.colour_dc.clamped, kept.colour_rest.clamped), (2, 1, 2));
    assert!((kept.scale.largest - (6.5 - 5.9375)).abs() < 1e-6, "{:?}", kept.scale);
    // The first is odd in y, and so stored as 1.5; the largest byte is 127/128.
    assert_eq!(kept.colour_rest.largest, 1.5 - 127.0 / 128.0);
}

#[test]
fn the_second_time_nothing_is_lost() {
    let (once, first, again, second) = twice(&sample(700, 3), Target::Spz);
    assert!(!first.is_exact() && second.is_exact());
    assert_eq!(once, again);
}
