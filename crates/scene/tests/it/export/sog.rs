//! SOG: codebooks and palettes that hold few values exactly, and many well.

use powergs_scene::convert::logit;
use powergs_scene::export::{FOLDER_FILES, Files, Target, write};
use powergs_scene::{Format, Gaussians};
use powergs_testkit::scene_files::{Files as Named, sample, zipped};
use proptest::prelude::*;
use serde_json::Value;

use super::{read_back, twice};
use crate::scene::read_bytes;

fn folder(scene: &Gaussians) -> Named {
    match write(scene, Target::SogFolder).unwrap().files {
        Files::Folder(files) => files,
        Files::One(_) => panic!("a folder"),
    }
}

/// A model whose scales and colours have at most `kinds` different values each.
fn with_few_values(count: usize, degree: u8, kinds: u32) -> Gaussians {
    let mut scene = sample(count, degree);
    let mut state = 7_u32;
    let mut pick = |low: f32, high: f32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // No number that a decimal of a few digits would hold.
        low + (high - low) * ((state >> 8) % kinds) as f32 / (kinds - 1) as f32 + 0.1 / 3.0
    };
    scene.log_scales.as_flattened_mut().iter_mut().for_each(|v| *v = pick(-9.0, 1.0));
    scene.sh.iter_mut().for_each(|v| *v = pick(-1.0, 1.0));
    scene.logit_opacities.iter_mut().for_each(|v| *v = logit(f64::from(pick(0.0, 0.9))));
    scene
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn few_values_are_held_to_the_last_bit(
        count in 1..900_usize, degree in 0..=3_u8, kinds in 2..=256_u32,
    ) {
        let scene = with_few_values(count, degree, kinds);
        let export = write(&scene, Target::Sog).unwrap();
        let held = read_back(&export).gaussians;
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(scene.sh.as_slice()), bits(&held.sh));
        let [before, after] = [&scene, &held].map(|s| bits(s.log_scales.as_flattened()));
        prop_assert_eq!(before, after);
        let kept = export.fidelity;
        prop_assert!(kept.scale.exact && kept.colour_dc.exact && kept.colour_rest.exact);
    }
}

#[test]
fn a_folder_and_a_bundle_hold_the_same() {
    for degree in 0..=3 {
        let scene = sample(777, degree);
        let files = folder(&scene);
        assert!(files.keys().all(|name| FOLDER_FILES.contains(&name.as_str())));
        assert_eq!(files.len(), if degree == 0 { 6 } else { 8 });
        let in_folder = read_back(&write(&scene, Target::SogFolder).unwrap());
        let bundled = read_back(&write(&scene, Target::Sog).unwrap());
        assert_eq!((in_folder.format, bundled.format), (Format::Sog(2), Format::Sog(2)));
        assert_eq!(in_folder.gaussians, bundled.gaussians);
        assert_eq!(read_bytes(&zipped(&files)).unwrap().gaussians, bundled.gaussians);
    }
}

#[test]
fn the_index_is_that_of_version_2() {
    let files = folder(&sample(1000, 2));
    let meta: Value = serde_json::from_slice(&files["meta.json"]).unwrap();
    assert_eq!((&meta["version"], &meta["count"]), (&2.into(), &1000.into()));
    assert_eq!(meta["shN"]["bands"], 2);
    // The largest power of two that is not above the number of Gaussians.
    assert_eq!(meta["shN"]["count"], 512);
    for part in ["scales", "sh0", "shN"] {
        let book: Vec<f64> = serde_json::from_value(meta[part]["codebook"].clone()).unwrap();
        assert_eq!(book.len(), 256);
        assert!(book.is_sorted(), "{part}");
    }
}

#[test]
fn the_second_time_bytes_are_held() {
    let (once, _, again, second) = twice(&sample(900, 3), Target::Sog);
    assert!(second.scale.exact && second.rotation.exact && second.opacity.exact);
    assert!(second.colour_dc.exact && second.colour_rest.exact);
    assert_eq!(once.sh, again.sh);
    assert!(second.position.largest < 1e-6, "{:?}", second.position);
}

#[test]
fn codebooks_follow_the_values() {
    // Most scales lie close together and a few far away: evenly spaced steps would be 40 / 255.
    let mut scene = sample(5000, 0);
    scene.log_scales[7] = [-40.0, 0.0, 0.0];
    let kept = write(&scene, Target::Sog).unwrap().fidelity.scale;
    // 15,000 numbers over a range of 4: even steps of 4 / 255, whose error is a step over √12.
    assert!(kept.rms < 1.1 * 4.0 / 255.0 / 12_f64.sqrt(), "{kept:?}");
    assert!(kept.largest < 0.02, "{kept:?}");
}

#[test]
fn palettes_find_groups() {
    // 9,000 vectors around 400 places: fewer than the 8,192 entries, so that nothing is merged
    // that does not belong together.
    let places = sample(400, 3);
    let mut scene = sample(9000, 3);
    for i in 0..scene.len() {
        let place = places.sh_of(i * 31 % 400);
        for (c, (value, centre)) in scene.sh[48 * i..48 * (i + 1)].iter_mut().zip(place).enumerate()
        {
            *value = centre + 0.001 * ((i + c) % 7) as f32;
        }
    }
    let kept = write(&scene, Target::Sog).unwrap().fidelity.colour_rest;
    // The codebook's steps, 1.8 / 255, and the groups' own width.
    assert!(kept.rms < 0.004 && kept.largest < 0.02, "{kept:?}");
}

#[test]
fn more_vectors_than_entries_with_few_values() {
    // 70,000 Gaussians with as many different vectors: labels have 16 bits.
    let scene = with_few_values(70_000, 1, 251);
    let kept = write(&scene, Target::Sog).unwrap().fidelity;
    assert!(kept.scale.exact && kept.colour_dc.exact && !kept.colour_rest.exact);
    assert!(kept.colour_rest.rms < 0.1, "{:?}", kept.colour_rest);
    // With no more different vectors than labels, all are held.
    let mut few = scene.clone();
    for (i, sh) in few.sh.chunks_exact_mut(12).enumerate() {
        sh.copy_from_slice(scene.sh_of(i * 7 % 60_000));
    }
    assert!(write(&few, Target::Sog).unwrap().fidelity.colour_rest.exact);
}
