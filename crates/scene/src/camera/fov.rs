//! Fields of view: angles of a viewer's eyes, and those of headsets.

use std::str::FromStr;

use super::{Camera, Eye};

/// The largest angle between the viewing direction and an edge of the image, degrees: beyond it a
/// flat image grows without bound.
const EDGE_MAX: f64 = 85.0;

/// Angles from the viewing direction to the edges of an image, degrees. The outer edge is that of
/// the temple: the left one of the left eye, the right one of the right eye. A view that is for no
/// eye has its outer edge on the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldOfView {
    /// To the outer edge.
    pub outer: f64,
    /// To the inner edge.
    pub inner: f64,
    /// To the upper and the lower edge; `None`: whatever square pixels give, with the middle of the
    /// image straight ahead.
    pub vertical: Option<[f64; 2]>,
}

impl FromStr for FieldOfView {
    type Err = String;

    /// `90`, `90x96`, or with the parts of an off-centre frustum `52+45x48+50`: outer and inner,
    /// upper and lower.
    fn from_str(text: &str) -> Result<FieldOfView, String> {
        let wrong = || {
            format!(
                "write degrees as 90, 90x96 or OUTER+INNERxUP+DOWN (52+45x48+50), each edge above \
                 0 and at most {EDGE_MAX} degrees from the viewing direction"
            )
        };
        let edge = |text: &str, share: f64| {
            let degrees: f64 = text.trim().parse().ok()?;
            Some(degrees * share).filter(|d| *d > 0.0 && *d <= EDGE_MAX)
        };
        let side = |text: &str| match text.split_once('+') {
            Some((a, b)) => Some([edge(a, 1.0)?, edge(b, 1.0)?]),
            None => Some([edge(text, 0.5)?; 2]),
        };
        let (horizontal, vertical) = match text.split_once(['x', 'X']) {
            Some((h, v)) => (h, Some(v)),
            None => (text, None),
        };
        let [outer, inner] = side(horizontal).ok_or_else(wrong)?;
        let vertical = vertical.map(|v| side(v).ok_or_else(wrong)).transpose()?;
        Ok(FieldOfView { outer, inner, vertical })
    }
}

impl FieldOfView {
    /// The view with this field of view: another focal length and principal point, the same size.
    pub fn of(&self, camera: &Camera) -> Camera {
        let tan = |degrees: f64| degrees.to_radians().tan();
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        let [left, right] = match camera.eye {
            Some(Eye::Right) => [self.inner, self.outer],
            Some(Eye::Left) | None => [self.outer, self.inner],
        }
        .map(tan);
        let fx = width / (left + right);
        let (fy, cy) = match self.vertical {
            None => (fx, 0.5 * height),
            Some(edges) => {
                let [up, down] = edges.map(tan);
                let fy = height / (up + down);
                (fy, fy * up)
            }
        };
        Camera { fx, fy, cx: fx * left, cy, ..camera.clone() }
    }
}

/// What is public of a headset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Headset {
    /// Its name here.
    pub name: &'static str,
    /// Pixels of the panel of an eye, width and height.
    pub size: (u32, u32),
    /// The field of view of an eye.
    pub fov: FieldOfView,
    /// Refresh rates, Hz, the usual one first.
    pub rates: &'static [f64],
    /// Where the figures are from, and what is assumed of them.
    pub source: &'static str,
}

const fn eye(outer: f64, inner: f64, up: f64, down: f64) -> FieldOfView {
    FieldOfView { outer, inner, vertical: Some([up, down]) }
}

/// The headsets that are known. Angles are those that the runtime of a headset asks to be rendered,
/// as read out by hmdq and collected in the HMD Geometry Database (risa2000.github.io/hmdgdb),
/// where nothing else is said. Renderers draw more pixels than a panel has, because lenses distort;
/// the sizes here are those of panels.
pub const HEADSETS: [Headset; 5] = [
    Headset {
        name: "quest-3",
        size: (2064, 2208),
        fov: eye(55.0, 45.0, 48.0, 48.0),
        rates: &[72.0, 90.0, 120.0],
        source: "Meta: 2064x2208 an eye, 110 x 96 degrees for both eyes together; the inner edge \
                 is not published and taken from quest-2",
    },
    Headset {
        name: "quest-2",
        size: (1832, 1920),
        fov: eye(52.0, 45.0, 48.0, 50.0),
        rates: &[72.0, 90.0, 120.0],
        source: "hmdgdb, Quest 2 at 72 Hz; panel: Meta",
    },
    Headset {
        name: "vive-focus-3",
        size: (2448, 2448),
        fov: eye(58.22, 40.13, 48.27, 48.31),
        rates: &[90.0],
        source: "hmdgdb, Vive Focus 3; panel: HTC",
    },
    Headset {
        name: "pimax-crystal",
        size: (2880, 2880),
        fov: eye(51.65, 41.65, 51.88, 51.88),
        rates: &[120.0, 90.0, 72.0],
        source: "hmdgdb, Pimax Crystal at 120 Hz; panel: Pimax",
    },
    Headset {
        name: "rift-cv1",
        size: (1080, 1200),
        fov: eye(43.98, 35.57, 41.65, 48.01),
        rates: &[90.0],
        source: "hmdgdb, Rift CV1; panel: Oculus",
    },
];

/// The headset called `name`.
///
/// # Errors
/// The names that are known.
pub fn headset(name: &str) -> Result<Headset, String> {
    let known = || HEADSETS.map(|headset| headset.name).join(", ");
    let found = HEADSETS.into_iter().find(|headset| headset.name == name);
    found.ok_or_else(|| format!("no headset `{name}`; known are {}", known()))
}
