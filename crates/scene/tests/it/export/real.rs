//! Trained models: what the formats of other programs lose of them.

use powergs_scene::export::{Target, write};
use powergs_scene::files::open_model;
use powergs_testkit::data;

#[test]
fn a_trained_model_in_every_format() {
    let Some(data) = data() else { return };
    let scene = open_model(&data.join("snowmiku-posed/point_cloud.ply"), None).unwrap().gaussians;
    let mut part = scene.clone();
    // A part, so that the test is quick without optimisation.
    let count = 2500;
    part.means.truncate(count);
    part.log_scales.truncate(count);
    part.rotations.truncate(count);
    part.logit_opacities.truncate(count);
    part.sh.truncate(count * 48);
    for target in Target::ALL {
        let export = write(&part, target).unwrap();
        let kept = export.fidelity;
        println!("{}: {} bytes, {kept:#?}", target.name(), export.files.bytes());
        assert_eq!(kept.is_exact(), target == Target::Ply);
        assert!(kept.position.rms < 2e-3 && kept.rotation.rms < 0.5, "{target:?}: {kept:?}");
        assert!(kept.scale.rms < 0.03 && kept.opacity.rms < 0.0025, "{target:?}: {kept:?}");
        assert!(kept.colour_dc.rms < 0.01 && kept.colour_rest.rms < 0.02, "{target:?}: {kept:?}");
    }
}

#[test]
fn a_model_that_another_program_wrote_as_sog_is_held() {
    let Some(data) = data() else { return };
    let scene = open_model(&data.join("playcanvas-playbot/6_0"), None).unwrap().gaussians;
    let kept = write(&scene, Target::Sog).unwrap().fidelity;
    // Its codebooks and its palette have entries for all values; positions are 16 bits between
    // bounds that are found again, but for single precision.
    assert!(kept.scale.exact && kept.opacity.exact && kept.colour_dc.exact, "{kept:?}");
    assert!(kept.colour_rest.exact && kept.rotation.exact, "{kept:?}");
    assert!(kept.position.largest < 1e-4, "{kept:?}");
}
