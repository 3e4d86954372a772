//! COLMAP sparse models: `cameras` and `images`, binary or text. `points3D` is only read where a
//! training starts from it.
//!
//! Poses are world-to-camera (quaternion w, x, y, z and translation) in OpenCV axes; the principal
//! point counts from the left and top edges, as ours. Views come out sorted by name, as INRIA's
//! loader sorts them. A camera that bends rays leaves a pinhole view, its lens, and a warning.

mod binary;
mod models;
mod points;
mod text;

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3};

pub use binary::read_binary;
pub(super) use models::is_known as is_model;
pub use points::{read_points_binary, read_points_text};
pub use text::read_text;

use super::check::{CameraKeys, checked};
use super::{Camera, CameraError, CameraFile, Frame, Placement};
use models::Intrinsics;

const KEYS: CameraKeys = CameraKeys {
    size: ["width", "height"],
    focal: ["focal length x", "focal length y"],
    principal: ["principal point x", "principal point y"],
    rotation: "rotation",
    centre: "translation",
};

/// One entry of `images`.
struct ColmapImage {
    id: u32,
    quaternion: [f64; 4],
    translation: DVec3,
    camera: u32,
    name: String,
}

/// Puts poses and intrinsics together.
fn views(
    format: &'static str,
    intrinsics: &BTreeMap<u32, Intrinsics>,
    mut images: Vec<ColmapImage>,
    mut warnings: Vec<String>,
) -> Result<CameraFile, CameraError> {
    images.sort_by(|a, b| a.name.cmp(&b.name).then(a.id.cmp(&b.id)));
    for (id, camera) in intrinsics {
        if camera.lens.is_some() {
            let model = camera.model;
            let what = "its distortion is ignored: views are rendered pinhole";
            warnings.push(format!("camera {id} ({model}): {what}"));
        }
    }
    let lens =
        |image: &ColmapImage| Some((image.name.clone(), intrinsics.get(&image.camera)?.lens?));
    let lenses = images.iter().filter_map(lens).collect();
    let cameras: Vec<Camera> =
        images.into_iter().map(|image| view(intrinsics, image)).collect::<Result<_, _>>()?;
    if cameras.is_empty() {
        return Err(CameraError::Empty);
    }
    let frame = Frame::Data(Placement::NONE);
    Ok(CameraFile { format, cameras, lenses, warnings, doubts: Vec::new(), frame })
}

fn view(intrinsics: &BTreeMap<u32, Intrinsics>, image: ColmapImage) -> Result<Camera, CameraError> {
    let label = format!("image {} ({})", image.id, image.name);
    let fault = |key, what| CameraError::Value { view: label.clone(), key, what };
    let id = image.camera;
    let missing = || fault("camera_id", format!("camera {id} is not in the `cameras` file"));
    let intrinsics = intrinsics.get(&id).ok_or_else(missing)?;
    let [w, x, y, z] = image.quaternion;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    if !(length > 1e-6 && length < 1e6) {
        let what = format!("({w}, {x}, {y}, {z}) is not a rotation quaternion");
        return Err(fault("rotation", what));
    }
    let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
    let camera = Camera {
        name: image.name,
        width: intrinsics.width,
        height: intrinsics.height,
        fx: intrinsics.focal[0],
        fy: intrinsics.focal[1],
        cx: intrinsics.principal[0],
        cy: intrinsics.principal[1],
        world_to_camera: rotation,
        centre: -(rotation.transpose() * image.translation),
        split: None,
        eye: None,
    };
    checked(camera, &label, &KEYS)
}
