//! Models whose numbers are others than those that their format says.

use powergs_scene::{Gaussians, OneFile, ReadAs, StoredAxes, Warning, read_as};
use powergs_testkit::scene_files::{ply, sample, spz};

use crate::scene::read_bytes;

fn warnings(scene: &Gaussians) -> Vec<Warning> {
    read_bytes(&ply(scene)).unwrap().warnings
}

fn sigmoid(logit: f32) -> f32 {
    1.0 / (1.0 + (-logit).exp())
}

/// Exporters that apply the sigmoid to opacities and leave scales alone; trainers that have the
/// absolute value in place of a sigmoid.
#[test]
fn half_activated_models_are_warned_of() {
    let mut after_sigmoid = sample(24, 0);
    after_sigmoid.logit_opacities.iter_mut().for_each(|o| *o = sigmoid(*o));
    assert_eq!(warnings(&after_sigmoid), [Warning::ActivatedOpacities]);
    let mut absolute = after_sigmoid.clone();
    absolute.logit_opacities.iter_mut().step_by(7).for_each(|o| *o = -*o);
    assert_eq!(warnings(&absolute), [Warning::ActivatedOpacities]);
    let mut linear_scales = sample(24, 0);
    linear_scales.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s = s.exp());
    assert_eq!(warnings(&linear_scales), [Warning::ActivatedScales]);
}

#[test]
fn models_as_they_are_trained_pruned_and_begun_are_not() {
    let with = |count: usize, opacity: fn(usize) -> f32| {
        let mut scene = sample(count, 0);
        scene.logit_opacities.iter_mut().enumerate().for_each(|(i, o)| *o = opacity(i));
        scene
    };
    assert_eq!(warnings(&sample(200, 1)), []);
    // Only what is opaque was kept.
    assert_eq!(warnings(&with(40, |i| 1.2 + 0.1 * i as f32)), []);
    // Before the first step all are the same: 0.1, or a half.
    assert_eq!(warnings(&with(40, |_| -2.197)), []);
    assert_eq!(warnings(&with(40, |_| 0.0)), []);
    // Two fifths in the middle, as in the faintest of trained scenes.
    assert_eq!(warnings(&with(40, |i| if i % 5 < 2 { 0.3 } else { -2.0 })), []);
    // Too few to tell.
    assert_eq!(warnings(&with(8, |i| 0.1 * i as f32)), []);
    // Millimetres: nearly all logarithms are above 0, and they differ.
    let mut large = sample(200, 0);
    large.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s += 6.5);
    assert_eq!(warnings(&large), []);
}

/// A model whose activations were applied, and in which one scale and one opacity went wrong.
#[test]
fn one_negative_scale_does_not_make_a_model_of_raw_parameters() {
    let mut scene = sample(40, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o = sigmoid(*o));
    scene.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s = s.exp());
    scene.log_scales[7][2] = -0.1;
    scene.logit_opacities[9] = -0.1;
    assert_eq!(warnings(&scene), [Warning::Activated]);
}

/// The library of SPZ writes the axes of the PLY that it was given unless it is told others.
#[test]
fn axes_of_a_file_can_be_said() {
    let scene = sample(40, 2);
    let as_of = |bytes: &[u8], axes: &str| {
        let known = ReadAs { detail: None, axes: Some(axes.parse().unwrap()) };
        read_as(&OneFile(bytes), "bytes", known).unwrap().gaussians
    };
    for version in 1..=4 {
        let bytes = spz(&scene, version, &[]);
        let plain = read_bytes(&bytes).unwrap().gaussians;
        assert_eq!(as_of(&bytes, "rub"), plain);
        let own = as_of(&bytes, "ply");
        let worst = own.means.as_flattened().iter().zip(scene.means.as_flattened());
        let worst = worst.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst < 2e-3, "version {version}: {worst}");
        assert_eq!(own.means[3], turned_over(plain.means[3]));
    }
    // A record of the file is overruled, too: 6 are the axes of PLY.
    let record = [&0xadbe_0003_u32.to_le_bytes()[..], &[4, 0, 0, 0], &[6, 0, 0, 0]].concat();
    let (said, silent) = (spz(&scene, 4, &record), spz(&scene, 4, &[]));
    assert_eq!(read_bytes(&said).unwrap().gaussians, as_of(&silent, "rdf"));
    assert_eq!(as_of(&said, "rub"), read_bytes(&silent).unwrap().gaussians);
    // Other formats have axes, too; twice is not at all.
    let turned = as_of(&ply(&scene), "rub");
    assert_eq!(turned.means[3], turned_over(scene.means[3]));
    assert_eq!(as_of(&ply(&turned), "rub"), scene);
    assert_eq!(as_of(&ply(&scene), "RDF"), scene);
    assert_eq!("rub".parse::<StoredAxes>().unwrap().to_string(), "rub");
    for bad in ["", "rd", "rdfx", "rrr", "dfr", "xyz", "r,d,f"] {
        assert!(bad.parse::<StoredAxes>().is_err(), "{bad}");
    }
}

/// Half a turn about x.
fn turned_over([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, -y, -z]
}
