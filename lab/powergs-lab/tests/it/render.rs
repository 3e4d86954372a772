//! `render --datapath`: pictures of the rendering hardware.

use std::fs;

use assert_cmd::Command;
use powergs_testkit::scene_files::{ply, sample};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

#[test]
fn a_picture_of_the_hardware_is_compared_with_that_of_f32() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("a.ply"), ply(&sample(60, 1))).expect("a scene");
    let run = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-lab"));
        command.current_dir(folder.path()).args(["render", "a.ply", "--orbit", "2"]);
        command.args(["--size", "96x64"]).args(words).assert()
    };
    let measured = |datapath: &str| -> Vec<f64> {
        let done = run(&["--datapath", datapath, "-o", datapath, "--json"]).success();
        let report: serde_json::Value =
            serde_json::from_slice(&done.get_output().stdout).expect("JSON");
        let images = report["images"].as_array().expect("images");
        images.iter().map(|image| image["psnr_db"].as_f64().expect("a number")).collect()
    };
    let (all, fp16, fp8) = (measured("gscore-fp16"), measured("e5m10"), measured("e4m3"));
    assert_eq!(fp16.len(), 2);
    for (fp16, fp8) in fp16.iter().zip(&fp8) {
        assert!(*fp16 > 40.0 && fp8 < fp16, "{fp16} and {fp8} dB");
    }
    // All units together are another picture than cores behind an exact projection, and as good.
    assert!(all.iter().zip(&fp16).all(|(all, cores)| *all > 40.0 && all != cores), "{all:?}");
    for form in ["e5m10-conic", "e5m10-mean"] {
        let other = measured(form);
        assert!(other.iter().zip(&fp16).all(|(other, root)| *other > 40.0 && other != root));
    }
    let shown = contains("orbit_0000: PSNR ").and(contains(" dB, SSIM ")).and(contains(", FLIP "));
    run(&["--datapath", "gscore-fp16", "-o", "one", "--frames", "0..1"]).success().stdout(shown);

    for (name, why) in [
        ("fp16", "`fp16` is not a number format"),
        ("fp16", "or write gscore-fp16"),
        ("e5m12", "8 to 16 bits"),
        ("gscore-fp16-mean", "`gscore-fp16` is not a number format"),
        ("e3m4", "four bits of exponent"),
    ] {
        run(&["--datapath", name, "-o", "no"]).code(2).stderr(contains(why));
        assert!(!folder.path().join("no").exists());
    }
}
