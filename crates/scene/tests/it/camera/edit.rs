//! Sizes, stereo pairs, paths.

use glam::DVec3;
use powergs_scene::Camera;
use powergs_scene::camera::edit::{resized, stereo};
use powergs_scene::camera::path::Path;
use powergs_testkit::camera_files::{poses, sample};

use super::difference;

#[test]
fn another_size_keeps_the_vertical_field_of_view() {
    let camera = sample();
    for (width, height) in [(1600, 1200), (1920, 1080), (100, 900), (801, 600)] {
        let other = resized(&camera, width, height);
        // The same division in another order: rounding only.
        assert!((other.vertical_fov() - camera.vertical_fov()).abs() < 1e-12);
        assert!((other.fx / other.fy - camera.fx / camera.fy).abs() < 1e-12, "pixel aspect");
        let scale = f64::from(height) / 600.0;
        assert!((other.cx - (f64::from(width) / 2.0 + 10.0 * scale)).abs() < 1e-9);
        assert!((other.cy - (f64::from(height) / 2.0 - 10.0 * scale)).abs() < 1e-9);
    }
    assert_eq!(resized(&camera, 800, 600), camera);
}

#[test]
fn stereo_eyes_are_apart_along_x() {
    let camera = sample();
    let [left, right] = stereo(&camera, 0.064);
    assert_eq!((left.name.as_str(), right.name.as_str()), ("a.jpg_left", "a.jpg_right"));
    let apart = camera.world_to_camera * (right.centre - left.centre);
    assert!((apart - DVec3::new(0.064, 0.0, 0.0)).length() < 1e-12, "{apart}");
    assert!(((left.centre + right.centre) * 0.5 - camera.centre).length() < 1e-12);
    assert_eq!(left.world_to_camera, camera.world_to_camera);
}

#[test]
fn path_passes_through_the_poses() {
    for n in [2, 3, 7] {
        let cameras = poses(n);
        let path = Path::through(&cameras).unwrap();
        for (camera, knot) in cameras.iter().zip(path.knots()) {
            // Quaternions and back: a few units in the last place.
            assert!(difference(&path.at(knot), camera) < 1e-12, "{n} poses, knot {knot}");
        }
        let frames = path.frames(24);
        assert_eq!(frames.len(), 24);
        assert!(difference(&frames[0], &cameras[0]) < 1e-12);
        assert!(difference(&frames[23], &cameras[n - 1]) < 1e-12);
        assert_eq!(frames[23].name, "path_0023");
    }
    assert_eq!(Path::through(&poses(3)).unwrap().frames(1).len(), 1);
    assert!(Path::through(&poses(1)).is_none());
}

#[test]
fn path_is_smooth() {
    let path = Path::through(&poses(6)).unwrap();
    let h = 1e-6;
    for knot in &path.knots()[1..5] {
        let at = |t: f64| path.at(knot + t);
        let speed = |a: &Camera, b: &Camera| (b.centre - a.centre) / h;
        let (before, after) = (speed(&at(-h), &at(0.0)), speed(&at(0.0), &at(h)));
        // The velocity is continuous; a one-sided difference is off by acceleration times h.
        assert!((before - after).length() < 1e-4, "{before} {after}");
        let turn = |a: &Camera, b: &Camera| (b.world_to_camera - a.world_to_camera) * (1.0 / h);
        let jump = turn(&at(-h), &at(0.0)) - turn(&at(0.0), &at(h));
        assert!(jump.to_cols_array().iter().all(|d| d.abs() < 1e-4), "{jump}");
    }
}

#[test]
fn path_through_equal_poses_stays() {
    let path = Path::through(&vec![sample(); 4]).unwrap();
    for frame in path.frames(9) {
        assert!(difference(&frame, &sample()) < 1e-12);
    }
}
