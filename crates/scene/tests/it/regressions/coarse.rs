//! Positions that numbers cannot hold: of a map in single precision, of formats with steps.

use powergs_scene::export::{Target, write};
use powergs_scene::{Gaussians, Warning};
use powergs_testkit::scene_files::{ply, sample};

use crate::scene::read_bytes;

fn moved(scene: &Gaussians, by: [f32; 3]) -> Gaussians {
    let mut scene = scene.clone();
    for mean in &mut scene.means {
        mean.iter_mut().zip(by).for_each(|(v, by)| *v += by);
    }
    scene
}

/// Metres of a map (UTM): single precision has steps of half a metre there.
#[test]
fn coordinates_of_a_map_are_warned_of_with_their_step() {
    let scene = sample(24, 0);
    let map = moved(&scene, [500_123.0, 4_649_776.5, 103.75]);
    let warnings = read_bytes(&ply(&map)).unwrap().warnings;
    let [Warning::CoarsePositions { count: 24, step: 0.5, origin }] = &warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!((origin[1] - 4_649_776.0).abs() <= 2.0, "{origin:?}");
    let text = warnings[0].to_string();
    assert!(text.contains("resolved to 0.5 world units"), "{text}");
    // A kilometre away is near enough for Gaussians of millimetres, and so is one far away.
    let mut far = moved(&scene, [1000.0; 3]);
    assert_eq!(read_bytes(&ply(&far)).unwrap().warnings, []);
    far.means[3] = [1e9, 0.0, 0.0];
    assert_eq!(read_bytes(&ply(&far)).unwrap().warnings, []);
    // Where Gaussians are large, steps are no loss.
    let mut large = map;
    large.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s += 9.0);
    assert_eq!(read_bytes(&ply(&large)).unwrap().warnings, []);
}

/// One Gaussian far away costs all others their places.
#[test]
fn one_far_gaussian_is_named_by_every_format_that_has_steps() {
    let scene = sample(400, 0);
    let mut far = scene.clone();
    far.means[7] = [2e6, 0.0, 3.0];
    for target in Target::ALL {
        assert_eq!(write(&scene, target).unwrap().displaced, None, "{target:?}");
    }
    for target in [Target::Spz, Target::GlbSpz, Target::CompressedPly] {
        let displaced = write(&far, target).unwrap().displaced.expect("positions are lost");
        let apart = displaced.apart.expect("one is far from the others");
        assert_eq!((apart.count, apart.farthest), (1, 7), "{target:?}");
        assert!(apart.distance > 1.9e6 && apart.others < 2.0, "{target:?}: {apart:?}");
        assert!(displaced.count >= 200 && displaced.of == 400, "{target:?}: {displaced:?}");
        let text = displaced.to_string();
        assert!(text.contains("1 Gaussian lies far") && text.contains("#7"), "{text}");
    }
    for target in [Target::Ply, Target::Gltf, Target::Glb] {
        assert_eq!(write(&far, target).unwrap().displaced, None, "{target:?}");
    }
}
