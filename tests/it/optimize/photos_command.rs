//! `--images`: photos of other sizes, through lenses, with names that do not fit.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use powergs_pixels::RgbImage;
use powergs_sim::cli::Exit;
use powergs_sim::raster::{Detail, Options, render};
use powergs_sim::scene::Camera;
use powergs_sim::scene::camera::inria;

use super::command::{arguments, fails, run, stage};
use super::scenes::Tiny;

/// Writes what the views show as photos, each side so many times as large as its camera says.
fn photograph(folder: &Path, tiny: &Tiny, times: f64) {
    let photos = folder.join("photos");
    fs::create_dir_all(&photos).unwrap();
    for camera in &tiny.cameras {
        let side = |pixels: u32| (f64::from(pixels) * times).round() as u32;
        let size = (side(camera.width), side(camera.height));
        let camera = powergs_sim::scene::camera::edit::stretched(camera, size.0, size.1);
        let picture = render(&tiny.dense, &camera, &Options::reference(Detail::Image)).picture;
        let image = RgbImage::from_bytes(size.0, size.1, picture.to_rgb8()).unwrap();
        fs::write(photos.join(format!("{}.png", camera.name)), image.png().unwrap()).unwrap();
    }
}

/// The views as a COLMAP folder whose cameras have a lens.
fn colmap(folder: &Path, cameras: &[Camera], model: &str, coefficients: &str) {
    let c = &cameras[0];
    let model = format!("1 {model} {} {} {}", c.width, c.height, c.fx);
    let text = format!("{model} {} {} {} {coefficients}\n", c.fy, c.cx, c.cy);
    fs::write(folder.join("cameras.txt"), text).unwrap();
    let mut text = String::new();
    for (i, camera) in cameras.iter().enumerate() {
        let q = glam::DQuat::from_mat3(&camera.world_to_camera);
        let t = -(camera.world_to_camera * camera.centre);
        let _ = writeln!(
            text,
            "{} {} {} {} {} {} {} {} 1 {}\n",
            i + 1,
            q.w,
            q.x,
            q.y,
            q.z,
            t.x,
            t.y,
            t.z,
            camera.name
        );
    }
    fs::write(folder.join("images.txt"), text).unwrap();
}

/// Width and height of the views of the run in a folder.
fn size(folder: &Path) -> (i64, i64) {
    let text = fs::read_to_string(folder.join("run/run.toml")).unwrap();
    let record: toml::Table = text.parse().unwrap();
    let views = &record["views"];
    (views["width-px"].as_integer().unwrap(), views["height-px"].as_integer().unwrap())
}

/// PSNR of the dense model over the gate views.
fn dense_db(folder: &Path) -> f64 {
    let text = fs::read_to_string(folder.join("run/results.json")).unwrap();
    let results = powergs_sim::optimize::results::Results::parse(&text).unwrap();
    results.dense().unwrap().gate.psnr_db.unwrap()
}

const SHORT: [&str; 8] =
    ["--images", "@/photos", "--quality", "0.3", "--rhos", "0.2", "--iterations", "2"];

#[test]
fn photos_may_be_smaller_or_larger_than_their_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tiny = stage(folder, 200);
    let more = [&SHORT[..], &["--cameras", "@/cameras.json"]].concat();
    for (times, expected) in [(0.5, (24, 18)), (2.0, (48, 36)), (0.73, (35, 26))] {
        photograph(folder, &tiny, times);
        assert_eq!(run(folder, &more).unwrap(), Exit::Done, "{times}");
        assert_eq!(size(folder), expected);
        // Of its own renders it differs by eight bits, and by what is between pixels.
        let db = dense_db(folder);
        assert!(db > if times <= 1.0 { 45.0 } else { 28.0 }, "{times}: {db:.1} dB");
        fs::remove_dir_all(folder.join("run")).unwrap();
    }
}

#[test]
fn photos_are_freed_of_lenses_that_their_cameras_name() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tiny = stage(folder, 200);
    photograph(folder, &tiny, 1.0);
    let more = [&SHORT[..], &["--cameras", "@", "--least-likeness", "0"]].concat();
    colmap(folder, &tiny.cameras, "OPENCV", "0 0 0 0");
    run(folder, &more).unwrap();
    let (straight, whole) = (dense_db(folder), size(folder));
    assert!(straight > 45.0 && whole == (48, 36), "{straight:.1} dB");
    fs::remove_dir_all(folder.join("run")).unwrap();
    // These photos have no lens: taking one away bends them, and leaves less of them.
    colmap(folder, &tiny.cameras, "OPENCV", "0.4 0 0 0");
    run(folder, &more).unwrap();
    let (bent, left) = (dense_db(folder), size(folder));
    assert!(bent < straight - 5.0, "{bent:.1} and {straight:.1} dB");
    assert!(left.0 < whole.0 && left.1 < whole.1, "{left:?}");
    fs::remove_dir_all(folder.join("run")).unwrap();
    colmap(folder, &tiny.cameras, "OPENCV", "NaN 0 0 0");
    fails(folder, &more, Exit::BadInput, "its lens leaves less than");
}

#[test]
fn photos_and_cameras_that_do_not_fit_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tiny = stage(folder, 100);
    photograph(folder, &tiny, 1.0);
    let more = [&SHORT[..], &["--cameras", "@/cameras.json"]].concat();
    let mut twice = tiny.cameras.clone();
    twice[1].name = twice[0].name.clone();
    fs::write(folder.join("cameras.json"), inria::write(&twice)).unwrap();
    fails(folder, &more, Exit::BadInput, "two cameras have this photo");
    let mut other = tiny.cameras.clone();
    other.iter_mut().for_each(|c| c.name = format!("frame-{}", c.name));
    fs::write(folder.join("cameras.json"), inria::write(&other)).unwrap();
    fails(folder, &more, Exit::BadInput, "8 of 8 photos are missing: frame-");
    fails(folder, &more, Exit::BadInput, "there are 8: ");
    // Names in another format, and in folders of COLMAP; a name cannot lead out of the folder.
    other = tiny.cameras.clone();
    other[0].name += ".JPG";
    other[1].name = format!("left/{}.png", other[1].name);
    other[2].name = format!("../photos/{}", other[2].name);
    other.truncate(7);
    fs::write(folder.join("cameras.json"), inria::write(&other)).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_powergs-sim"))
        .args(arguments(folder, &more).iter().skip(1).filter(|word| *word != "--quiet"))
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("1 of 8 photos have no camera and are not used"), "{said}");
}

#[test]
fn photos_of_formats_that_are_not_read_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tiny = stage(folder, 100);
    fs::create_dir_all(folder.join("photos")).unwrap();
    for (i, camera) in tiny.cameras.iter().enumerate() {
        let end = if i == 0 { "HEIC" } else { "tif" };
        fs::write(folder.join("photos").join(format!("{}.{end}", camera.name)), "").unwrap();
    }
    let more = [&SHORT[..], &["--cameras", "@/cameras.json"]].concat();
    let said = "there are 1 .heic and 7 .tif, which are not read: convert them to PNG or JPEG";
    fails(folder, &more, Exit::BadInput, said);
}
