//! Sizes are compared with `--memory` before anything is allocated: small files that ask for much.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use powergs_testkit::bombs::huge_webp;
use powergs_testkit::scene_files::{ply, sample};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

/// The program in 2 GB of address space, so that an allocation that is not refused ends it.
fn run(folder: &Path, words: &[&str]) -> Assert {
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 2000000; exec \"$0\" \"$@\""]);
    command.arg(env!("CARGO_BIN_EXE_powergs-sim")).current_dir(folder).args(words).assert()
}

#[cfg(target_os = "linux")]
#[test]
fn pictures_are_measured_before_they_are_decoded() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.webp"), huge_webp()).unwrap();
    let refused = contains("p.webp: a picture of 16383x16383 pixels takes about 5.0 GiB")
        .and(contains("allow more with --memory \"5 GiB\""));
    run(folder.path(), &["display", "p.webp"]).code(3).stderr(refused);
    run(folder.path(), &["filter", "p.webp", "--gaze", "0.5,0.5"]).code(3);
    run(folder.path(), &["quality", "p.webp", "p.webp"]).code(3);
    // With the memory that is asked for it is decoded, and found damaged.
    let allowed = run(folder.path(), &["display", "p.webp", "--memory", "6 GiB"]).code(3);
    allowed.stderr(contains("--memory").not());
}

#[cfg(target_os = "linux")]
#[test]
fn frames_are_measured_before_they_are_rendered() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.ply"), ply(&sample(40, 1))).unwrap();
    let size = ["a.ply", "--orbit", "1", "--size", "60000x60000", "-o"];
    let extract = run(folder.path(), &[&["extract"], &size[..], &["x.bin"]].concat()).code(2);
    extract.stderr(contains("60000x60000 pixels takes about").and(contains("--memory")));
    let render = run(folder.path(), &[&["render"], &size[..], &["x.png"]].concat()).code(2);
    render.stderr(contains("60000x60000 pixels takes about").and(contains("--memory")));
    assert!(!folder.path().join("x.bin").exists() && !folder.path().join("x.png").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn pairs_are_counted_before_lists_are_built() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = sample(60, 0);
    scene.log_scales.iter_mut().flatten().for_each(|s| *s = 3.0);
    fs::write(folder.path().join("a.ply"), ply(&scene)).unwrap();
    let words = ["extract", "a.ply", "--orbit", "1", "--size", "640x480", "-o", "a.bin", "-q"];
    run(folder.path(), &words).success();
    for command in [&["replay", "a.bin"][..], &["replay", "a.bin", "--model", "paper"]] {
        let words = [command, &["--memory", "3 MiB"]].concat();
        let refused = run(folder.path(), &words).code(3);
        refused.stderr(contains("(splat, tile) pairs").or(contains("frame orbit_0000")));
    }
    run(folder.path(), &["replay", "a.bin", "--out", "r", "-q"]).success();
}

#[cfg(target_os = "linux")]
#[test]
fn a_frame_is_measured_before_it_is_decoded() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.ply"), ply(&sample(40, 1))).unwrap();
    let words = ["extract", "a.ply", "--orbit", "1", "--size", "640x480", "-o", "a.bin", "-q"];
    run(folder.path(), &words).success();
    let told = || contains("of memory, and 1 MiB are allowed").and(contains("--memory"));
    for command in [&["trace", "dump", "a.bin", "--frame", "0"][..], &["replay", "a.bin"]] {
        let refused = run(folder.path(), &[command, &["--memory", "1 MiB"]].concat()).code(3);
        refused.stderr(told());
    }
    let verified = run(folder.path(), &["trace", "verify", "a.bin", "--memory", "1 MiB"]).code(3);
    verified.stdout(told());
    run(folder.path(), &["trace", "verify", "a.bin"]).success();
}
