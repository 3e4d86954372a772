//! The check of cameras from every source.

use glam::{DMat3, DMat4, DVec4};

use super::{Camera, CameraError};

/// Largest width and height, pixels.
pub const MAX_SIZE: u32 = 65_536;
/// Largest distance of a camera from the origin, world units: products of such values still fit
/// the single precision of the rasteriser.
pub const MAX_DISTANCE: f64 = 1e9;
/// Range of focal lengths, pixels.
pub(crate) const FOCAL_RANGE: (f64, f64) = (1e-3, 1e7);
/// How far `R Rᵀ` may be from the identity, per element, and still be taken for a rotation that
/// was rounded when it was written.
pub(crate) const ROTATION_TOLERANCE: f64 = 1e-3;
/// Below this a rotation is kept bit for bit.
const ROTATION_EXACT: f64 = 1e-14;

/// How far a principal point may be from the middle, as a share of width or height: off-centre
/// frusta of headsets are nearer.
const OFF_MIDDLE: f64 = 0.2;
/// The factor within which two shares are those of one picture.
const ALIKE: f64 = 1.1;

/// Key names of one file layout, for messages.
pub(super) struct CameraKeys {
    /// Image width and height.
    pub size: [&'static str; 2],
    /// Focal lengths.
    pub focal: [&'static str; 2],
    /// Principal point.
    pub principal: [&'static str; 2],
    /// The rotation.
    pub rotation: &'static str,
    /// The position.
    pub centre: &'static str,
}

/// Checks a camera and makes its rotation exactly orthonormal. `view` names it in messages.
pub(super) fn checked(
    mut camera: Camera,
    view: &str,
    keys: &CameraKeys,
) -> Result<Camera, CameraError> {
    let fault = |key, what| CameraError::Value { view: view.to_string(), key, what };
    for (value, key) in [(camera.width, keys.size[0]), (camera.height, keys.size[1])] {
        if !(1..=MAX_SIZE).contains(&value) {
            return Err(fault(key, format!("{value} pixels; must be 1 to {MAX_SIZE}")));
        }
    }
    for (value, key) in [(camera.fx, keys.focal[0]), (camera.fy, keys.focal[1])] {
        let (low, high) = FOCAL_RANGE;
        if !(low..=high).contains(&value) {
            let what = format!("a focal length of {value} pixels; must be {low} to {high}");
            return Err(fault(key, what));
        }
    }
    for (value, key) in [(camera.cx, keys.principal[0]), (camera.cy, keys.principal[1])] {
        if !(-FOCAL_RANGE.1..=FOCAL_RANGE.1).contains(&value) {
            return Err(fault(key, format!("{value} pixels is not a principal point")));
        }
    }
    let near = |v: f64| (-MAX_DISTANCE..=MAX_DISTANCE).contains(&v);
    if !camera.centre.to_array().into_iter().all(near) {
        let what = format!("the camera is at {}; must be finite, below 1e9", camera.centre);
        return Err(fault(keys.centre, what));
    }
    camera.world_to_camera =
        rotation(camera.world_to_camera).map_err(|what| fault(keys.rotation, what))?;
    Ok(camera)
}

/// A camera of the matrices of computer vision: `intrinsics` with focal lengths and principal point
/// in pixels from the left and top edges, and the pose from world to camera, in which x points to
/// the right, y down and z forward. `size` is in pixels.
///
/// # Errors
/// [`CameraError::Value`]: skew, a pose that is no rotation and translation, values out of range.
pub fn of_matrices(
    name: &str,
    intrinsics: DMat3,
    world_to_camera: DMat4,
    size: [u32; 2],
) -> Result<Camera, CameraError> {
    let keys = CameraKeys {
        size: ["size"; 2],
        focal: ["K"; 2],
        principal: ["K"; 2],
        rotation: "world_to_camera",
        centre: "world_to_camera",
    };
    let fault = |key, what: &str| {
        Err(CameraError::Value { view: name.to_owned(), key, what: what.to_owned() })
    };
    let k = |row: usize, column: usize| intrinsics.col(column)[row];
    if [k(0, 1), k(1, 0), k(2, 0), k(2, 1)].iter().any(|x| *x != 0.0) || k(2, 2) != 1.0 {
        return fault("K", "is not [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; skew is not rendered");
    }
    let last = world_to_camera.row(3);
    if last != DVec4::W {
        return fault("world_to_camera", "its last row is not 0 0 0 1");
    }
    let rotation = DMat3::from_mat4(world_to_camera);
    let translation = world_to_camera.w_axis.truncate();
    let camera = Camera {
        name: name.to_owned(),
        width: size[0],
        height: size[1],
        fx: k(0, 0),
        fy: k(1, 1),
        cx: k(0, 2),
        cy: k(1, 2),
        world_to_camera: rotation,
        centre: -(rotation.transpose() * translation),
        split: None,
        eye: None,
    };
    checked(camera, name, &keys)
}

/// A sentence about views whose principal point is far from the middle of the image: intrinsics of
/// another picture, where both shares are alike.
pub(crate) fn principal_doubt(cameras: &[Camera]) -> Option<String> {
    let shares = |c: &Camera| [c.cx / f64::from(c.width), c.cy / f64::from(c.height)];
    let is_off = |share: &f64| (share - 0.5).abs() > OFF_MIDDLE;
    // The frusta of eyes are off the middle on purpose.
    let is_odd = |c: &&Camera| c.eye.is_none() && shares(c).iter().any(is_off);
    let mut odd = cameras.iter().filter(is_odd);
    let first = odd.next()?;
    let (count, all) = (1 + odd.count(), cameras.len());
    let Camera { name, width, height, cx, cy, .. } = first;
    let [x, y] = shares(first);
    let percent = |share: f64| (100.0 * share).round();
    let place = format!(
        "{count} of {all} views have their principal point far from the middle of the image \
         ({name}: at {} % of the width and {} % of the height)",
        percent(x),
        percent(y)
    );
    let is_scaled = x > 0.0 && y > 0.0 && (x / y).ln().abs() < ALIKE.ln();
    Some(if is_scaled {
        format!(
            "{place}, as intrinsics of a picture of {:.0}x{:.0} have it, and the image size is \
             {width}x{height}: if so, focal lengths and fields of view are wrong; give all of them \
             for one size",
            2.0 * cx,
            2.0 * cy
        )
    } else {
        format!("{place}: is the picture a part of another one?")
    })
}

/// The nearest rotation to `m`, which must be one within [`ROTATION_TOLERANCE`].
fn rotation(m: DMat3) -> Result<DMat3, String> {
    if !m.is_finite() {
        return Err("holds a number that is not finite".to_string());
    }
    let error = orthonormality_error(m);
    if error > ROTATION_TOLERANCE {
        return Err(format!(
            "is not a rotation: its rows are off orthonormal by {error:.3}, at most \
             {ROTATION_TOLERANCE} is put down to rounding; remove scale and shear from the pose"
        ));
    }
    if m.determinant() < 0.0 {
        return Err("is a reflection (determinant -1); swap or negate one axis".to_string());
    }
    if error <= ROTATION_EXACT {
        return Ok(m);
    }
    // Newton's iteration to the polar factor; quadratic, so three steps from 1e-3 reach 1e-24.
    let step = |m: DMat3| (m + m.inverse().transpose()) * 0.5;
    Ok(step(step(step(m))))
}

/// Largest element of `|R Rᵀ - I|`; huge where it overflows.
fn orthonormality_error(m: DMat3) -> f64 {
    let d = m * m.transpose() - DMat3::IDENTITY;
    if d.is_finite() { d.to_cols_array().iter().fold(0.0, |w, x| x.abs().max(w)) } else { f64::MAX }
}
