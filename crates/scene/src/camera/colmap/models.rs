//! COLMAP's camera models: how many parameters each has, which are focal and principal, and how
//! the others bend rays.

use super::super::check::MAX_SIZE;
use super::super::lens::Lens;

/// A camera model: COLMAP's id and name, number of parameters, whether one focal length serves
/// both axes, and the lens that follows from the parameters after the principal point.
struct Model {
    id: i32,
    name: &'static str,
    parameters: usize,
    one_focal: bool,
    lens: fn(&[f64]) -> Lens,
}

#[rustfmt::skip]
const MODELS: [Model; 17] = [
    Model { id: 0, name: "SIMPLE_PINHOLE", parameters: 3, one_focal: true, lens: radial },
    Model { id: 1, name: "PINHOLE", parameters: 4, one_focal: false, lens: radial },
    Model { id: 2, name: "SIMPLE_RADIAL", parameters: 4, one_focal: true, lens: radial },
    Model { id: 3, name: "RADIAL", parameters: 5, one_focal: true, lens: radial },
    Model { id: 4, name: "OPENCV", parameters: 8, one_focal: false, lens: opencv },
    Model { id: 5, name: "OPENCV_FISHEYE", parameters: 8, one_focal: false, lens: fisheye },
    Model { id: 6, name: "FULL_OPENCV", parameters: 12, one_focal: false, lens: opencv },
    Model { id: 7, name: "FOV", parameters: 5, one_focal: false, lens: field_of_view },
    Model { id: 8, name: "SIMPLE_RADIAL_FISHEYE", parameters: 4, one_focal: true, lens: fisheye },
    Model { id: 9, name: "RADIAL_FISHEYE", parameters: 5, one_focal: true, lens: fisheye },
    Model { id: 10, name: "THIN_PRISM_FISHEYE", parameters: 12, one_focal: false, lens: prism },
    Model {
        id: 11, name: "RAD_TAN_THIN_PRISM_FISHEYE", parameters: 16, one_focal: false, lens: aria,
    },
    Model { id: 12, name: "SIMPLE_DIVISION", parameters: 4, one_focal: true, lens: division },
    Model { id: 13, name: "DIVISION", parameters: 5, one_focal: false, lens: division },
    Model { id: 14, name: "SIMPLE_FISHEYE", parameters: 3, one_focal: true, lens: fisheye },
    Model { id: 15, name: "FISHEYE", parameters: 4, one_focal: false, lens: fisheye },
    Model { id: 16, name: "EUCM", parameters: 6, one_focal: false, lens: eucm },
];

/// Most parameters of any model.
pub(super) const MAX_PARAMETERS: usize = 16;
/// The id and name of COLMAP's panoramas, which are no pinhole views at all.
const PANORAMA: (i32, &str) = (17, "EQUIRECTANGULAR");

/// One entry of `cameras`.
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
    /// The lens, if it bends rays.
    pub lens: Option<Lens>,
}

/// Coefficient `i` of those that a model has; 0 where it has none.
fn at(rest: &[f64], i: usize) -> f64 {
    rest.get(i).copied().unwrap_or(0.0)
}

/// k1, k2.
fn radial(rest: &[f64]) -> Lens {
    let radial = [at(rest, 0), at(rest, 1), 0.0, 0.0, 0.0, 0.0];
    Lens::Rational { radial, tangential: [0.0; 2] }
}

/// k1, k2, p1, p2, k3 to k6.
fn opencv(rest: &[f64]) -> Lens {
    let radial = [0, 1, 4, 5, 6, 7].map(|i| at(rest, i));
    Lens::Rational { radial, tangential: [at(rest, 2), at(rest, 3)] }
}

/// k1 to k4.
fn fisheye(rest: &[f64]) -> Lens {
    Lens::Fisheye(std::array::from_fn(|i| at(rest, i)))
}

/// ω.
fn field_of_view(rest: &[f64]) -> Lens {
    Lens::FieldOfView(at(rest, 0))
}

/// k1, k2, p1, p2, k3, k4, sx1, sy1.
fn prism(rest: &[f64]) -> Lens {
    Lens::ThinPrism {
        radial: [0, 1, 4, 5].map(|i| at(rest, i)),
        tangential: [at(rest, 2), at(rest, 3)],
        prism: [at(rest, 6), at(rest, 7)],
    }
}

/// k0 to k5, p0, p1, s0 to s3.
fn aria(rest: &[f64]) -> Lens {
    Lens::RadTanThinPrism {
        radial: std::array::from_fn(|i| at(rest, i)),
        tangential: [at(rest, 6), at(rest, 7)],
        prism: std::array::from_fn(|i| at(rest, 8 + i)),
    }
}

/// k.
fn division(rest: &[f64]) -> Lens {
    Lens::Division(at(rest, 0))
}

/// α, β.
fn eucm(rest: &[f64]) -> Lens {
    Lens::Unified { alpha: at(rest, 0), beta: at(rest, 1) }
}

/// Whether a `transforms.json` may call a camera so.
pub(in super::super) fn is_known(name: &str) -> bool {
    MODELS.iter().any(|model| model.name == name)
}

fn unknown(what: &str) -> String {
    let known = MODELS.map(|m| m.name).join(", ");
    format!("{what} is not a camera model that is known here; undistort the images to {known}")
}

fn panorama() -> String {
    let (id, name) = PANORAMA;
    format!("model {id} ({name}) is a panorama, not a pinhole view; cut pinhole views out of it")
}

/// The number of parameters of the model with this id.
pub(super) fn parameters_of_id(id: i32) -> Result<usize, String> {
    let model = MODELS.iter().find(|m| m.id == id);
    match model {
        Some(model) => Ok(model.parameters),
        None if id == PANORAMA.0 => Err(panorama()),
        None => Err(unknown(&format!("{id}"))),
    }
}

/// The id of the model with this name.
pub(super) fn id_of_name(name: &str) -> Result<i32, String> {
    let model = MODELS.iter().find(|m| m.name == name);
    match model {
        Some(model) => Ok(model.id),
        None if name == PANORAMA.1 => Err(panorama()),
        None => Err(unknown(&format!("`{name}`"))),
    }
}

/// The pinhole part and the lens of a camera's parameters.
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
    let lens = Some((model.lens)(rest)).filter(|lens| !lens.is_straight());
    Ok(Intrinsics {
        model: model.name,
        width: size(width)?,
        height: size(height)?,
        focal,
        principal,
        lens,
    })
}
