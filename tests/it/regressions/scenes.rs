//! Models and cameras as other programs leave them.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use glam::{DMat3, DVec3};
use powergs_sim::scene::Camera;
use powergs_sim::scene::camera::inria;
use powergs_sim::scene::files::open_cameras;
use powergs_testkit::camera_files::{binary_files, sample as camera};
use powergs_testkit::scene_files::{ply, sample, spz};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;

/// Runs the program in a folder.
fn program(folder: &Path, words: &str) -> Assert {
    let mut command = Command::cargo_bin("powergs-sim").expect("the program was built");
    command.current_dir(folder).args(words.split_whitespace()).assert()
}

/// A view from `distance` in front of the origin.
fn front(distance: f64) -> Camera {
    Camera {
        width: 64,
        height: 48,
        fx: 60.0,
        fy: 60.0,
        cx: 32.0,
        cy: 24.0,
        world_to_camera: DMat3::IDENTITY,
        centre: DVec3::new(0.0, 0.0, -distance),
        ..camera()
    }
}

/// Display power of a white background is a multiple of that of a black one.
#[test]
fn the_background_of_a_training_run_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let run = path.join("run/point_cloud/iteration_7");
    fs::create_dir_all(&run).unwrap();
    fs::write(run.join("point_cloud.ply"), ply(&sample(24, 0))).unwrap();
    fs::write(path.join("run/cameras.json"), inria::write(&[front(4.0)])).unwrap();
    let arguments = |white: &str| {
        let text = format!("Namespace(eval=True, white_background={white}, sh_degree=3)");
        fs::write(path.join("run/cfg_args"), text).unwrap();
    };
    let picture = |words: &str| {
        program(path, &format!("render {words} -o a.png --force")).success();
        fs::read(path.join("a.png")).unwrap()
    };
    let with = |colour: &str| picture(&format!("run --cameras run --background {colour}"));
    let (black, white) = (with("black"), with("white"));
    assert_ne!(black, white);
    assert_eq!(picture("run --cameras run"), black, "without cfg_args");
    arguments("True");
    let model = "run/point_cloud/iteration_7/point_cloud.ply";
    fs::copy(path.join(model), path.join("elsewhere.ply")).unwrap();
    for words in ["run --cameras run", &format!("{model} --orbit 1"), "elsewhere.ply --cameras run"]
    {
        let said = "note: the background is white, over which the model was trained";
        let render = format!("render {words} -o b.png --force");
        program(path, &render).success().stderr(contains(said).and(contains("cfg_args")));
    }
    assert_eq!(picture("run --cameras run"), white);
    assert_eq!(picture("elsewhere.ply --cameras run/cameras.json"), white);
    let asked = "render run --cameras run --background black -o c.png";
    program(path, asked).success().stderr(contains("note: the background").not());
    assert_eq!(fs::read(path.join("c.png")).unwrap(), black);
    arguments("False");
    assert_eq!(picture("run --cameras run"), black);
}

/// COLMAP writes a model for each part of a scene that it could not join to the others.
#[test]
fn of_several_colmap_models_the_largest_is_read_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let model = |name: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(&path).unwrap();
        path
    };
    let (first, second, third) = (model("sparse/0"), model("sparse/1"), model("sparse/10"));
    let (cameras, images) = binary_files();
    for path in [&first, &third] {
        fs::write(path.join("cameras.bin"), &cameras).unwrap();
        fs::write(path.join("images.bin"), &images).unwrap();
    }
    let image = |i: u32| format!("{i} 1 0 0 0 0 0 {i} 1 {i}.png\n\n");
    let images: String = (1..=3).map(image).collect();
    fs::write(second.join("cameras.txt"), "1 PINHOLE 640 480 500 500 320 240\n").unwrap();
    fs::write(second.join("images.txt"), format!("# Image list\n{images}")).unwrap();
    for place in ["", "sparse"] {
        let file = open_cameras(&folder.path().join(place), None, None).unwrap();
        assert_eq!(file.cameras.len(), 3, "{place}");
        let [doubt] = &file.doubts[..] else { panic!("{:?}", file.doubts) };
        assert!(doubt.contains("views of 0: 2, 1: 3, 10: 2): 1 is read"), "{doubt}");
    }
    // One that is named is that one, and nothing is said.
    let file = open_cameras(&first, None, None).unwrap();
    assert_eq!((file.cameras.len(), file.doubts.len()), (2, 0));
    let words = "camera info . --json";
    let info = program(folder.path(), words).success();
    let facts: Value = serde_json::from_slice(&info.get_output().stdout).unwrap();
    assert!(facts["warnings"].to_string().contains("3 models of COLMAP"), "{facts}");
    // A part of a model is not one.
    let failure = open_cameras(&second.join("images.txt"), None, None).unwrap_err().to_string();
    assert!(failure.contains("one of COLMAP's files; give their folder"), "{failure}");
}

/// Networks see a small picture of a photo, and hand on intrinsics of one and the size of the
/// other.
#[test]
fn intrinsics_of_another_picture_are_doubted_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let doubts = |name: &str| open_cameras(&path.join(name), None, None).unwrap().doubts;
    let colmap = |cx: f64, cy: f64| {
        let camera = format!("1 PINHOLE 1920 1080 300 300 {cx} {cy}\n");
        fs::write(path.join("cameras.txt"), camera).unwrap();
        fs::write(path.join("images.txt"), "1 1 0 0 0 0 0 0 1 a.png\n\n").unwrap();
        doubts("")
    };
    let found = colmap(259.0, 147.0);
    let [doubt] = &found[..] else { panic!("{found:?}") };
    for part in ["1 of 1 views", "principal point", "13 %", "14 %", "518x294", "1920x1080"] {
        assert!(doubt.contains(part), "{part}: {doubt}");
    }
    assert_eq!(colmap(960.0, 540.0), [""; 0]);
    // As far off the middle as a headset's.
    assert_eq!(colmap(0.6 * 1920.0, 0.45 * 1080.0), [""; 0]);
    let found = colmap(100.0, 540.0);
    let [doubt] = &found[..] else { panic!("{found:?}") };
    assert!(doubt.contains("is the picture a part of another one?"), "{doubt}");
    let odd = Camera { cx: 9.0, cy: 7.0, ..front(4.0) };
    fs::write(path.join("inria.json"), inria::write(&[front(3.0), odd])).unwrap();
    assert!(doubts("inria.json")[0].starts_with("1 of 2 views"));
    let text = r#"{"w": 64, "h": 48, "fl_x": 60, "cx": 150.0, "cy": 110.0, "frames": [{
        "transform_matrix": [[1,0,0,0],[0,-1,0,0],[0,0,-1,0],[0,0,0,1]]}]}"#;
    fs::write(path.join("nerf.json"), text).unwrap();
    assert!(doubts("nerf.json")[0].contains("300x220"));
    // It is said of views that are shown, too.
    fs::write(path.join("scene.ply"), ply(&sample(24, 0))).unwrap();
    let render = program(path, "render scene.ply --cameras nerf.json -o a.png").success();
    render.stderr(contains("warning: 1 of 1 views have their principal point far"));
}

#[test]
fn camera_files_of_other_programs_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let metashape = b"<?xml version=\"1.0\"?>\n<document version=\"1.5.0\">\n  <chunk label=\"1\">";
    let cases: [(&str, &[u8], &str); 6] = [
        ("a.xml", metashape, "Metashape (Agisoft)"),
        ("b.xml", b"<?xml version=\"1.0\"?><BlocksExchange/>", "XML document"),
        ("c.json", b"<!DOCTYPE html><html></html>", "web page (HTML)"),
        ("poses.npy", b"\x93NUMPY\x01\0v\0", "poses_bounds.npy of LLFF"),
        ("database.db", b"SQLite format 3\0\x10\0", "a database, as COLMAP"),
        ("bundle.out", b"# Bundle file v0.3\n", "Bundler"),
    ];
    for (name, bytes, word) in cases {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let failure = open_cameras(&path, None, None).unwrap_err().to_string();
        assert!(failure.contains(word) && failure.contains("is not read"), "{failure}");
    }
}

/// A scene a tenth of a unit across, from as near as it fills the picture: all of it is before the
/// near plane.
#[test]
fn small_scenes_are_warned_of_before_the_near_plane() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut scene = sample(200, 0);
    scene.means.as_flattened_mut().iter_mut().for_each(|v| *v *= 0.05);
    scene.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s -= 3.0);
    fs::write(path.join("small.ply"), ply(&scene)).unwrap();
    fs::write(path.join("near.json"), inria::write(&[front(0.12)])).unwrap();
    fs::write(path.join("far.json"), inria::write(&[front(0.4)])).unwrap();
    let info = program(path, "scene info small.ply --json").success();
    let facts: Value = serde_json::from_slice(&info.get_output().stdout).unwrap();
    assert!(facts["warnings"].to_string().contains("small_scene"), "{facts}");
    let said = "Gaussians in the pictures are not drawn, because they are within 0.2 world units";
    for (command, file) in [("render", "a.png"), ("extract", "a.bin")] {
        let words = format!("{command} small.ply --cameras near.json -o {file}");
        program(path, &words).success().stderr(contains(said));
    }
    let from_afar = "render small.ply --cameras far.json -o b.png";
    program(path, from_afar).success().stderr(contains("near plane").not());
    fs::write(path.join("usual.ply"), ply(&sample(200, 0))).unwrap();
    let info = program(path, "scene info usual.ply --json").success();
    info.stdout(contains("small_scene").not());
}

#[test]
fn a_model_in_other_axes_has_a_flag_that_the_warning_names() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut scene = sample(200, 0);
    scene.means.iter_mut().for_each(|m| m[2] += 4.0);
    fs::write(path.join("a.spz"), spz(&scene, 2, &[])).unwrap();
    fs::write(path.join("a.ply"), ply(&scene)).unwrap();
    fs::write(path.join("c.json"), inria::write(&[front(0.0)])).unwrap();
    let words = "render a.spz --cameras c.json -o a.png";
    program(path, words)
        .success()
        .stderr(contains("no Gaussian is in view").and(contains("--axes")));
    let turned = program(path, &format!("{words} --force --axes ply")).success();
    turned.stderr(contains("in view").not());
    program(path, "scene convert a.spz b.ply --axes rdf").success();
    let facts = |words: &str| -> Value {
        let run = program(path, words).success();
        serde_json::from_slice(&run.get_output().stdout).unwrap()
    };
    let (a, b) = (facts("scene info a.spz --axes ply --json"), facts("scene info b.ply --json"));
    assert_eq!((&a["bounds"], &a["opacity"]), (&b["bounds"], &b["opacity"]));
    assert!(a["bounds"]["min"][2].as_f64().unwrap() > 2.9);
    program(path, "scene info a.spz --axes north").code(2).stderr(contains("rdf"));
}

/// One Gaussian far away costs all others of an SPZ file their places.
#[test]
fn a_far_gaussian_is_named_when_a_model_is_converted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut scene = sample(400, 0);
    scene.means[0] = [2e6, 0.0, 3.0];
    fs::write(path.join("far.ply"), ply(&scene)).unwrap();
    let said = "far.spz: the format is too coarse for the positions";
    let run = program(path, "scene convert far.ply far.spz --json").success();
    let facts: Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(facts["displaced"]["apart"]["farthest"], 0);
    run.stderr(contains(said).and(contains("1 Gaussian lies far from all others (#0")));
    program(path, "scene convert far.ply far.glb").success().stderr(contains("coarse").not());
}
