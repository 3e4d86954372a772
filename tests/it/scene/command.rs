//! `scene info` and `scene convert` as a user meets them.

use assert_cmd::Command;
use powergs_sim::scene::files::open_model;
use powergs_testkit::scene_files::{self as encode, sample};
use serde_json::Value;

fn program() -> Command {
    Command::cargo_bin("powergs-sim").expect("the program was built")
}

#[test]
fn info_prints_lines_within_80_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ply");
    let mut scene = sample(100, 3);
    scene.means[3][0] = f32::NAN;
    std::fs::write(&path, encode::ply(&scene)).unwrap();
    let run = program().args(["scene", "info"]).arg(&path).assert().success();
    let text = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    for part in ["points", "99", "SH degree", "percentiles", "warning:  1 Gaussian dropped"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
}

#[test]
fn info_as_json() {
    let folder = tempfile::tempdir().unwrap();
    // The name says nothing: formats are recognised by content.
    let path = folder.path().join("scene.dat");
    std::fs::write(&path, encode::spz(&sample(50, 1), 3, &[])).unwrap();
    let run = program().args(["scene", "info", "--json"]).arg(&path).assert().success();
    let facts: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(facts["points"], 50);
    assert_eq!(facts["sh_degree"], 1);
    assert_eq!(facts["format"], "spz v3");
    assert_eq!(facts["memory_bytes"], 50 * (11 + 12) * 4);
    assert_eq!(facts["bounds"]["min"].as_array().unwrap().len(), 3);
    for percentile in ["p1", "p5", "p25", "p50", "p75", "p95", "p99"] {
        assert!(facts["opacity"][percentile].is_f64() && facts["scale"][percentile].is_f64());
    }
    assert!(facts["share_opacity_below_0_35"].is_f64());
    assert!(facts["share_axis_ratio_at_least_3"].is_f64());
    assert!(facts["warnings"].is_array());
}

#[test]
fn convert_writes_what_was_read() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in"), folder.path().join("out.ply"));
    std::fs::create_dir(&input).unwrap();
    for (name, bytes) in encode::sog(&sample(50, 2), 2) {
        std::fs::write(input.join(name), bytes).unwrap();
    }
    program().args(["scene", "convert"]).arg(&input).arg(&output).assert().success();
    let (before, after) = (open_model(&input, None).unwrap(), open_model(&output, None).unwrap());
    assert_eq!(before.gaussians, after.gaussians);
    assert_eq!((before.format, after.format), ("sog v2", "ply"));
    assert!(before.path.ends_with("in/meta.json"));
}

#[test]
fn failures_name_the_file_and_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.ply");
    let whole = encode::ply(&sample(9, 0));
    std::fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    let output = folder.path().join("out.ply");
    let run = program().args(["scene", "convert"]).arg(&path).arg(&output).assert().code(3);
    let text = String::from_utf8(run.get_output().stderr.clone()).unwrap();
    assert!(text.contains("cut.ply: PLY element `vertex`: the header promises 9 rows"), "{text}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the input is there");
    let cases = [("nothing.ply", 3, "No such file"), ("", 3, "without meta.json")];
    for (name, code, message) in cases {
        let path = folder.path().join(name);
        let run = program().args(["scene", "info"]).arg(&path).assert().code(code);
        let text = String::from_utf8(run.get_output().stderr.clone()).unwrap();
        assert!(text.contains(message), "{text}");
    }
    std::fs::write(&path, &whole).unwrap();
    program().args(["scene", "info", "--detail", "1"]).arg(&path).assert().code(2);
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_and_a_name_that_is_no_text_is_read() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.ply");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // Nobody writes: opening it would wait for ever.
    let mut command = program();
    command.timeout(std::time::Duration::from_secs(60));
    let refused = command.args(["scene", "info"]).arg(&pipe).assert().code(3);
    refused.stderr(predicates::str::contains("not a regular file"));
    let mut command = program();
    command.timeout(std::time::Duration::from_secs(60));
    let refused = command.arg("replay").arg(&pipe).assert().code(3);
    refused.stderr(predicates::str::contains("not a regular file"));
    let name = folder.path().join(std::ffi::OsStr::from_bytes(b"sc\xffne.ply"));
    std::fs::write(&name, encode::ply(&sample(5, 0))).unwrap();
    program().args(["scene", "info"]).arg(&name).assert().success();
}
