//! The backward pass of the projection: from the gradient of a loss by a splat to the gradient by
//! the raw parameters of its Gaussian.
//!
//! With δ the offset of a pixel from the splat's centre and K the conic, ln α = ln o − ½ δᵀ K δ.
//! The gradient by the centre is K Σ s δ, by the covariance ½ K (Σ s δ δᵀ) K, by the logit
//! opacity (1 − o) Σ s. From there the chain rule runs back through Σ2D = A Aᵀ with A = J W R S.
//! The clamp of x/z and y/z inside J has its true derivative: none where it holds. The opacity of
//! an anti-aliased model has the factor √(det A Aᵀ / det Σ2D), whose derivative goes the same way.
//! Sixteen Gaussians at a time, of those that are seen.

mod harmonics;

use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use fearless_simd_macros::simd;

use super::project::{
    Footprint, LANES, SH_C0, View, direction, dot3, lanes_of, sh_basis, to_camera,
};
use super::simd::{exp, transpose};
use super::touch;
use crate::scene::Gaussians;

/// Sums over the pixels that a splat blends in, with s the gradient of the loss by ln α and
/// (δx, δy) pixel minus centre: Σ s, Σ s δx, Σ s δy, Σ s δx², Σ s δx δy, Σ s δy². Then the
/// gradient by the colour, from [`COLOUR`].
pub type PixelSums = [f32; 9];

/// Where the gradient by the colour begins in [`PixelSums`].
pub const COLOUR: usize = 6;

/// The rank of a Gaussian that is not seen.
pub const HIDDEN: u32 = u32::MAX;

/// Parameters of consecutive Gaussians: one entry per Gaussian and list, as in [`Gaussians`].
#[derive(Debug, Clone, Copy)]
pub struct Stretch<'a> {
    /// Centres.
    pub means: &'a [[f32; 3]],
    /// Logarithms of the standard deviations.
    pub log_scales: &'a [[f32; 3]],
    /// Raw quaternions (w, x, y, z).
    pub rotations: &'a [[f32; 4]],
    /// Logit opacities.
    pub logit_opacities: &'a [f32],
    /// SH coefficients, `[channel][coefficient]` per Gaussian.
    pub sh: &'a [f32],
    /// Degree of the spherical harmonics, 0 to 3.
    pub sh_degree: u8,
    /// Whether the model is anti-aliased.
    pub antialiased: bool,
}

impl<'a> Stretch<'a> {
    /// All Gaussians of a scene.
    pub fn all(scene: &'a Gaussians) -> Stretch<'a> {
        Stretch {
            means: &scene.means,
            log_scales: &scene.log_scales,
            rotations: &scene.rotations,
            logit_opacities: &scene.logit_opacities,
            sh: &scene.sh,
            sh_degree: scene.sh_degree,
            antialiased: scene.antialiased,
        }
    }

    /// SH coefficients of a channel.
    fn sh_coefficients(&self) -> usize {
        (usize::from(self.sh_degree) + 1).pow(2)
    }

    fn sh_of(&self, place: usize) -> &'a [f32] {
        let n = 3 * self.sh_coefficients();
        &self.sh[place * n..(place + 1) * n]
    }
}

/// Floats of a Gaussian that are no SH coefficients.
pub const SHAPE: usize = 11;
/// SH coefficients of a Gaussian at degree 3, all channels.
pub const SH_MOST: usize = 48;

/// Gradients of up to [`LANES`] Gaussians, one entry each.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct GradientBlock {
    /// By centre (3), logarithms of the standard deviations (3), raw quaternion (4) and logit
    /// opacity (1), then zeros.
    pub shape: [[f32; LANES]; LANES],
    /// By the SH coefficients, `[channel][coefficient]`, as many as the model has.
    pub sh: [[f32; SH_MOST]; LANES],
}

impl Default for GradientBlock {
    fn default() -> Self {
        GradientBlock { shape: [[0.0; LANES]; LANES], sh: [[0.0; SH_MOST]; LANES] }
    }
}

impl GradientBlock {
    /// The gradients of the Gaussians at the places `seen` of `part` by the constant coefficients
    /// and the opacity; the others are zero. Arguments as in [`unproject_block`].
    pub fn colour_and_opacity(
        &mut self,
        part: &Stretch<'_>,
        seen: &[u32],
        ranks: &[u32],
        sums: &[PixelSums],
    ) {
        let n = part.sh_coefficients();
        let rows = self.shape.iter_mut().zip(&mut self.sh);
        for ((shape, sh), &place) in rows.zip(seen) {
            let sums = &sums[ranks[place as usize] as usize];
            let transparency = 1.0 / (1.0 + part.logit_opacities[place as usize].exp());
            *shape = [0.0; LANES];
            shape[SHAPE - 1] = sums[0] * transparency;
            sh[..3 * n].fill(0.0);
            for (channel, sum) in sums[COLOUR..].iter().enumerate() {
                sh[channel * n] = SH_C0 * sum;
            }
        }
    }
}

/// Writes to `out` the gradients of the Gaussians at the places `seen` of `part`, at most
/// [`LANES`]. `ranks` holds the depth rank of every Gaussian of `part`, `sums` has an entry per
/// rank.
#[simd]
pub fn unproject_block<S: Simd>(
    simd: S,
    view: &View,
    part: &Stretch<'_>,
    seen: &[u32],
    ranks: &[u32],
    sums: &[PixelSums],
    out: &mut GradientBlock,
) {
    // All that is scattered at once.
    touch(seen.iter().map(|place| &sums[ranks[*place as usize] as usize][..]));
    touch(seen.iter().map(|place| part.sh_of(*place as usize)));
    let mut gathered = [[0.0f32; LANES]; 9];
    for (lane, place) in seen.iter().enumerate() {
        for (k, sum) in sums[ranks[*place as usize] as usize].iter().enumerate() {
            gathered[k][lane] = *sum;
        }
    }
    let lanes = GradientLanes::load(simd, part, seen);
    let camera = to_camera(simd, view, &lanes.world);
    let footprint = Footprint::new(simd, view, &camera, &lanes.scale, &lanes.quaternion);
    let zero = f32x16::splat(simd, 0.0);
    let mut sum = [zero; 6];
    for k in 0..6 {
        sum[k] = f32x16::simd_from(simd, gathered[k]);
    }
    let (by_mean2, by_cov) = by_splat(&footprint.covariance(), &sum);
    let mut by_axes = by_axes(&footprint, &by_cov);
    if part.antialiased {
        through_compensation(simd, &footprint, sum[0], &mut by_axes);
    }
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
    let basis = sh_basis(simd, part.sh_degree, &toward);
    let by_colour = [gathered[6], gathered[7], gathered[8]];
    let by_direction =
        harmonics::backward(simd, part, seen, &toward, &basis, &by_colour, &mut out.sh);
    let by_eye = harmonics::through_direction(view, &lanes.world, &toward, &by_direction);
    let by_quaternion = by_quaternion(simd, &lanes.quaternion, &shape.rotation);
    let mut rows = [zero; LANES];
    for k in 0..3 {
        rows[k] = by_world[k] + by_eye[k];
        rows[3 + k] = shape.log_scale[k];
    }
    rows[6..10].copy_from_slice(&by_quaternion);
    rows[10] = sum[0] * lanes.transparency(simd);
    transpose(&mut rows);
    for (out, row) in out.shape.iter_mut().zip(rows) {
        row.store_slice(out);
    }
}

/// The parameters of a block.
struct GradientLanes<S: Simd> {
    world: [f32x16<S>; 3],
    scale: [f32x16<S>; 3],
    quaternion: [f32x16<S>; 4],
    logit: f32x16<S>,
}

impl<S: Simd> GradientLanes<S> {
    #[inline(always)]
    fn load(simd: S, part: &Stretch<'_>, seen: &[u32]) -> Self {
        let (means, scales) = (part.means, part.log_scales);
        GradientLanes {
            world: [
                lanes_of(simd, seen, |i| means[*i as usize][0]),
                lanes_of(simd, seen, |i| means[*i as usize][1]),
                lanes_of(simd, seen, |i| means[*i as usize][2]),
            ],
            scale: [
                exp(simd, lanes_of(simd, seen, |i| scales[*i as usize][0])),
                exp(simd, lanes_of(simd, seen, |i| scales[*i as usize][1])),
                exp(simd, lanes_of(simd, seen, |i| scales[*i as usize][2])),
            ],
            quaternion: [
                lanes_of(simd, seen, |i| part.rotations[*i as usize][0]),
                lanes_of(simd, seen, |i| part.rotations[*i as usize][1]),
                lanes_of(simd, seen, |i| part.rotations[*i as usize][2]),
                lanes_of(simd, seen, |i| part.rotations[*i as usize][3]),
            ],
            logit: lanes_of(simd, seen, |i| part.logit_opacities[*i as usize]),
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

/// Adds the gradient by A through ln √(det A Aᵀ / det Σ2D), whose gradient by itself is `by_log`:
/// that of ln det M by M is its inverse.
#[inline(always)]
fn through_compensation<S: Simd>(
    simd: S,
    footprint: &Footprint<S>,
    by_log: f32x16<S>,
    by_axes: &mut [[f32x16<S>; 3]; 2],
) {
    let [u, v] = footprint.axes;
    let [a, b, d] = footprint.covariance();
    let spread = by_log / (a * d - b * b);
    let n = footprint.normal();
    let square = dot3(&n, &n);
    // A splat without area has opacity 0, and blends nowhere.
    let zero = f32x16::splat(simd, 0.0);
    let own = square.simd_gt(zero).select(by_log / square, zero);
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (v_by_n, n_by_u) = (v[i] * n[j] - v[j] * n[i], n[i] * u[j] - n[j] * u[i]);
        by_axes[0][k] += own * v_by_n - spread * (d * u[k] - b * v[k]);
        by_axes[1][k] += own * n_by_u - spread * (a * v[k] - b * u[k]);
    }
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
    lanes: &GradientLanes<S>,
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
