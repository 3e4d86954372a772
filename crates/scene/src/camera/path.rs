//! A smooth path through given poses.
//!
//! Centres and rotations follow one non-uniform Catmull-Rom spline. Its knots are spaced by the
//! square root of how far apart two poses are (centripetal: no cusps or loops between unevenly
//! spaced poses); a turn counts like a move. Rotations are splined as unit quaternions of
//! consistent sign and normalised, which is smooth as long as neighbouring poses differ by less
//! than half a turn. The path passes through every pose, and moves with continuous velocity.

use glam::{DMat3, DQuat, DVec3, DVec4};

use super::Camera;
use super::edit::resized;

/// A path that passes through poses.
#[derive(Debug, Clone)]
pub struct Path {
    keys: Vec<PathKey>,
    first: Camera,
}

#[derive(Debug, Clone, Copy)]
struct PathKey {
    knot: f64,
    centre: DVec3,
    quaternion: DVec4,
    /// fx, fy, cx, cy.
    intrinsics: DVec4,
}

impl Path {
    /// A path through the poses of `cameras` in their order. All get the image size of the first
    /// (by [`resized`]). `None` with fewer than two cameras.
    pub fn through(cameras: &[Camera]) -> Option<Path> {
        let first = cameras.first().filter(|_| cameras.len() > 1)?;
        let mut keys: Vec<PathKey> = Vec::with_capacity(cameras.len());
        for camera in cameras {
            let camera = resized(camera, first.width, first.height);
            let mut quaternion = DVec4::from(DQuat::from_mat3(&camera.world_to_camera));
            if keys.last().is_some_and(|last| last.quaternion.dot(quaternion) < 0.0) {
                quaternion = -quaternion;
            }
            let intrinsics = DVec4::new(camera.fx, camera.fy, camera.cx, camera.cy);
            keys.push(PathKey { knot: 0.0, centre: camera.centre, quaternion, intrinsics });
        }
        space(&mut keys);
        Some(Path { keys, first: first.clone() })
    }

    /// `frames` views at equal steps of the path, the first and the last pose included, named
    /// `path_0000` and so on. One frame is the first pose.
    pub fn frames(&self, frames: usize) -> Vec<Camera> {
        let end = self.keys[self.keys.len() - 1].knot;
        let steps = frames.saturating_sub(1).max(1) as f64;
        (0..frames)
            .map(|idx| {
                let at = if idx + 1 == frames && idx > 0 { end } else { end * idx as f64 / steps };
                Camera { name: format!("path_{idx:04}"), ..self.at(at) }
            })
            .collect()
    }

    /// The knots: [`Path::at`] of knot `i` is pose `i`.
    pub fn knots(&self) -> Vec<f64> {
        self.keys.iter().map(|key| key.knot).collect()
    }

    /// The view at `at`, from 0 to the last knot.
    pub fn at(&self, at: f64) -> Camera {
        let last = self.keys.len() - 2;
        let i = self.keys.partition_point(|key| key.knot <= at).saturating_sub(1).min(last);
        let (k1, k2) = (&self.keys[i], &self.keys[i + 1]);
        let centre = self.spline(i, at, |key| key.centre.extend(0.0)).truncate();
        let quaternion = self.spline(i, at, |key| key.quaternion);
        let s = (at - k1.knot) / (k2.knot - k1.knot);
        let [fx, fy, cx, cy] = k1.intrinsics.lerp(k2.intrinsics, s).to_array();
        let rotation = DQuat::from_vec4(quaternion.normalize());
        let world_to_camera = DMat3::from_quat(rotation);
        Camera {
            fx,
            fy,
            cx,
            cy,
            centre,
            world_to_camera,
            split: None,
            eye: None,
            ..self.first.clone()
        }
    }

    /// Cubic Hermite piece `i`, with the tangents of a non-uniform Catmull-Rom spline.
    fn spline(&self, i: usize, at: f64, value: impl Fn(&PathKey) -> DVec4) -> DVec4 {
        let length = self.knot_step(i);
        let s = (at - self.keys[i].knot) / length;
        let (s2, s3) = (s * s, s * s * s);
        value(&self.keys[i]) * (2.0 * s3 - 3.0 * s2 + 1.0)
            + value(&self.keys[i + 1]) * (3.0 * s2 - 2.0 * s3)
            + self.tangent(i, &value) * length * (s3 - 2.0 * s2 + s)
            + self.tangent(i + 1, &value) * length * (s3 - s2)
    }

    /// The tangent at key `k`: that of the parabola through the key and its neighbours, or at an
    /// end through the three nearest keys, or of the line through the only two.
    fn tangent(&self, k: usize, value: &impl Fn(&PathKey) -> DVec4) -> DVec4 {
        let slope =
            |a: usize| (value(&self.keys[a + 1]) - value(&self.keys[a])) / self.knot_step(a);
        let last = self.keys.len() - 1;
        if last == 1 {
            return slope(0);
        }
        // At an end the parabola is that of the next key, followed outwards.
        let middle = k.clamp(1, last - 1);
        let (left, right) = (self.knot_step(middle - 1), self.knot_step(middle));
        let bend = (slope(middle) - slope(middle - 1)) / (left + right);
        slope(middle - 1) + bend * (left + 2.0 * (self.keys[k].knot - self.keys[middle].knot))
    }

    fn knot_step(&self, i: usize) -> f64 {
        self.keys[i + 1].knot - self.keys[i].knot
    }
}

/// Sets the knots. Distances count in units of the mean distance between neighbours, turns in
/// units of a quarter turn, so that the scale of the world does not matter.
fn space(keys: &mut [PathKey]) {
    let moves: Vec<f64> = keys.windows(2).map(|k| k[0].centre.distance(k[1].centre)).collect();
    let mean = moves.iter().sum::<f64>() / moves.len() as f64;
    let unit = if mean > 0.0 { mean } else { 1.0 };
    let mut knot = 0.0;
    for idx in 1..keys.len() {
        let cosine = keys[idx - 1].quaternion.dot(keys[idx].quaternion).abs().min(1.0);
        let turn = 2.0 * cosine.acos() / std::f64::consts::FRAC_PI_2;
        let apart = (moves[idx - 1] / unit).hypot(turn);
        // Equal poses still take a little time, so that no piece has length zero.
        knot += apart.max(1e-4).sqrt();
        keys[idx].knot = knot;
    }
}
