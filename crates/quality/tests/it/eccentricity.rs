//! Eccentricity, pooling size and level; HVSQ of the regions around a gaze.

use powergs_frame::display::d22::GazeError;
use powergs_frame::fovea::{EccentricityMap, POOLINGS};
use powergs_quality::Hvsq;

use super::pictures::shown;

/// The reference is rounded to six decimals.
#[test]
fn the_published_levels() {
    let mut rows = csv::Reader::from_reader(
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/foveation_levels.csv"))
            .as_bytes(),
    );
    let mut n = 0;
    for row in rows.records() {
        let row = row.expect("a row");
        let v: Vec<f64> = row.iter().map(|f| f.parse().expect("a number")).collect();
        let map =
            EccentricityMap::new([v[2], v[3]], 90.0, [v[0] as u32, v[1] as u32]).expect("a gaze");
        assert!((map.eccentricity_deg(v[4], v[5]) - v[6]).abs() < 1e-6, "{row:?}");
        assert!((map.pooling_px(v[4], v[5]) - v[7]).abs() < 1e-6, "{row:?}");
        assert!((map.level(v[4], v[5]) - v[8]).abs() < 1e-6, "{row:?}");
        n += 1;
    }
    assert!(n > 40, "{n} rows");
}

#[test]
fn extremes_of_eccentricity() {
    let map = EccentricityMap::new([0.3, 0.6], 90.0, [640, 480]).expect("a gaze");
    // ScreenGaze at it: no eccentricity, not NaN.
    assert_eq!(map.level(0.3 * 640.0, 0.6 * 480.0), 0.0);
    // A very wide screen seen from its corner: the far corner is as coarse as can be.
    let wide = EccentricityMap::new([0.0, 0.0], 179.0, [640, 480]).expect("a gaze");
    assert_eq!(wide.level(639.5, 479.5), 3.9);
    for (gaze, fov) in [([1.1, 0.5], 90.0), ([0.5, f64::NAN], 90.0)] {
        assert!(matches!(EccentricityMap::new(gaze, fov, [8, 8]), Err(GazeError::Gaze { .. })));
    }
    for fov in [0.0, 180.0, f64::NAN] {
        let refused = EccentricityMap::new([0.5, 0.5], fov, [8, 8]);
        assert!(matches!(refused, Err(GazeError::FieldOfView { .. })), "{fov}");
    }
}

/// Where one region is everywhere, its value is that of the whole picture.
#[test]
fn a_region_that_is_all_is_the_whole_picture() {
    let (a, b) = (shown(70, 45, 1), shown(70, 45, 2));
    let mut hvsq = Hvsq::new(70, 45, &POOLINGS).expect("poolings");
    let reference = hvsq.reference(&b);
    let whole = hvsq.values(&a, &reference);
    for p in 0..4u8 {
        let regions = vec![p; a.pixels.len()];
        let parts = hvsq.regional(&a, &reference, &regions);
        for (i, part) in parts.iter().enumerate() {
            match part {
                Some(value) => {
                    assert_eq!(i, usize::from(p));
                    // Double against single precision.
                    assert!((value / whole[i] - 1.0).abs() < 2e-5, "{value} {}", whole[i]);
                }
                None => assert_ne!(i, usize::from(p)),
            }
        }
    }
}

/// An error in the left half is seen in the left region only, but for the reach of the filters.
#[test]
fn an_error_stays_in_its_region() {
    let (b, width) = (shown(128, 64, 3), 128);
    let mut a = b.clone();
    for (i, pixel) in a.pixels.iter_mut().enumerate() {
        if i % width < 20 {
            pixel[1] *= 0.8;
        }
    }
    let regions: Vec<u8> = (0..a.pixels.len()).map(|i| u8::from(i % width >= 64)).collect();
    let mut hvsq = Hvsq::new(128, 64, &[1.0, 3.0]).expect("poolings");
    let reference = hvsq.reference(&b);
    let parts = hvsq.regional(&a, &reference, &regions);
    let (left, right) = (parts[0].expect("pixels"), parts[1].expect("pixels"));
    assert!(left > 1e-5 && right < 1e-3 * left, "{left} {right}");
}
