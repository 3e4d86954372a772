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

/// A folder with `scene.ply`, a model of 700 Gaussians.
fn folder_with_a_model() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scene.ply"), encode::ply(&sample(700, 2))).unwrap();
    folder
}

/// Runs `scene convert` in a folder.
fn convert(folder: &tempfile::TempDir, words: &str) -> assert_cmd::assert::Assert {
    let words = ["scene", "convert"].into_iter().chain(words.split_whitespace());
    program().current_dir(folder.path()).args(words).assert()
}

#[test]
fn the_name_says_the_format_and_the_table_what_was_lost() {
    let folder = folder_with_a_model();
    for (output, format, said) in [
        ("a.compressed.ply", "compressed ply", "compressed-ply"),
        ("a.SPZ", "spz v3", "spz"),
        ("a.sog", "sog v2", "sog"),
        ("a/meta.json", "sog v2", "sog-folder"),
        ("b/", "sog v2", "sog-folder"),
        ("c", "sog v2", "sog-folder"),
        ("d.dat --format spz", "spz v3", "spz"),
        ("e.ply --format sog", "sog v2", "sog"),
    ] {
        let run = convert(&folder, &format!("scene.ply {output}")).success();
        let text = String::from_utf8(run.get_output().stdout.clone()).unwrap();
        let name = output.split_whitespace().next().unwrap();
        assert!(text.starts_with(name.trim_end_matches("/meta.json")), "{text}");
        assert!(text.contains(&format!(": 700 Gaussians, SH degree 2, {said}, 0.0")), "{text}");
        for part in ["largest error", "rms error", "clamped", "position, world units", "degrees"] {
            assert!(text.contains(part), "no {part} in {text}");
        }
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        let model = open_model(&folder.path().join(name), None).unwrap();
        assert_eq!((model.format, model.gaussians.len()), (format, 700));
    }
    let plain = convert(&folder, "scene.ply copy.ply").success();
    plain.stdout("copy.ply: 700 Gaussians, SH degree 2, ply, 0.12 MB, nothing lost\n");
    convert(&folder, "scene.ply f.sog -q").success().stdout("");
}

#[test]
fn what_was_lost_as_json() {
    let folder = folder_with_a_model();
    let run = convert(&folder, "scene.ply a.spz --json").success();
    let facts: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!((&facts["file"], &facts["format"]), (&"a.spz".into(), &"spz".into()));
    assert_eq!((&facts["points"], &facts["sh_degree"]), (&700.into(), &2.into()));
    let size = std::fs::metadata(folder.path().join("a.spz")).unwrap().len();
    assert_eq!((&facts["bytes"], &facts["exact"]), (&size.into(), &false.into()));
    for field in ["position", "scale", "rotation", "opacity", "colour_dc", "colour_rest"] {
        let kept = &facts["kept"][field];
        assert!(kept["largest"].as_f64().unwrap() >= kept["rms"].as_f64().unwrap(), "{field}");
        assert_eq!(kept["clamped"], 0, "{field}");
        // Positions of 23 bits behind the point may be held to the last.
        assert!(field == "position" || kept["exact"] == false, "{field}");
    }
    // What came out of a file of the format goes back into one as it is.
    let run = convert(&folder, "a.spz b.spz --json").success();
    let facts: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(facts["exact"], true);
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("a.spz"), bytes("b.spz"));
}

#[test]
fn a_name_that_says_nothing_and_a_model_that_does_not_fit() {
    let folder = folder_with_a_model();
    let refused = convert(&folder, "scene.ply a.splat").code(2);
    refused.stderr(predicates::str::contains("give --format (ply, compressed-ply, spz, gltf"));
    let mut far = sample(3, 0);
    far.means[1][2] = 1e9;
    std::fs::write(folder.path().join("far.ply"), encode::ply(&far)).unwrap();
    let refused = convert(&folder, "far.ply a.spz").code(2);
    refused.stderr(predicates::str::contains("a.spz: Gaussian 1 is at 1e9, and spz holds"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "the two inputs");
}

#[test]
fn folders_of_models_are_replaced_with_force_and_others_never() {
    let folder = folder_with_a_model();
    let path = |name: &str| folder.path().join(name);
    convert(&folder, "scene.ply a/b/model").success();
    let refused = convert(&folder, "scene.ply a/b/model").code(2);
    refused.stderr(predicates::str::contains("holds a model already; use --force"));
    std::fs::remove_file(path("a/b/model/quats.webp")).unwrap();
    convert(&folder, "scene.ply a/b/model/meta.json --force").success();
    assert!(path("a/b/model/quats.webp").is_file());
    std::fs::write(path("a/b/model/notes.txt"), "mine").unwrap();
    let refused = convert(&folder, "scene.ply a/b/model --force").code(2);
    refused.stderr(predicates::str::contains("holds `notes.txt`, which is not of a model"));
    let refused = convert(&folder, "scene.ply meta.json").code(2);
    refused.stderr(predicates::str::contains("is the working folder, and a model takes"));
    std::fs::write(path("file"), "mine").unwrap();
    let refused = convert(&folder, "scene.ply file").code(2);
    refused.stderr(predicates::str::contains("is a file; name a folder"));
    assert_eq!(std::fs::read_dir(path("a/b")).unwrap().count(), 1, "nothing hidden is left");
    // Nothing is begun for an input that cannot be read.
    convert(&folder, "absent.ply x/y/z").code(3);
    assert!(!path("x").exists());
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
    let cases = [("nothing.ply", 3, "No such file"), ("", 3, "a folder without a model")];
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

/// A run of INRIA's trainer: its last iteration, and its cameras.
#[test]
fn the_folder_of_a_run_is_its_last_iteration() {
    let folder = tempfile::tempdir().unwrap();
    for (iteration, points) in [(7000, 20), (30_000, 30), (999, 10)] {
        let place = folder.path().join(format!("point_cloud/iteration_{iteration}"));
        std::fs::create_dir_all(&place).unwrap();
        std::fs::write(place.join("point_cloud.ply"), encode::ply(&sample(points, 0))).unwrap();
    }
    // Where the trainer was stopped before it had written.
    std::fs::create_dir(folder.path().join("point_cloud/iteration_40000")).unwrap();
    for place in [folder.path().to_owned(), folder.path().join("point_cloud")] {
        let model = open_model(&place, None).unwrap();
        assert_eq!(model.gaussians.len(), 30, "{}", place.display());
        assert!(model.path.ends_with("iteration_30000/point_cloud.ply"));
    }
    let iteration = folder.path().join("point_cloud/iteration_7000");
    assert_eq!(open_model(&iteration, None).unwrap().gaussians.len(), 20);
    let empty = folder.path().join("point_cloud/iteration_40000");
    let error = open_model(&empty, None).unwrap_err().to_string();
    assert!(error.contains("a folder without a model"), "{error}");
}

/// A model that is shown, extracted and replayed from behind: a word, and the work all the same.
#[test]
fn cameras_that_see_nothing_are_warned_of() {
    let folder = folder_with_a_model();
    let at = |name: &str| folder.path().join(name);
    let cameras = |from: f64| {
        let centre = glam::DVec3::new(0.0, 0.0, from);
        let target = glam::DVec3::new(0.0, 0.0, from + 1.0);
        let up = glam::DVec3::NEG_Y;
        powergs_sim::scene::Camera::looking_at(centre, target, up, 1.0, (64, 48))
    };
    let write = |views: &[powergs_sim::scene::Camera]| {
        let text = powergs_sim::scene::camera::inria::write(views);
        std::fs::write(at("cameras.json"), text).unwrap();
    };
    let run = |words: &str| {
        let run = program().current_dir(folder.path()).args(words.split(' ')).assert().success();
        String::from_utf8(run.get_output().stderr.clone()).unwrap()
    };
    let extract = "extract scene.ply --cameras cameras.json -o a.bin --force";
    let warning = "warning: no Gaussian is in view in any frame";
    write(&[cameras(5.0), cameras(8.0)]);
    assert!(run(extract).contains(warning));
    assert!(run("render scene.ply --cameras cameras.json -o a.png --force").contains(warning));
    let replay = "replay a.bin --out run --force";
    assert!(run(replay).contains(warning));
    assert!(!run(&format!("{replay} --quiet")).contains("warning"));
    // One view that sees it is enough.
    write(&[cameras(5.0), cameras(-5.0)]);
    assert_eq!((run(extract), run(replay)), (String::new(), String::new()));
}

/// A tag goes from the model through the trace to whoever reads it.
#[test]
fn a_trace_says_that_its_model_is_antialiased() {
    let folder = folder_with_a_model();
    let scene = powergs_sim::scene::Gaussians { antialiased: true, ..sample(700, 2) };
    std::fs::write(folder.path().join("mip.ply"), encode::ply(&scene)).unwrap();
    for (model, is) in [("scene.ply", false), ("mip.ply", true)] {
        let run = |words: &str| {
            program().current_dir(folder.path()).args(words.split(' ')).assert().success()
        };
        run(&format!("extract {model} --orbit 1 --size 64x48 -o a.bin --force --quiet"));
        let info = run("trace info a.bin --json");
        let facts: Value = serde_json::from_slice(&info.get_output().stdout).unwrap();
        assert_eq!(facts["frames"][0]["antialiased"], is);
        let info = run("trace info a.bin");
        let text = String::from_utf8_lossy(&info.get_output().stdout).into_owned();
        assert_eq!(text.contains("700 Gaussians, anti-aliased"), is, "{text}");
    }
}
