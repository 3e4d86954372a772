//! What nerfstudio does to cameras: it turns, moves and scales a data set before it trains, and
//! writes how into `dataparser_transforms.json`; and the camera paths of its viewer.
//!
//! A model that it exports is in the new frame: p' = s (R p + t). The matrix of the file is for the
//! data set as it was before `applied_transform` and `applied_scale` of its `transforms.json`.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use serde_json::{Map, Value};

use super::check::{CameraKeys, ROTATION_TOLERANCE, checked};
use super::json::JsonView;
use super::{Camera, CameraError, CameraFile, Frame, nerf};

/// The name of the file that says how a data set was moved.
pub const PLACEMENT_FILE: &str = "dataparser_transforms.json";

const KEYS: CameraKeys = CameraKeys {
    size: ["render_width", "render_height"],
    focal: ["fov", "fov"],
    principal: ["render_width", "render_height"],
    rotation: "camera_to_world",
    centre: "camera_to_world",
};

/// A rotation, a shift and a scale, in this order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Rotation; that of `applied_transform` may swap axes.
    pub rotation: DMat3,
    /// Shift before the scale, world units.
    pub shift: DVec3,
    /// Factor of all lengths.
    pub scale: f64,
}

impl Placement {
    /// Nothing moves.
    pub const NONE: Placement =
        Placement { rotation: DMat3::IDENTITY, shift: DVec3::ZERO, scale: 1.0 };

    /// Reads a `dataparser_transforms.json`.
    ///
    /// # Errors
    /// [`CameraError`]: no JSON, or no rotation, shift and scale.
    pub fn read(text: &str) -> Result<Placement, CameraError> {
        let value: Value = serde_json::from_str(text).map_err(|e| CameraError::Syntax {
            line: e.line(),
            column: e.column(),
            what: e.to_string(),
        })?;
        let view = JsonView::whole(&value, PLACEMENT_FILE)?;
        let (rotation, shift) = rigid(&view, "transform")?;
        let scale = view.required("scale")?;
        if !(scale > 1e-9 && scale < 1e9) {
            return Err(view.fault("scale", format!("{scale} is not a scale; it is above 0")));
        }
        Ok(Placement { rotation, shift, scale })
    }

    /// What the top of a `transforms.json` says has been done to its poses.
    pub(super) fn applied(file: &Value) -> Result<Placement, CameraError> {
        let view = JsonView::whole(file, "transforms.json")?;
        let mut placement = Placement::NONE;
        if view.has("applied_transform") {
            (placement.rotation, placement.shift) = rigid(&view, "applied_transform")?;
        }
        if let Some(scale) = view.number("applied_scale")? {
            if !(scale > 1e-9 && scale < 1e9) {
                let what = format!("{scale} is not a scale; it is above 0");
                return Err(view.fault("applied_scale", what));
            }
            placement.scale = scale;
        }
        Ok(placement)
    }

    /// This one for poses to which `applied` was done before.
    #[must_use]
    pub fn after(&self, applied: &Placement) -> Placement {
        // A pose q is R_a p + t_a for the p that this placement is for.
        let rotation = self.rotation * applied.rotation.transpose();
        Placement {
            rotation,
            shift: self.shift - rotation * applied.shift,
            scale: self.scale / applied.scale,
        }
    }

    /// A camera in the new frame.
    #[must_use]
    pub fn of(&self, camera: &Camera) -> Camera {
        Camera {
            centre: (self.rotation * camera.centre + self.shift) * self.scale,
            world_to_camera: camera.world_to_camera * self.rotation.transpose(),
            ..camera.clone()
        }
    }
}

/// Rotation and shift of the 3x4 or 4x4 matrix at `key`.
fn rigid(view: &JsonView<'_>, key: &'static str) -> Result<(DMat3, DVec3), CameraError> {
    let (rotation, shift) = view.transform(key)?;
    let off = rotation * rotation.transpose() - DMat3::IDENTITY;
    let is_near = off.to_cols_array().iter().all(|v| v.abs() <= ROTATION_TOLERANCE);
    if !is_near || rotation.determinant() < 0.0 || !shift.is_finite() {
        return Err(view.fault(key, "must be a rotation and a shift, in three rows of four"));
    }
    Ok((rotation, shift))
}

/// Whether a JSON object is a camera path of the viewer.
pub(super) fn is_path(file: &Map<String, Value>) -> bool {
    file.get("camera_path").is_some_and(Value::is_array)
}

/// The views of a camera path. They are in the frame of the trained model.
pub(super) fn path(file: &Map<String, Value>) -> Result<CameraFile, CameraError> {
    let Some(Value::Array(poses)) = file.get("camera_path") else {
        return Err(CameraError::Layout);
    };
    let pose = |(idx, value): (usize, &Value)| {
        let view = JsonView::new(idx, value, "name", Some(file))?;
        let kind = view.text("camera_type")?.unwrap_or("perspective");
        if !kind.eq_ignore_ascii_case("perspective") {
            return Err(view.fault("camera_type", nerf::no_pinhole(kind)));
        }
        let need = |key| view.pixels(key)?.ok_or_else(|| view.fault(key, "is missing"));
        let (width, height) = (need("render_width")?, need("render_height")?);
        let fov = match view.number("fov")? {
            Some(fov) => fov,
            None => view.required("default_fov")?,
        };
        if !(fov > 0.0 && fov < 180.0) {
            return Err(view.fault("fov", format!("{fov} degrees; must be above 0, below 180")));
        }
        let focal = 0.5 * f64::from(height) / (fov * PI / 360.0).tan();
        let (rotation, centre) = view.square("camera_to_world")?;
        let camera = Camera {
            name: format!("path_{idx:04}"),
            width,
            height,
            fx: focal,
            fy: focal,
            cx: 0.5 * f64::from(width),
            cy: 0.5 * f64::from(height),
            world_to_camera: nerf::world_to_camera(rotation),
            centre,
            split: None,
            eye: None,
        };
        checked(camera, &view.label, &KEYS)
    };
    let cameras = poses.iter().enumerate().map(pose).collect::<Result<_, _>>()?;
    let (lenses, warnings, doubts) = Default::default();
    let format = "nerfstudio camera path";
    Ok(CameraFile { format, cameras, lenses, warnings, doubts, frame: Frame::Model })
}
