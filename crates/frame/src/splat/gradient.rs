//! The backward pass of the projection: from the gradient of a loss by a splat to the gradient by
//! the raw parameters of its Gaussian.
//!
//! With δ the offset of a pixel from the splat's centre and K the conic, ln α = ln o − ½ δᵀ K δ.
//! The gradient by the centre is K Σ s δ, by the covariance ½ K (Σ s δ δᵀ) K, by the logit
//! opacity (1 − o) Σ s. From there the chain rule runs back through Σ2D = A Aᵀ with A = J W R S.
//! The clamp of x/z and y/z inside J has its true derivative: none where it holds. Sixteen
//! Gaussians at a time; a Gaussian that is not seen gets zero.

mod harmonics;

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use super::project::{
    Footprint, LANES, SH_C0, View, direction, dot3, lanes_of, sh_basis, to_camera,
};
use super::simd::exp;
use crate::scene::Gaussians;

/// Sums over the pixels that a splat blends in, with s the gradient of the loss by ln α and
/// (δx, δy) pixel minus centre: Σ s, Σ s δx, Σ s δy, Σ s δx², Σ s δx δy, Σ s δy². Then the
/// gradient by the colour, from [`COLOUR`].
pub type PixelSums = [f32; 9];

/// Where the gradient by the colour begins in [`PixelSums`].
pub const COLOUR: usize = 6;

/// The rank of a Gaussian that is not seen.
pub const HIDDEN: u32 = u32::MAX;

/// Gradients of consecutive Gaussians, to be written: one entry per Gaussian and list.
#[derive(Debug)]
pub struct GradientPart<'a> {
    /// By the centre.
    pub means: &'a mut [[f32; 3]],
    /// By the logarithm of the standard deviations.
    pub log_scales: &'a mut [[f32; 3]],
    /// By the raw quaternion (w, x, y, z).
    pub rotations: &'a mut [[f32; 4]],
    /// By the logit opacity.
    pub logit_opacities: &'a mut [f32],
    /// By the SH coefficients, `[channel][coefficient]` per Gaussian.
    pub sh: &'a mut [f32],
}

impl GradientPart<'_> {
    /// Entries `first..end`; a Gaussian has `n` SH coefficients in all channels together.
    pub fn range(&mut self, first: usize, end: usize, n: usize) -> GradientPart<'_> {
        GradientPart {
            means: &mut self.means[first..end],
            log_scales: &mut self.log_scales[first..end],
            rotations: &mut self.rotations[first..end],
            logit_opacities: &mut self.logit_opacities[first..end],
            sh: &mut self.sh[first * n..end * n],
        }
    }

    fn clear(&mut self) {
        self.means.fill([0.0; 3]);
        self.log_scales.fill([0.0; 3]);
        self.rotations.fill([0.0; 4]);
        self.logit_opacities.fill(0.0);
        self.sh.fill(0.0);
    }

    /// The gradients of Gaussian `first` and those that follow, by the constant coefficients and
    /// the opacity; the others get zero. Arguments as in [`unproject_block`].
    pub fn colour_and_opacity(
        &mut self,
        scene: &Gaussians,
        first: usize,
        ranks: &[u32],
        sums: &[PixelSums],
    ) {
        self.clear();
        let n = scene.sh_coefficients();
        for lane in 0..self.means.len() {
            let rank = ranks[first + lane];
            if rank == HIDDEN {
                continue;
            }
            let sums = &sums[rank as usize];
            let transparency = 1.0 / (1.0 + scene.logit_opacities[first + lane].exp());
            self.logit_opacities[lane] = sums[0] * transparency;
            for (channel, sum) in sums[COLOUR..].iter().enumerate() {
                self.sh[(3 * lane + channel) * n] = SH_C0 * sum;
            }
        }
    }
}

/// Writes to `out` the gradients of Gaussian `first` and those that follow (at most [`LANES`]).
/// `ranks` holds the depth rank of every Gaussian of the scene or [`HIDDEN`], `sums` has an entry
/// per rank.
#[simd]
pub fn unproject_block<S: Simd>(
    simd: S,
    scene: &Gaussians,
    view: &View,
    first: usize,
    ranks: &[u32],
    sums: &[PixelSums],
    out: &mut GradientPart<'_>,
) {
    out.clear();
    let range = first..first + out.means.len();
    let mut seen = 0u32;
    let mut gathered = [[0.0f32; LANES]; 9];
    for (lane, rank) in ranks[range.clone()].iter().enumerate() {
        if *rank != HIDDEN {
            seen |= 1 << lane;
            for (k, sum) in sums[*rank as usize].iter().enumerate() {
                gathered[k][lane] = *sum;
            }
        }
    }
    if seen == 0 {
        return;
    }
    let lanes = Lanes::load(simd, scene, range);
    let camera = to_camera(simd, view, &lanes.world);
    let footprint = Footprint::new(simd, view, &camera, &lanes.scale, &lanes.quaternion);
    let zero = f32x16::splat(simd, 0.0);
    let mut sum = [zero; 6];
    for k in 0..6 {
        sum[k] = f32x16::simd_from(simd, gathered[k]);
    }
    let (by_mean2, by_cov) = by_splat(&footprint.covariance(), &sum);
    let by_axes = by_axes(&footprint, &by_cov);
    let shape = by_shape(simd, &footprint, &lanes, &by_axes);
    let mut by_camera = shape.slopes(simd, view, &footprint, &camera);
    through_mean(simd, view, &camera, &by_mean2, &mut by_camera);
    let mut by_world = [zero; 3];
    for (k, by_world) in by_world.iter_mut().enumerate() {
        for (by, row) in by_camera.into_iter().zip(view.rotation) {
            *by_world = by.mul_add(row[k], *by_world);
        }
    }
    let toward = direction(simd, view.centre, &lanes.world);
    let basis = sh_basis(simd, scene.sh_degree, &toward);
    let by_colour = [gathered[6], gathered[7], gathered[8]];
    let by_direction =
        harmonics::backward(simd, scene, first, seen, &toward, &basis, &by_colour, out.sh);
    let by_eye = harmonics::through_direction(view, &lanes.world, &toward, &by_direction);
    let by_quaternion = by_quaternion(simd, &lanes.quaternion, &shape.rotation);
    let transparency = lanes.transparency(simd);
    let mut written = [[0.0f32; LANES]; 11];
    for k in 0..3 {
        written[k] = (by_world[k] + by_eye[k]).into();
        written[3 + k] = shape.log_scale[k].into();
    }
    for k in 0..4 {
        written[6 + k] = by_quaternion[k].into();
    }
    written[10] = (sum[0] * transparency).into();
    store(&written, seen, out);
}

fn store(written: &[[f32; LANES]; 11], mut seen: u32, out: &mut GradientPart<'_>) {
    while seen != 0 {
        let lane = seen.trailing_zeros() as usize;
        seen &= seen - 1;
        for k in 0..3 {
            out.means[lane][k] = written[k][lane];
            out.log_scales[lane][k] = written[3 + k][lane];
        }
        for k in 0..4 {
            out.rotations[lane][k] = written[6 + k][lane];
        }
        out.logit_opacities[lane] = written[10][lane];
    }
}

/// The parameters of a block.
struct Lanes<S: Simd> {
    world: [f32x16<S>; 3],
    scale: [f32x16<S>; 3],
    quaternion: [f32x16<S>; 4],
    logit: f32x16<S>,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn load(simd: S, scene: &Gaussians, range: std::ops::Range<usize>) -> Self {
        let (means, scales) = (&scene.means[range.clone()], &scene.log_scales[range.clone()]);
        let rotations = &scene.rotations[range.clone()];
        Lanes {
            world: [
                lanes_of(simd, means, |v| v[0]),
                lanes_of(simd, means, |v| v[1]),
                lanes_of(simd, means, |v| v[2]),
            ],
            scale: [
                exp(simd, lanes_of(simd, scales, |v| v[0])),
                exp(simd, lanes_of(simd, scales, |v| v[1])),
                exp(simd, lanes_of(simd, scales, |v| v[2])),
            ],
            quaternion: [
                lanes_of(simd, rotations, |v| v[0]),
                lanes_of(simd, rotations, |v| v[1]),
                lanes_of(simd, rotations, |v| v[2]),
                lanes_of(simd, rotations, |v| v[3]),
            ],
            logit: lanes_of(simd, &scene.logit_opacities[range], |v| *v),
        }
    }

    /// One minus the opacity, without cancellation.
    #[inline(always)]
    fn transparency(&self, simd: S) -> f32x16<S> {
        let one = f32x16::splat(simd, 1.0);
        one / (one + exp(simd, self.logit))
    }
}

/// The gradients by centre and covariance (the full symmetric matrix `[[a, b], [b, d]]`, so that b
/// holds half of what both off-diagonals want), without the factor ½ of the latter.
#[inline(always)]
fn by_splat<S: Simd>(
    cov: &[f32x16<S>; 3],
    sum: &[f32x16<S>; 6],
) -> ([f32x16<S>; 2], [f32x16<S>; 3]) {
    let [a, b, d] = *cov;
    let det = a * d - b * b;
    let (k0, k1, k2) = (d / det, -b / det, a / det);
    let [_, sx, sy, sxx, sxy, syy] = *sum;
    let mean = [k0.mul_add(sx, k1 * sy), k1.mul_add(sx, k2 * sy)];
    let (p00, p01) = (k0.mul_add(sxx, k1 * sxy), k0.mul_add(sxy, k1 * syy));
    let (p10, p11) = (k1.mul_add(sxx, k2 * sxy), k1.mul_add(sxy, k2 * syy));
    let cov = [p00.mul_add(k0, p01 * k1), p00.mul_add(k1, p01 * k2), p10.mul_add(k1, p11 * k2)];
    (mean, cov)
}

/// The gradient by A: twice the gradient by A Aᵀ, times A.
#[inline(always)]
fn by_axes<S: Simd>(footprint: &Footprint<S>, by_cov: &[f32x16<S>; 3]) -> [[f32x16<S>; 3]; 2] {
    let [h00, h01, h11] = *by_cov;
    let [u, v] = footprint.axes;
    let mut out = [u, v];
    for k in 0..3 {
        out[0][k] = h00.mul_add(u[k], h01 * v[k]);
        out[1][k] = h01.mul_add(u[k], h11 * v[k]);
    }
    out
}

/// Gradients by the factors of A.
struct ByShape<S: Simd> {
    log_scale: [f32x16<S>; 3],
    rotation: [[f32x16<S>; 3]; 3],
    jw: [[f32x16<S>; 3]; 2],
}

#[inline(always)]
fn by_shape<S: Simd>(
    simd: S,
    footprint: &Footprint<S>,
    lanes: &Lanes<S>,
    by_axes: &[[f32x16<S>; 3]; 2],
) -> ByShape<S> {
    let zero = f32x16::splat(simd, 0.0);
    let mut out = ByShape { log_scale: [zero; 3], rotation: [[zero; 3]; 3], jw: [[zero; 3]; 2] };
    let [by_first, by_second] = by_axes;
    for (k, (&u, &v)) in by_first.iter().zip(by_second).enumerate() {
        out.log_scale[k] = u.mul_add(footprint.axes[0][k], v * footprint.axes[1][k]);
        let (u, v) = (u * lanes.scale[k], v * lanes.scale[k]);
        for j in 0..3 {
            out.rotation[j][k] = u.mul_add(footprint.jw[0][j], v * footprint.jw[1][j]);
            out.jw[0][j] = u.mul_add(footprint.rotation[j][k], out.jw[0][j]);
            out.jw[1][j] = v.mul_add(footprint.rotation[j][k], out.jw[1][j]);
        }
    }
    out
}

impl<S: Simd> ByShape<S> {
    /// The gradient by the position in camera space, through J.
    #[inline(always)]
    fn slopes(
        &self,
        simd: S,
        view: &View,
        footprint: &Footprint<S>,
        camera: &[f32x16<S>; 3],
    ) -> [f32x16<S>; 3] {
        let zero = f32x16::splat(simd, 0.0);
        let iz = footprint.inverse_z;
        let mut out = [zero; 3];
        for axis in 0..2 {
            let by_jw = &self.jw[axis];
            let mut depth_row = zero;
            for (by, own) in by_jw.iter().zip(view.rotation[2]) {
                depth_row = by.mul_add(own, depth_row);
            }
            // J W is (f/z) (row − slope · depth row).
            let by_slope = -(depth_row * iz * view.focal[axis]);
            let slope = camera[axis] * iz;
            let free = slope.simd_eq(footprint.slopes[axis]);
            let by_slope = free.select(by_slope, zero);
            out[axis] = by_slope * iz;
            let by_inverse_z = dot3(by_jw, &footprint.jw[axis]);
            out[2] -= by_inverse_z.mul_add(iz, by_slope * slope * iz);
        }
        out
    }
}

/// Adds the gradient by the position in camera space through the projected centre.
#[inline(always)]
fn through_mean<S: Simd>(
    simd: S,
    view: &View,
    camera: &[f32x16<S>; 3],
    by_mean: &[f32x16<S>; 2],
    by_camera: &mut [f32x16<S>; 3],
) {
    let w = f32x16::splat(simd, 1.0) / (camera[2] + 1e-7);
    for axis in 0..2 {
        let step = by_mean[axis] * view.focal[axis] * w;
        by_camera[axis] += step;
        by_camera[2] -= step * camera[axis] * w;
    }
}

/// The gradient by the raw quaternion, given the one by the rotation matrix.
#[inline(always)]
fn by_quaternion<S: Simd>(simd: S, q: &[f32x16<S>; 4], m: &[[f32x16<S>; 3]; 3]) -> [f32x16<S>; 4] {
    let norm2 = q[3].mul_add(q[3], q[2].mul_add(q[2], q[1].mul_add(q[1], q[0] * q[0])));
    let inverse = f32x16::splat(simd, 1.0) / norm2.sqrt();
    let [w, x, y, z] = [q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse];
    let (xy, xz, yz) = (m[0][1] + m[1][0], m[0][2] + m[2][0], m[1][2] + m[2][1]);
    let (wx, wy, wz) = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]);
    let (dx, dy, dz) = (m[1][1] + m[2][2], m[0][0] + m[2][2], m[0][0] + m[1][1]);
    // Half the gradient by the unit quaternion.
    let half = [
        x * wx + y * wy + z * wz,
        w * wx + y * xy + z * xz - (x + x) * dx,
        w * wy + x * xy + z * yz - (y + y) * dy,
        w * wz + x * xz + y * yz - (z + z) * dz,
    ];
    let radial = half[0] * w + half[1] * x + half[2] * y + half[3] * z;
    let twice = inverse + inverse;
    [
        (half[0] - radial * w) * twice,
        (half[1] - radial * x) * twice,
        (half[2] - radial * y) * twice,
        (half[3] - radial * z) * twice,
    ]
}
