//! Cameras: readers, what they refuse, and what is generated.

mod edit;
mod hostile;
mod lens;
mod nerfstudio;
mod points;
mod readers;

use powergs_scene::Camera;

/// Largest difference of pose and intrinsics.
fn difference(a: &Camera, b: &Camera) -> f64 {
    let rotation = (a.world_to_camera - b.world_to_camera).to_cols_array();
    let intrinsics = [a.fx - b.fx, a.fy - b.fy, a.cx - b.cx, a.cy - b.cy];
    let size = [f64::from(a.width) - f64::from(b.width), f64::from(a.height) - f64::from(b.height)];
    let centre = (a.centre - b.centre).to_array();
    let all = rotation.iter().chain(&intrinsics).chain(&size).chain(&centre);
    all.fold(0.0, |worst, d| worst.max(d.abs()))
}
