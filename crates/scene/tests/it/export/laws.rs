//! What holds for every format and every sound model.

use powergs_scene::Gaussians;
use powergs_scene::convert::sigmoid;
use powergs_scene::export::{Fidelity, Files, Target, write};
use powergs_testkit::difference::difference;
use powergs_testkit::scene_files::{ply, sample};
use proptest::prelude::*;

use super::read_back;

/// Models as trainers leave them, and some that they would not: unnormalised rotations of either
/// sign, few and many Gaussians, flat ones, faint ones, far ones.
fn models() -> impl Strategy<Value = Gaussians> {
    let number = |limit: f32| -limit..limit;
    let gaussian = (
        [number(50.0), number(50.0), number(0.5)],
        [number(8.0), number(8.0), -30.0..2.0_f32],
        prop::array::uniform4(prop_oneof![number(2.0), Just(0.0), Just(0.5)]),
        number(20.0),
        prop::collection::vec(number(3.0), 48),
    );
    (prop::collection::vec(gaussian, 1..600), 0..=3_u8).prop_map(|(rows, sh_degree)| {
        let mut scene = Gaussians { sh_degree, ..Gaussians::default() };
        for (mean, log_scale, mut rotation, opacity, sh) in rows {
            if rotation == [0.0; 4] {
                rotation[0] = 1.0;
            }
            scene.means.push(mean);
            scene.log_scales.push(log_scale);
            scene.rotations.push(rotation);
            scene.logit_opacities.push(opacity);
            scene.sh.extend(&sh[..3 * (sh_degree as usize + 1).pow(2)]);
        }
        scene
    })
}

/// Half a step of what the format has for each field; see the formats' own tests for the rest.
fn check_bounds(target: Target, scene: &Gaussians, kept: &Fidelity) {
    let range = |rows: &[[f32; 3]]| {
        let all = || rows.iter().flatten().copied();
        f64::from(all().fold(f32::MIN, f32::max) - all().fold(f32::MAX, f32::min))
    };
    assert!(kept.opacity.largest <= 0.501 / 255.0 + 1e-6, "{target:?}: {:?}", kept.opacity);
    match target {
        Target::Ply => assert!(kept.is_exact()),
        Target::Gltf | Target::Glb => {
            assert!(kept.position.exact && kept.colour_dc.exact && kept.colour_rest.exact);
            assert!(kept.scale.largest < 1e-5 && kept.rotation.largest < 1e-4);
        }
        Target::CompressedPly => {
            let step = 0.501 / 1023.0;
            assert!(kept.position.largest <= step * range(&scene.means) + 1e-6);
            assert!(kept.scale.largest <= step * range(&scene.log_scales) + 1e-6);
            assert!(kept.rotation.largest < 0.35, "{:?}", kept.rotation);
            assert!(kept.colour_rest.largest <= 0.5 * 8.0 / 256.0 + 1e-6);
        }
        Target::Spz | Target::GlbSpz => {
            assert!(kept.position.largest <= 0.5 * 50.0 / 4_194_304.0);
            assert!(kept.rotation.largest < 0.4, "{:?}", kept.rotation);
            if kept.scale.clamped == 0 {
                assert!(kept.scale.largest <= 0.5 / 16.0 + 1e-6);
            }
            if kept.colour_rest.clamped == 0 {
                assert!(kept.colour_rest.largest <= 0.5 / 128.0 + 1e-6);
            }
        }
        Target::Sog | Target::SogFolder => {
            // In the logarithmic space, widened by at most 1 + |x|.
            let step = 0.501 * 2.0 * 51.0_f64.ln() / 65535.0;
            assert!(kept.position.largest <= 51.0 * step, "{:?}", kept.position);
            assert!(kept.rotation.largest < 1.4, "{:?}", kept.rotation);
            // Cells of a codebook are at most the range; in the mean they are far smaller.
            assert!(kept.scale.rms <= range(&scene.log_scales) / 256.0, "{:?}", kept.scale);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn errors_are_bounded_and_said_as_they_are(scene in models()) {
        for target in Target::ALL {
            let export = write(&scene, target).expect("a sound model");
            let held = read_back(&export).gaussians;
            prop_assert_eq!((held.len(), held.sh_degree), (scene.len(), scene.sh_degree));
            let kept = export.fidelity;
            let found = difference(&scene, &held);
            // Another program for the same numbers.
            prop_assert!((kept.position.largest - f64::from(found.mean)).abs() < 1e-6);
            prop_assert!((kept.scale.largest - f64::from(found.log_scale)).abs() < 1e-5);
            prop_assert!((kept.opacity.largest - found.opacity).abs() < 1e-12);
            prop_assert!((kept.colour_dc.largest - f64::from(found.dc)).abs() < 1e-6);
            prop_assert!((kept.colour_rest.largest - f64::from(found.rest)).abs() < 1e-6);
            prop_assert_eq!(kept.position.exact, scene.means == held.means);
            prop_assert_eq!(kept.rotation.exact, scene.rotations == held.rotations);
            for (name, kept) in kept.named() {
                prop_assert!(kept.rms <= kept.largest, "{}", name);
                prop_assert!(!kept.exact || (kept.largest < 1e-5 && kept.clamped == 0), "{}", name);
            }
            check_bounds(target, &scene, &kept);
        }
    }
}

#[test]
fn ply_is_the_file_that_is_written_as_a_stream() {
    let scene = sample(300, 2);
    let export = write(&scene, Target::Ply).unwrap();
    assert_eq!(export.files, Files::One(ply(&scene)));
    assert!(export.fidelity.is_exact());
}

#[test]
fn bytes_do_not_depend_on_threads() {
    // More than a block of the palette.
    let scene = sample(1500, 1);
    for target in Target::ALL {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| write(&scene, target).unwrap().files)
        };
        assert_eq!(with(1), with(5), "{target:?}");
    }
}

#[test]
fn opacities_beyond_a_byte_are_counted() {
    let mut scene = sample(10, 0);
    scene.logit_opacities[2] = 14.0;
    scene.logit_opacities[5] = -300.0;
    for target in [Target::CompressedPly, Target::Spz, Target::Sog] {
        let export = write(&scene, target).unwrap();
        assert_eq!(export.fidelity.opacity.clamped, 2, "{target:?}");
        let held = read_back(&export).gaussians.logit_opacities;
        assert!(sigmoid(held[2]) > 0.999_998 && sigmoid(held[5]) < 2e-6);
    }
    assert_eq!(write(&scene, Target::Ply).unwrap().fidelity.opacity.clamped, 0);
}

#[test]
fn names_of_formats_and_files() {
    for target in Target::ALL {
        assert_eq!(Target::from_name(target.name()), Some(target));
    }
    let cases = [
        ("a.ply", Some(Target::Ply)),
        ("A.PLY", Some(Target::Ply)),
        ("a.compressed.ply", Some(Target::CompressedPly)),
        ("a.spz", Some(Target::Spz)),
        ("a.sog", Some(Target::Sog)),
        ("meta.json", Some(Target::SogFolder)),
        ("my-meta.json", None),
        ("a.splat", None),
        ("", None),
    ];
    for (name, target) in cases {
        assert_eq!(Target::of_file_name(name), target, "{name}");
    }
}
