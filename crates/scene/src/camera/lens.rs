//! Lenses that bend rays, and the part of a pinhole view that a photo through one shows.
//!
//! Rays are points (x, y) of the plane at distance 1 in front of a camera. The formulas are those
//! of COLMAP's camera models, which are OpenCV's where the names are.

use super::Camera;

/// Steps along a radius in which it is looked for where a lens turns back.
const STEPS: u32 = 1024;
/// Points on each side of a view that must lie in the photo.
const ON_SIDE: u32 = 64;
/// How far a point may lie outside of the photo: half of its outermost pixels, pixels.
const OUTSIDE: f64 = 0.5;
/// The least share of the width and height of a photo that is left without its lens.
pub const LEAST_SHARE: f64 = 0.2;
/// Halvings of the interval in which the largest share lies: far below a pixel.
const HALVINGS: u32 = 24;

/// How a lens bends rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// A rational function of the squared radius: k1 to k3 over k4 to k6, and p1, p2 for a lens
    /// that is not parallel to the sensor. SIMPLE_RADIAL, RADIAL, OPENCV and FULL_OPENCV.
    Rational {
        /// k1 to k6.
        radial: [f64; 6],
        /// p1 and p2.
        tangential: [f64; 2],
    },
    /// A polynomial of the angle off the axis, k1 to k4. SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE and
    /// OPENCV_FISHEYE.
    Fisheye([f64; 4]),
    /// Radii in proportion to angles, ω radians wide. FOV.
    FieldOfView(f64),
    /// A ray is at its place in the photo over 1 + k r², with r the radius there. SIMPLE_DIVISION
    /// and DIVISION.
    Division(f64),
    /// The enhanced unified model. EUCM.
    Unified {
        /// α, 0 for a pinhole.
        alpha: f64,
        /// β.
        beta: f64,
    },
    /// Project Aria's Fisheye624. RAD_TAN_THIN_PRISM_FISHEYE.
    RadTanThinPrism {
        /// k0 to k5.
        radial: [f64; 6],
        /// p0 and p1.
        tangential: [f64; 2],
        /// s0 to s3.
        prism: [f64; 4],
    },
    /// [`Lens::Rational`] without a denominator on top of a fisheye. THIN_PRISM_FISHEYE.
    ThinPrism {
        /// k1 to k4.
        radial: [f64; 4],
        /// p1 and p2.
        tangential: [f64; 2],
        /// sx1 and sy1.
        prism: [f64; 2],
    },
}

impl Lens {
    /// Whether it bends nothing.
    pub fn is_straight(&self) -> bool {
        match self {
            Lens::Rational { radial, tangential } => {
                radial.iter().chain(tangential).all(|k| *k == 0.0)
            }
            Lens::FieldOfView(omega) => *omega == 0.0,
            Lens::Division(k) => *k == 0.0,
            Lens::Unified { alpha, .. } => *alpha == 0.0,
            Lens::Fisheye(_) | Lens::ThinPrism { .. } | Lens::RadTanThinPrism { .. } => false,
        }
    }

    /// Where the photo has what a pinhole camera has at `ray`.
    pub fn bent(&self, ray: [f64; 2]) -> [f64; 2] {
        let [x, y] = ray;
        let r2 = x * x + y * y;
        match self {
            Lens::Rational { radial: [k1, k2, k3, k4, k5, k6], tangential } => {
                let factor = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3)))
                    / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
                let [dx, dy] = off_axis(ray, r2, *tangential);
                [x * factor + dx, y * factor + dy]
            }
            Lens::Fisheye(radial) => {
                let factor = per_radius(r2, |theta| theta * (1.0 + even(theta, radial)));
                [x * factor, y * factor]
            }
            Lens::FieldOfView(omega) => {
                let wide = 2.0 * (0.5 * omega).tan();
                let factor = match omega.abs() < 1e-6 {
                    true => 1.0,
                    false if r2 < 1e-12 => wide / omega,
                    false => (r2.sqrt() * wide).atan() / (r2.sqrt() * omega),
                };
                [x * factor, y * factor]
            }
            Lens::Division(k) => {
                // Beyond the last ray that the lens takes in there is no number.
                let factor = 2.0 / (1.0 + (1.0 - 4.0 * k * r2).sqrt());
                [x * factor, y * factor]
            }
            Lens::Unified { alpha, beta } => {
                let depth = alpha * (beta * r2 + 1.0).sqrt() + 1.0 - alpha;
                [x / depth, y / depth]
            }
            Lens::RadTanThinPrism { radial, tangential: [p0, p1], prism: [s0, s1, s2, s3] } => {
                let factor = per_radius(r2, |theta| {
                    let t2 = theta * theta;
                    theta * (1.0 + t2 * radial.iter().rev().fold(0.0, |sum, k| sum * t2 + k))
                });
                let ray = [x * factor, y * factor];
                let r2 = ray[0] * ray[0] + ray[1] * ray[1];
                let shift = off_axis(ray, r2, [*p1, *p0]);
                let prism = [r2 * (s0 + s1 * r2), r2 * (s2 + s3 * r2)];
                std::array::from_fn(|i| ray[i] + shift[i] + prism[i])
            }
            Lens::ThinPrism { radial, tangential, prism } => {
                let factor = per_radius(r2, |theta| theta);
                let ray = [x * factor, y * factor];
                let r2 = ray[0] * ray[0] + ray[1] * ray[1];
                let more = even(r2.sqrt(), radial);
                let shift = off_axis(ray, r2, *tangential);
                std::array::from_fn(|i| ray[i] * (1.0 + more) + shift[i] + prism[i] * r2)
            }
        }
    }

    /// Up to which radius of rays radii in the photo grow with it, looked for up to `most`: beyond
    /// it the polynomials of a lens mean nothing.
    fn reach(&self, most: f64) -> f64 {
        let straight = match *self {
            Lens::Rational { radial, .. } => Lens::Rational { radial, tangential: [0.0; 2] },
            Lens::ThinPrism { radial, .. } => {
                Lens::ThinPrism { radial, tangential: [0.0; 2], prism: [0.0; 2] }
            }
            Lens::RadTanThinPrism { radial, .. } => {
                Lens::RadTanThinPrism { radial, tangential: [0.0; 2], prism: [0.0; 4] }
            }
            lens @ (Lens::Fisheye(_)
            | Lens::FieldOfView(_)
            | Lens::Division(_)
            | Lens::Unified { .. }) => lens,
        };
        let (mut last, mut reach) = (0.0, 0.0);
        for step in 1..=STEPS {
            let radius = most * f64::from(step) / f64::from(STEPS);
            let shown = straight.bent([radius, 0.0])[0];
            if !(shown > last && shown.is_finite()) {
                return reach;
            }
            (last, reach) = (shown, radius);
        }
        most
    }
}

/// k1 v² + k2 v⁴ + k3 v⁶ + k4 v⁸.
fn even(v: f64, [k1, k2, k3, k4]: &[f64; 4]) -> f64 {
    let v2 = v * v;
    v2 * (k1 + v2 * (k2 + v2 * (k3 + v2 * k4)))
}

/// The shift by a lens that is not parallel to the sensor.
fn off_axis([x, y]: [f64; 2], r2: f64, [p1, p2]: [f64; 2]) -> [f64; 2] {
    let xy = 2.0 * x * y;
    [p1 * xy + p2 * (r2 + 2.0 * x * x), p2 * xy + p1 * (r2 + 2.0 * y * y)]
}

/// A radius that is a function of the angle off the axis, over that of the ray.
fn per_radius(r2: f64, of: impl Fn(f64) -> f64) -> f64 {
    let r = r2.sqrt();
    if r < 1e-9 { 1.0 } else { of(r.atan()) / r }
}

/// The largest pinhole view of the same pose, focal length and aspect that a photo of `camera`
/// through `lens` shows everywhere; it is never larger than the photo. `None` if it has less than
/// [`LEAST_SHARE`] of its width and height.
pub fn without_lens(camera: &Camera, lens: &Lens) -> Option<Camera> {
    let all = |share: f64| view(camera, share).filter(|view| is_shown(view, camera, lens));
    if let Some(whole) = all(1.0) {
        return Some(whole);
    }
    let (mut low, mut high) = (LEAST_SHARE, 1.0);
    let mut found = all(low)?;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        match all(middle) {
            Some(view) => (low, found) = (middle, view),
            None => high = middle,
        }
    }
    Some(found)
}

/// The part of a view around its principal point.
fn view(camera: &Camera, share: f64) -> Option<Camera> {
    let cut = |principal: f64, side: u32| {
        let side = f64::from(side);
        let first = (principal * (1.0 - share)).clamp(0.0, side).ceil();
        let end = (principal + share * (side - principal)).clamp(0.0, side).floor();
        (end > first).then_some((first, (end - first) as u32))
    };
    let ((x, width), (y, height)) = (cut(camera.cx, camera.width)?, cut(camera.cy, camera.height)?);
    Some(Camera { width, height, cx: camera.cx - x, cy: camera.cy - y, ..camera.clone() })
}

/// Whether the photo shows the border of the view, and so all of it.
fn is_shown(view: &Camera, photo: &Camera, lens: &Lens) -> bool {
    let (width, height) = (f64::from(view.width), f64::from(view.height));
    let ray = |x: f64, y: f64| [(x - view.cx) / view.fx, (y - view.cy) / view.fy];
    let side = |i: u32| f64::from(i) / f64::from(ON_SIDE);
    let border: Vec<[f64; 2]> = (0..=ON_SIDE)
        .map(side)
        .flat_map(|t| {
            [(t * width, 0.0), (t * width, height), (0.0, t * height), (width, t * height)]
        })
        .map(|(x, y)| ray(x, y))
        .collect();
    let radius = |[x, y]: &[f64; 2]| x.hypot(*y);
    let most = border.iter().map(radius).fold(0.0, f64::max);
    let is_in = |[x, y]: [f64; 2]| {
        let (px, py) = (x * photo.fx + photo.cx, y * photo.fy + photo.cy);
        (-OUTSIDE..=f64::from(photo.width) + OUTSIDE).contains(&px)
            && (-OUTSIDE..=f64::from(photo.height) + OUTSIDE).contains(&py)
    };
    lens.reach(most) >= most && border.into_iter().all(|ray| is_in(lens.bent(ray)))
}
