//! Cameras: readers, what they refuse, and what is generated.

mod edit;
mod encode;
mod files;
mod hostile;
mod readers;

use glam::{DMat3, DVec3};
use powergs_sim::scene::Camera;

/// The folder of real data, where it is there.
fn data() -> Option<std::path::PathBuf> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data");
    let found = std::path::PathBuf::from(path);
    if !found.is_dir() {
        println!("skipped: ../shared/data is absent");
        return None;
    }
    Some(found)
}

/// A view with an off-centre principal point that is turned and away from the origin.
fn sample() -> Camera {
    Camera {
        name: "a.jpg".to_string(),
        width: 800,
        height: 600,
        fx: 700.0,
        fy: 710.0,
        cx: 410.0,
        cy: 290.0,
        world_to_camera: DMat3::from_rotation_y(0.3) * DMat3::from_rotation_x(-0.2),
        centre: DVec3::new(1.0, 2.0, -3.0),
        split: None,
    }
}

/// Largest difference of pose and intrinsics.
fn difference(a: &Camera, b: &Camera) -> f64 {
    let rotation = (a.world_to_camera - b.world_to_camera).to_cols_array();
    let intrinsics = [a.fx - b.fx, a.fy - b.fy, a.cx - b.cx, a.cy - b.cy];
    let size = [f64::from(a.width) - f64::from(b.width), f64::from(a.height) - f64::from(b.height)];
    let centre = (a.centre - b.centre).to_array();
    let all = rotation.iter().chain(&intrinsics).chain(&size).chain(&centre);
    all.fold(0.0, |worst, d| worst.max(d.abs()))
}
