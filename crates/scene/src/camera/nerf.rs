//! NeRF `transforms.json`: camera-to-world matrices in OpenGL axes (x right, y up, z backwards).
//!
//! Intrinsics stand at the top of the file or in a frame (the frame wins): `fl_x`, `fl_y` in
//! pixels, or `camera_angle_x`, `camera_angle_y` in radians; `w`, `h`; `cx`, `cy`. Coefficients of
//! a lens are OpenCV's; `is_fisheye` or a `camera_model` with FISHEYE in its name makes k1 to k4
//! those of a fisheye. Views are pinhole, and a warning says so where the lens bends anything.
//! A `camera_model` that is neither a pinhole nor a lens, such as a panorama, is refused.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat3, DVec3};
use serde_json::{Map, Value};

use super::check::{CameraKeys, checked};
use super::json::JsonView;
use super::lens::Lens;
use super::{Camera, CameraError, CameraFile, Frame, Placement, colmap};

const KEYS: CameraKeys = CameraKeys {
    size: ["w", "h"],
    focal: ["fl_x", "fl_y"],
    principal: ["cx", "cy"],
    rotation: "transform_matrix",
    centre: "transform_matrix",
};

/// Distortion coefficients of instant-ngp and nerfstudio.
const DISTORTION: [&str; 8] = ["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"];

/// The image size of a view of which the file does not say it, by its `file_path`; pixels.
pub type SizeOf<'a> = dyn Fn(&str) -> Option<(u32, u32)> + 'a;

/// The views of the file, in its order.
pub(super) fn views(
    file: &Map<String, Value>,
    size: &SizeOf<'_>,
) -> Result<CameraFile, CameraError> {
    let Some(Value::Array(frames)) = file.get("frames") else { return Err(CameraError::Layout) };
    let (mut distorted, mut lenses) = (BTreeSet::new(), BTreeMap::new());
    let mut cameras = Vec::with_capacity(frames.len());
    for (idx, value) in frames.iter().enumerate() {
        let view = JsonView::new(idx, value, "file_path", Some(file))?;
        let camera = camera(idx, &view, size)?;
        if let Some((lens, keys)) = lens(&view)? {
            distorted.extend(keys);
            lenses.insert(camera.name.clone(), lens);
        }
        cameras.push(camera);
    }
    let mut warnings = Vec::new();
    if !distorted.is_empty() {
        let keys = distorted.into_iter().collect::<Vec<_>>().join(", ");
        warnings.push(format!("lens distortion ({keys}) is ignored: views are rendered pinhole"));
    }
    let frame = Frame::Data(Placement::applied(&Value::Object(file.clone()))?);
    let format = "NeRF transforms.json";
    Ok(CameraFile { format, cameras, lenses, warnings, doubts: Vec::new(), frame })
}

/// The lens of a view that bends rays, and the keys that say so.
fn lens(view: &JsonView<'_>) -> Result<Option<(Lens, Vec<&'static str>)>, CameraError> {
    let mut values = [0.0; DISTORTION.len()];
    for (value, key) in values.iter_mut().zip(DISTORTION) {
        *value = view.number(key)?.unwrap_or(0.0);
    }
    let [k1, k2, k3, k4, k5, k6, p1, p2] = values;
    let model = view.text("camera_model")?;
    if let Some(name) = model.filter(|name| !is_lens(name)) {
        return Err(view.fault("camera_model", no_pinhole(name)));
    }
    let is_fisheye = model.is_some_and(|m| m.contains("FISHEYE")) || view.flag("is_fisheye")?;
    let lens = match is_fisheye {
        true => Lens::Fisheye([k1, k2, k3, k4]),
        false => Lens::Rational { radial: [k1, k2, k3, k4, k5, k6], tangential: [p1, p2] },
    };
    let used = DISTORTION.iter().zip(values).filter(|(_, v)| *v != 0.0).map(|(key, _)| *key);
    let mut keys: Vec<&str> = used.collect();
    keys.extend(is_fisheye.then_some("fisheye"));
    Ok((!lens.is_straight()).then_some((lens, keys)))
}

/// Whether a camera of this model sees as a pinhole does, through a lens perhaps.
fn is_lens(name: &str) -> bool {
    name.contains("FISHEYE") || name.eq_ignore_ascii_case("perspective") || colmap::is_model(name)
}

/// What is wrong with a kind of camera that is no pinhole.
pub(super) fn no_pinhole(name: &str) -> String {
    format!(
        "`{}` is neither a pinhole nor a lens that is known here; cut pinhole views out of a \
         panorama, and give the model and coefficients of a lens",
        name.chars().take(80).collect::<String>()
    )
}

/// From the rotation of a camera in OpenGL axes.
pub(super) fn world_to_camera(rotation: DMat3) -> DMat3 {
    (rotation * DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0))).transpose()
}

fn camera(idx: usize, view: &JsonView<'_>, size: &SizeOf<'_>) -> Result<Camera, CameraError> {
    let path = view.text("file_path")?;
    let asked = || size(path.unwrap_or_default());
    let (width, height) = match (view.pixels("w")?, view.pixels("h")?) {
        (Some(w), Some(h)) => (w, h),
        _ => {
            let none = || CameraError::NoSize { view: view.label.clone() };
            asked().ok_or_else(none)?
        }
    };
    let (fx, fy) = focal(view, width, height)?;
    let (rotation, centre) = view.transform("transform_matrix")?;
    let camera = Camera {
        name: path.map_or_else(|| format!("view_{idx:03}"), file_name),
        width,
        height,
        fx,
        fy,
        cx: view.number("cx")?.unwrap_or(0.5 * f64::from(width)),
        cy: view.number("cy")?.unwrap_or(0.5 * f64::from(height)),
        world_to_camera: world_to_camera(rotation),
        centre,
        split: view.split()?,
        eye: view.eye()?,
    };
    checked(camera, &view.label, &KEYS)
}

/// Focal lengths in pixels; a missing vertical one equals the horizontal one (square pixels).
fn focal(view: &JsonView<'_>, width: u32, height: u32) -> Result<(f64, f64), CameraError> {
    let from_angle = |key, size: u32| -> Result<Option<f64>, CameraError> {
        let Some(angle) = view.number(key)? else { return Ok(None) };
        if !(angle > 0.0 && angle < std::f64::consts::PI) {
            return Err(view.fault(key, format!("{angle} rad; must be above 0 and below pi")));
        }
        Ok(Some(0.5 * f64::from(size) / (0.5 * angle).tan()))
    };
    let fx = match view.number("fl_x")? {
        Some(fx) => Some(fx),
        None => from_angle("camera_angle_x", width)?,
    };
    let fy = match view.number("fl_y")? {
        Some(fy) => Some(fy),
        None => from_angle("camera_angle_y", height)?,
    };
    match (fx, fy) {
        (Some(fx), fy) => Ok((fx, fy.unwrap_or(fx))),
        (None, Some(fy)) => Ok((fy, fy)),
        (None, None) => Err(view.fault("fl_x", "is missing, and so is `camera_angle_x`")),
    }
}

fn file_name(path: &str) -> String {
    path.rsplit(['/', '\\']).next().unwrap_or(path).to_string()
}
