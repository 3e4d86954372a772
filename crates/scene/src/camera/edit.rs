//! Edits of a list of views: other sizes, stereo pairs.

use super::{Camera, Eye};

/// The view in another image size. The vertical field of view is kept, so another aspect shows
/// more or less to the left and right. The principal point keeps its offset from the middle, in
/// proportion to the height.
pub fn resized(camera: &Camera, width: u32, height: u32) -> Camera {
    if (width, height) == (camera.width, camera.height) {
        return camera.clone();
    }
    let scale = f64::from(height) / f64::from(camera.height);
    let offset = |principal: f64, old: u32, new: u32| {
        0.5 * f64::from(new) + (principal - 0.5 * f64::from(old)) * scale
    };
    Camera {
        width,
        height,
        fx: camera.fx * scale,
        fy: camera.fy * scale,
        cx: offset(camera.cx, camera.width, width),
        cy: offset(camera.cy, camera.height, height),
        ..camera.clone()
    }
}

/// The view in another image size, stretched: the same field of view, whatever the aspect. Photos
/// that were made smaller have sizes in whole pixels, and so another aspect than their cameras.
pub fn stretched(camera: &Camera, width: u32, height: u32) -> Camera {
    let x = f64::from(width) / f64::from(camera.width);
    let y = f64::from(height) / f64::from(camera.height);
    Camera {
        width,
        height,
        fx: camera.fx * x,
        fy: camera.fy * y,
        cx: camera.cx * x,
        cy: camera.cy * y,
        ..camera.clone()
    }
}

/// Two parallel views, `eye_distance` world units apart along the camera's x axis: first
/// `NAME_left`, then `NAME_right`.
pub fn stereo(camera: &Camera, eye_distance: f64) -> [Camera; 2] {
    let half = camera.right() * (0.5 * eye_distance);
    let view = |centre, eye: Eye| Camera {
        name: format!("{}_{}", camera.name, eye.name()),
        centre,
        eye: Some(eye),
        ..camera.clone()
    };
    [view(camera.centre - half, Eye::Left), view(camera.centre + half, Eye::Right)]
}
