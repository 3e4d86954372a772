//! Foveated models on the screen of their viewer.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use powergs_sim::scene::write_ply;
use powergs_testkit::foveated::levels;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::{contains, is_empty};

/// Runs the program in a folder.
fn program(folder: &Path, words: &str) -> Assert {
    let mut command = Command::cargo_bin("powergs-sim").expect("the program was built");
    command.current_dir(folder).args(words.split_whitespace()).assert()
}

/// Makes `model.fov`.
fn compose(folder: &Path) {
    for (k, part) in levels(1, 60, 1, 0.6).iter().enumerate() {
        let mut bytes = Vec::new();
        write_ply(part, &mut bytes).expect("memory");
        fs::write(folder.join(format!("L{}.ply", k + 1)), bytes).expect("a folder");
    }
    program(folder, "scene compose L1.ply L2.ply L3.ply L4.ply -o model.fov").success();
}

/// The screen of the first frame of a trace, degrees.
fn screen_deg(folder: &Path, trace: &str) -> f64 {
    let done = program(folder, &format!("trace dump {trace} --frame 0 --what facts")).success();
    let facts = String::from_utf8(done.get_output().stdout.clone()).expect("UTF-8");
    let row = facts.lines().find_map(|line| line.strip_prefix("screen_fov_deg,"));
    row.expect("a foveated frame").parse().expect("a number")
}

/// All levels of a small image, seen by a camera of 40 degrees.
const SEEN: &str = "model.fov --orbit 1 --size 96x64 --orbit-radius 6 --fov 40 --gaze 0.5,0.5 \
                    --pooling-rate 2";

#[test]
fn a_camera_of_40_degrees_was_shown_on_a_screen_of_90() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    compose(at);
    program(at, &format!("extract {SEEN} -o own.bin")).success().stderr(is_empty());
    assert!((screen_deg(at, "own.bin") - 40.0).abs() < 1e-6);
    let named = "the screen is 90.0 degrees wide, but the camera of view";
    let given = format!("extract {SEEN} --screen powergs -o given.bin");
    program(at, &given).success().stderr(contains(named).and(contains("sees 40.0")));
    assert_eq!(screen_deg(at, "given.bin"), 90.0);
    // One that is as wide as the camera sees is no news, nor are frames that are wanted quiet.
    program(at, &format!("extract {SEEN} --screen 40.5 -o near.bin")).success().stderr(is_empty());
    let quiet = format!("-q render {SEEN} --screen powergs -o a.png");
    program(at, &quiet).success().stderr(is_empty());
    let shown = format!("render {SEEN} --screen powergs -o b.png");
    program(at, &shown).success().stderr(contains(named));
}

#[test]
fn a_picture_without_a_camera_was_90_degrees_wide_silently() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    compose(at);
    program(at, &format!("render {SEEN} -o a.png")).success();
    let said = || contains("taken as 90 degrees wide");
    program(at, "filter a.png -o b.png").success().stderr(said());
    program(at, "filter a.png --fov 40 -o c.png").success().stderr(is_empty());
    program(at, "quality a.png b.png --gaze 0.5,0.5").success().stderr(said());
    program(at, "quality a.png b.png --gaze 0.5,0.5 --fov 40").success().stderr(is_empty());
    program(at, "quality a.png b.png").success().stderr(is_empty());
}
