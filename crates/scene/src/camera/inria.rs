//! INRIA `cameras.json`: a list of views with camera-to-world rotation rows and camera position.
//!
//! Besides the keys that INRIA's trainer writes, `cx`, `cy` (pixels from the left and the top
//! edge) and `split` (`train` or `test`) are read and written. Missing `cx`, `cy` mean a centred
//! principal point.

use serde_json::{Map, Value, json};

use super::check::{CameraKeys, checked};
use super::json::JsonView;
use super::{Camera, CameraError, CameraFile, Frame};

const KEYS: CameraKeys = CameraKeys {
    size: ["width", "height"],
    focal: ["fx", "fy"],
    principal: ["cx", "cy"],
    rotation: "rotation",
    centre: "position",
};

/// The views of the file, in its order.
pub(super) fn views(list: &[Value]) -> Result<CameraFile, CameraError> {
    let cameras =
        list.iter().enumerate().map(|(idx, value)| view(idx, value)).collect::<Result<_, _>>()?;
    let (lenses, warnings, doubts) = Default::default();
    let format = "INRIA cameras.json";
    Ok(CameraFile { format, cameras, lenses, warnings, doubts, frame: Frame::Model })
}

fn view(idx: usize, value: &Value) -> Result<Camera, CameraError> {
    let view = JsonView::new(idx, value, "img_name", None)?;
    let pixels =
        |key| view.pixels(key).and_then(|v| v.ok_or_else(|| view.fault(key, "is missing")));
    let (width, height) = (pixels("width")?, pixels("height")?);
    let camera = Camera {
        name: view.text("img_name")?.map_or_else(|| format!("view_{idx:03}"), str::to_string),
        width,
        height,
        fx: view.required("fx")?,
        fy: view.required("fy")?,
        cx: view.number("cx")?.unwrap_or(0.5 * f64::from(width)),
        cy: view.number("cy")?.unwrap_or(0.5 * f64::from(height)),
        world_to_camera: view.matrix("rotation")?.transpose(),
        centre: view.vector("position")?,
        split: view.split()?,
        eye: view.eye()?,
    };
    checked(camera, &view.label, &KEYS)
}

/// Writes views as an INRIA `cameras.json`; [`super::json::read`] gives the same cameras back.
pub fn write(cameras: &[Camera]) -> String {
    let mut text = String::from("[\n");
    for (id, camera) in cameras.iter().enumerate() {
        let separator = if id + 1 < cameras.len() { ",\n" } else { "\n" };
        text.push_str(&Value::Object(object(id, camera)).to_string());
        text.push_str(separator);
    }
    text.push_str("]\n");
    text
}

fn object(id: usize, camera: &Camera) -> Map<String, Value> {
    let m = camera.world_to_camera;
    let rows = [m.col(0).to_array(), m.col(1).to_array(), m.col(2).to_array()];
    let mut object = Map::new();
    let mut put = |key: &str, value| object.insert(key.to_string(), value);
    put("id", json!(id));
    put("img_name", json!(camera.name));
    put("width", json!(camera.width));
    put("height", json!(camera.height));
    put("position", json!(camera.centre.to_array()));
    put("rotation", json!(rows));
    put("fx", json!(camera.fx));
    put("fy", json!(camera.fy));
    put("cx", json!(camera.cx));
    put("cy", json!(camera.cy));
    if let Some(split) = camera.split {
        put("split", json!(split.name()));
    }
    if let Some(eye) = camera.eye {
        put("eye", json!(eye.name()));
    }
    object
}
