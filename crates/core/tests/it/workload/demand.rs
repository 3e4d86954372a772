//! What binning takes is known before it begins.

use powergs_base::budget::Budget;
use powergs_base::quantity::Bytes;
use powergs_core::workload::demand::{Unbinnable, demand};
use powergs_core::workload::{FrameDetail, bin};
use powergs_testkit::scenes::{front_camera, random_scene};

use super::support::{GEOMETRIES, dense_frame, rendered};

#[test]
fn the_estimate_is_not_below_what_a_binned_frame_takes() {
    for seed in 0..3 {
        let frame = dense_frame(seed);
        for geometry in GEOMETRIES {
            let estimate = demand(&frame, geometry, FrameDetail::default(), Budget::DEFAULT)
                .expect("a small frame");
            let binned = bin(&frame, geometry);
            let bytes = (4 * binned.list.len() + binned.bitmaps.len()) as u64;
            assert!((bytes..100 * bytes).contains(&estimate), "{geometry:?}: {estimate}, {bytes}");
        }
    }
}

#[test]
fn a_frame_beyond_the_budget_is_refused_with_its_pairs() {
    let mut scene = random_scene(7, 3000, 0);
    scene.log_scales.iter_mut().flatten().for_each(|s| *s = 3.0);
    let frame = rendered(&scene, &front_camera(320, 240)).1;
    for geometry in GEOMETRIES {
        let pairs = bin(&frame, geometry).counters.tile_pairs;
        let refused = demand(&frame, geometry, FrameDetail::default(), Budget(Bytes(1000)))
            .expect_err("1000 bytes");
        let Unbinnable::Memory { pairs: counted, over } = refused else { panic!("{refused}") };
        assert_eq!(counted, pairs, "{geometry:?}");
        assert!(refused.to_string().contains("allow more with --memory \"1 GiB\""), "{refused}");
        assert!(
            demand(&frame, geometry, FrameDetail::default(), Budget(Bytes(over.needed))).is_ok(),
            "{geometry:?}"
        );
    }
}
