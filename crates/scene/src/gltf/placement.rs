//! Where a node puts its Gaussians: a scale, a rotation and a shift.
//!
//! Colours that depend on the direction are turned, too. Real spherical harmonics are orthonormal,
//! so that the matrix that turns the functions of a degree holds the integrals over the sphere of a
//! turned function times another. Their products are polynomials of degree six at most, for which a
//! rule with four heights and eight points around is exact.

use glam::{DMat3, DQuat, DVec3};
use serde_json::Value;

use super::super::Gaussians;
use super::super::error::{REEXPORT, SceneError};
use super::AXES;
use super::document::wrong;

/// How far a matrix may be from a rotation that is scaled, per element.
const TOLERANCE: f64 = 1e-4;
/// Heights and weights of the Gauss-Legendre rule with four points.
const HEIGHTS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
];
/// Points around.
const AROUND: u32 = 8;

/// p' = s R p + t, in the axes of glTF.
#[derive(Debug, Clone, Copy)]
pub(super) struct GltfPlacement {
    scale: f64,
    rotation: DMat3,
    shift: DVec3,
}

impl GltfPlacement {
    pub(super) const NONE: GltfPlacement =
        GltfPlacement { scale: 1.0, rotation: DMat3::IDENTITY, shift: DVec3::ZERO };

    /// That of a node by itself: its `matrix`, or its `scale`, `rotation` and `translation`.
    pub(super) fn of_node(keys: &Value, place: &str) -> Result<GltfPlacement, SceneError> {
        let numbers = |key: &'static str, n: usize| -> Result<Option<Vec<f64>>, SceneError> {
            let Some(list) = keys.get(key) else { return Ok(None) };
            let values: Option<Vec<f64>> =
                list.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
            match values.filter(|v| v.len() == n && v.iter().all(|x| x.is_finite())) {
                Some(values) => Ok(Some(values)),
                None => Err(wrong(place, format!("{key} is not {n} numbers"))),
            }
        };
        let vector = |v: &[f64]| DVec3::new(v[0], v[1], v[2]);
        let (linear, shift) = if let Some(m) = numbers("matrix", 16)? {
            (DMat3::from_cols(vector(&m), vector(&m[4..]), vector(&m[8..])), vector(&m[12..]))
        } else {
            let turn = numbers("rotation", 4)?;
            let turn = turn.map_or(DQuat::IDENTITY, |q| DQuat::from_xyzw(q[0], q[1], q[2], q[3]));
            let scale = numbers("scale", 3)?.map_or(DVec3::ONE, |s| vector(&s));
            let shift = numbers("translation", 3)?.map_or(DVec3::ZERO, |t| vector(&t));
            (DMat3::from_quat(turn.normalize()) * DMat3::from_diagonal(scale), shift)
        };
        let scale = linear.determinant().cbrt();
        let rotation = linear * scale.recip();
        let off = rotation * rotation.transpose() - DMat3::IDENTITY;
        let is_turn = off.to_cols_array().iter().all(|v| v.abs() < TOLERANCE);
        if !(scale > 0.0 && is_turn) {
            let what = "scales unevenly, shears or mirrors, and Gaussians of it would have other \
                        colours";
            let place = format!("glTF, {place}");
            return Err(SceneError::malformed(place, what, REEXPORT));
        }
        // Exactly a rotation, so that quaternions and colours keep their lengths.
        let rotation = DMat3::from_quat(DQuat::from_mat3(&rotation).normalize());
        Ok(GltfPlacement { scale, rotation, shift })
    }

    /// That of a node below this one.
    pub(super) fn then(&self, below: &GltfPlacement) -> GltfPlacement {
        GltfPlacement {
            scale: self.scale * below.scale,
            rotation: self.rotation * below.rotation,
            shift: self.rotation * below.shift * self.scale + self.shift,
        }
    }

    /// Moves Gaussians that have the axes of PLY.
    pub(super) fn apply(&self, scene: &mut Gaussians) {
        let axes = DMat3::from_diagonal(DVec3::from_array(AXES));
        let (rotation, shift) = (axes * self.rotation * axes, axes * self.shift);
        if rotation == DMat3::IDENTITY && shift == DVec3::ZERO && self.scale == 1.0 {
            return;
        }
        for mean in &mut scene.means {
            let moved = rotation * DVec3::from_array(mean.map(f64::from)) * self.scale + shift;
            *mean = moved.to_array().map(|v| v as f32);
        }
        let more = self.scale.ln() as f32;
        scene.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s += more);
        if rotation == DMat3::IDENTITY {
            return;
        }
        let turn = DQuat::from_mat3(&rotation);
        for q in &mut scene.rotations {
            let [w, x, y, z] = q.map(f64::from);
            let turned = turn * DQuat::from_xyzw(x, y, z, w);
            *q = [turned.w, turned.x, turned.y, turned.z].map(|v| v as f32);
        }
        turn_colours(scene, &rotation);
    }
}

/// Turns Gaussians from the axes of glTF to those of PLY, or back: half a turn about x.
pub(super) fn turn_axes(scene: &mut Gaussians) {
    let [_, y, z] = AXES.map(|sign| sign as f32);
    scene.means.iter_mut().for_each(|m| *m = [m[0], m[1] * y, m[2] * z]);
    scene.rotations.iter_mut().for_each(|q| *q = [q[0], q[1], q[2] * y, q[3] * z]);
    turn_colours(scene, &DMat3::from_diagonal(DVec3::from_array(AXES)));
}

/// Turns the colours of Gaussians by `rotation`.
fn turn_colours(scene: &mut Gaussians, rotation: &DMat3) {
    let each = scene.sh_coefficients();
    if each == 1 {
        return;
    }
    let matrix = turning(rotation);
    let degrees = usize::from(scene.sh_degree);
    for channel in scene.sh.chunks_exact_mut(each) {
        let mut old = [0.0; 16];
        old.iter_mut().zip(&*channel).for_each(|(old, c)| *old = f64::from(*c));
        for degree in 1..=degrees {
            let band = degree * degree..(degree + 1) * (degree + 1);
            for row in band.clone() {
                let sum: f64 = band.clone().map(|k| matrix[row][k] * old[k]).sum();
                channel[row] = sum as f32;
            }
        }
    }
}

/// The matrix that turns coefficients: what is seen along d is then seen along R d.
fn turning(rotation: &DMat3) -> [[f64; 16]; 16] {
    let mut matrix = [[0.0; 16]; 16];
    for (height, weight) in HEIGHTS {
        let radius = (1.0 - height * height).sqrt();
        for point in 0..AROUND {
            let angle = std::f64::consts::TAU * f64::from(point) / f64::from(AROUND);
            let d = DVec3::new(radius * angle.cos(), radius * angle.sin(), height);
            let (before, after) = (harmonics(d), harmonics(*rotation * d));
            let share = weight * std::f64::consts::TAU / f64::from(AROUND);
            for (row, after) in matrix.iter_mut().zip(after) {
                row.iter_mut().zip(before).for_each(|(sum, b)| *sum += share * after * b);
            }
        }
    }
    for value in matrix.iter_mut().flatten() {
        // Turns by quarters, of which most are, move coefficients without changing them.
        for exact in [-1.0, 0.0, 1.0] {
            if (*value - exact).abs() < 1e-14 {
                *value = exact;
            }
        }
    }
    matrix
}

/// The real spherical harmonics of degrees 0 to 3 with the signs of 3DGS.
fn harmonics(d: DVec3) -> [f64; 16] {
    let [x, y, z] = d.to_array();
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        0.282_094_791_773_878_14,
        -0.488_602_511_902_919_9 * y,
        0.488_602_511_902_919_9 * z,
        -0.488_602_511_902_919_9 * x,
        1.092_548_430_592_079_2 * x * y,
        -1.092_548_430_592_079_2 * y * z,
        0.315_391_565_252_520_05 * (2.0 * zz - xx - yy),
        -1.092_548_430_592_079_2 * x * z,
        0.546_274_215_296_039_6 * (xx - yy),
        -0.590_043_589_926_643_5 * y * (3.0 * xx - yy),
        2.890_611_442_640_554 * x * y * z,
        -0.457_045_799_464_465_8 * y * (4.0 * zz - xx - yy),
        0.373_176_332_590_115_4 * z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
        -0.457_045_799_464_465_8 * x * (4.0 * zz - xx - yy),
        1.445_305_721_320_277 * z * (xx - yy),
        -0.590_043_589_926_643_5 * x * (xx - 3.0 * yy),
    ]
}
