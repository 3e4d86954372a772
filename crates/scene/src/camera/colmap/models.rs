//! COLMAP's camera models: how many parameters each has, and which are focal and principal.

use super::super::check::MAX_SIZE;

/// A camera model: COLMAP's id and name, number of parameters, whether one focal length serves
/// both axes, and whether it is a fisheye projection (distorted even where its coefficients are
/// zero).
struct Model {
    id: i32,
    name: &'static str,
    parameters: usize,
    one_focal: bool,
    fisheye: bool,
}

#[rustfmt::skip]
const MODELS: [Model; 11] = [
    Model { id: 0, name: "SIMPLE_PINHOLE", parameters: 3, one_focal: true, fisheye: false },
    Model { id: 1, name: "PINHOLE", parameters: 4, one_focal: false, fisheye: false },
    Model { id: 2, name: "SIMPLE_RADIAL", parameters: 4, one_focal: true, fisheye: false },
    Model { id: 3, name: "RADIAL", parameters: 5, one_focal: true, fisheye: false },
    Model { id: 4, name: "OPENCV", parameters: 8, one_focal: false, fisheye: false },
    Model { id: 5, name: "OPENCV_FISHEYE", parameters: 8, one_focal: false, fisheye: true },
    Model { id: 6, name: "FULL_OPENCV", parameters: 12, one_focal: false, fisheye: false },
    Model { id: 7, name: "FOV", parameters: 5, one_focal: false, fisheye: false },
    Model { id: 8, name: "SIMPLE_RADIAL_FISHEYE", parameters: 4, one_focal: true, fisheye: true },
    Model { id: 9, name: "RADIAL_FISHEYE", parameters: 5, one_focal: true, fisheye: true },
    Model { id: 10, name: "THIN_PRISM_FISHEYE", parameters: 12, one_focal: false, fisheye: true },
];

/// Most parameters of any model.
pub(super) const MAX_PARAMETERS: usize = 12;

/// One entry of `cameras`: the pinhole part of it.
pub(super) struct Intrinsics {
    /// Name of the model.
    pub model: &'static str,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Focal lengths, pixels.
    pub focal: [f64; 2],
    /// Principal point, pixels from the left and top edges.
    pub principal: [f64; 2],
    /// Whether the model bends rays and that is ignored.
    pub distorted: bool,
}

/// The number of parameters of the model with this id.
pub(super) fn parameters_of_id(id: i32) -> Result<usize, String> {
    let model = MODELS.iter().find(|m| m.id == id);
    model.map(|m| m.parameters).ok_or_else(|| format!("{id} is not a camera model; 0 to 10 are"))
}

/// The id of the model with this name.
pub(super) fn id_of_name(name: &str) -> Result<i32, String> {
    let model = MODELS.iter().find(|m| m.name == name);
    let known = || MODELS.map(|m| m.name).join(", ");
    model.map(|m| m.id).ok_or_else(|| format!("`{name}` is not a camera model; use {}", known()))
}

/// Takes the pinhole part out of a camera's parameters.
pub(super) fn intrinsics(
    id: i32,
    width: u64,
    height: u64,
    parameters: &[f64],
) -> Result<Intrinsics, String> {
    let count = parameters_of_id(id)?;
    let model = &MODELS[id as usize];
    if parameters.len() != count {
        let found = parameters.len();
        return Err(format!("{} takes {count} parameters, found {found}", model.name));
    }
    let size = |value: u64| {
        let fits = u32::try_from(value).ok().filter(|v| (1..=MAX_SIZE).contains(v));
        fits.ok_or_else(|| format!("an image side of {value} pixels; must be 1 to {MAX_SIZE}"))
    };
    let (focal, principal, rest) = match parameters {
        [f, cx, cy, rest @ ..] if model.one_focal => ([*f, *f], [*cx, *cy], rest),
        [fx, fy, cx, cy, rest @ ..] => ([*fx, *fy], [*cx, *cy], rest),
        _ => return Err("too few parameters".to_string()),
    };
    Ok(Intrinsics {
        model: model.name,
        width: size(width)?,
        height: size(height)?,
        focal,
        principal,
        distorted: model.fisheye || rest.iter().any(|k| *k != 0.0),
    })
}
