//! Models that a format cannot hold: an error that says so, and never a model that is another.

use powergs_scene::Gaussians;
use powergs_scene::export::{ExportError, Target, write};
use powergs_testkit::scene_files::sample;

fn refused(scene: &Gaussians) -> Vec<ExportError> {
    Target::ALL.map(|target| write(scene, target).expect_err("a hostile model")).into()
}

/// A change that makes a sound model of degree 1 a hostile one.
type Damage = fn(&mut Gaussians);

#[test]
fn models_that_no_reader_gives_back_are_refused_by_every_format() {
    let cases: [(Damage, &str); 14] = [
        (|s| *s = Gaussians::default(), "no Gaussians"),
        (|s| s.sh_degree = 4, "SH degree 4"),
        (|s| s.sh_degree = 255, "SH degree 255"),
        (|s| s.sh_degree = 2, "sh has 48 entries instead of 108"),
        (|s| s.rotations.truncate(3), "rotations has 3 entries instead of 4"),
        (|s| s.log_scales.push([0.0; 3]), "log_scales has 5 entries instead of 4"),
        (|s| s.logit_opacities.clear(), "logit_opacities has 0 entries"),
        (|s| s.means[2][1] = f32::NAN, "Gaussian 2 has a parameter that is NaN"),
        (|s| s.means[3][0] = f32::INFINITY, "Gaussian 3"),
        (|s| s.log_scales[1][2] = 41.0, "Gaussian 1"),
        (|s| s.log_scales[1][2] = f32::NEG_INFINITY, "Gaussian 1"),
        (|s| s.logit_opacities[0] = f32::NAN, "Gaussian 0"),
        (|s| s.sh[47] = 2e15, "Gaussian 3"),
        (|s| s.rotations[2] = [0.0; 4], "Gaussian 2 has a rotation of length zero"),
    ];
    for (damage, message) in cases {
        let mut scene = sample(4, 1);
        damage(&mut scene);
        for error in refused(&scene) {
            let text = error.to_string();
            assert!(text.contains(message), "{message}: {text}");
        }
    }
}

#[test]
fn positions_beyond_spz_are_an_error_and_not_moved() {
    let mut scene = sample(4, 0);
    scene.means[2][1] = -8_388_607.0;
    let kept = write(&scene, Target::Spz).unwrap().fidelity.position;
    assert_eq!(kept.clamped, 0);
    assert!(kept.largest <= 0.5, "steps of one: {kept:?}");
    scene.means[2][1] = -8_388_608.0;
    let error = write(&scene, Target::Spz).expect_err("25 bits");
    assert!(matches!(error, ExportError::Position { index: 2, .. }));
    let text = error.to_string();
    assert!(text.contains("Gaussian 2 is at -8.388608e6, and spz holds"), "{text}");
    assert!(text.contains("8388607") && text.contains("write SOG or PLY"), "{text}");
    for target in [Target::Ply, Target::CompressedPly, Target::Sog] {
        let kept = write(&scene, target).unwrap().fidelity.position;
        assert!(kept.largest < 8_388_608.0 / 1000.0, "{target:?}: {kept:?}");
    }
}

#[test]
fn the_largest_numbers_of_a_sound_model_are_held() {
    let mut scene = sample(400, 3);
    scene.means[0] = [1e15, -1e15, 1e15];
    scene.log_scales[1] = [40.0, -3e38, f32::MIN_POSITIVE];
    scene.rotations[2] = [1e15, -1e15, 1e-30, 1e15];
    scene.logit_opacities[3] = -3e38;
    scene.sh[100] = 1e15;
    scene.sh[96] = -1e15;
    for target in [Target::Ply, Target::CompressedPly, Target::Sog, Target::SogFolder] {
        let kept = write(&scene, target).unwrap().fidelity;
        assert!(kept.named().iter().all(|(_, kept)| kept.largest.is_finite()), "{kept:?}");
        if target != Target::CompressedPly {
            // The others keep their digits: numbers far away have entries of their own.
            assert!(kept.scale.largest < 0.2 || target == Target::Ply, "{kept:?}");
        }
    }
}

#[test]
fn one_gaussian_is_a_model() {
    for degree in 0..=3 {
        let scene = sample(1, degree);
        for target in Target::ALL {
            let kept = write(&scene, target).unwrap().fidelity;
            // Formats that keep no logarithms, or round to steps that are always the same.
            let rounds =
                matches!(target, Target::Spz | Target::GlbSpz | Target::Gltf | Target::Glb);
            assert!(rounds || kept.position.exact && kept.scale.exact, "{target:?}: {kept:?}");
        }
    }
}

#[test]
fn counts_beyond_a_format_are_known() {
    assert_eq!(Target::Spz.most(), 10_000_000);
    assert_eq!(Target::Sog.most(), 16_384 * 16_384);
    assert_eq!(Target::Ply.most(), 1 << 31);
    let error = ExportError::TooMany { count: 11_000_000, most: 10_000_000, format: "spz" };
    assert!(error.to_string().contains("11000000 Gaussians, and spz holds at most 10000000"));
}

#[test]
fn a_file_that_our_reader_takes_for_a_bomb_is_not_made() {
    // Equal Gaussians: the stream is so small that nobody would believe its count.
    let one = sample(1, 3);
    let mut scene = Gaussians { sh_degree: 3, ..Gaussians::default() };
    for _ in 0..150_000 {
        scene.append(one.clone());
    }
    let error = write(&scene, Target::Spz).expect_err("a bomb");
    assert!(matches!(error, ExportError::NotReadBack(_)), "{error}");
    assert!(error.to_string().contains("write INRIA PLY"), "{error}");
}
