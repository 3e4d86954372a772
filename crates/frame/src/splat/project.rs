//! From Gaussians to splats: cull, EWA projection, view-dependent colour (`powergs.md` §1.1).
//!
//! Sixteen Gaussians at a time; the instruction set is chosen at run time.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16, mask32x16};
use fearless_simd_macros::simd;

use super::simd::{exp, transpose};
use rayon::prelude::*;

use super::{NEAR, Splat, TILE_MAX, TileGrid, touch};
use crate::scene::{Camera, Gaussians};

/// Lanes of a block.
pub const LANES: usize = 16;
/// The low-pass filter on both diagonal entries of the 2D covariance, pixels².
const LOW_PASS: f32 = 0.3;

/// A camera in the form that the projection uses.
#[derive(Debug, Clone, Copy)]
pub struct View {
    pub(super) rotation: [[f32; 3]; 3],
    pub(super) translation: [f32; 3],
    pub(super) centre: [f32; 3],
    pub(super) focal: [f32; 2],
    /// Principal point where pixel centres are at integer coordinates.
    principal: [f32; 2],
    /// Limits of x/z and y/z inside the Jacobian: `[x_min, x_max, y_min, y_max]`.
    pub(super) limits: [f32; 4],
    /// The grid of the largest tiles: what a trace keeps.
    grid: TileGrid,
    /// Colours are at least this: black, or nothing.
    floor: f32,
}

impl View {
    /// The view of `camera`. The limits are 0.3 fields of view beyond each image edge, which for a
    /// centred principal point is the published ±1.3 tan(FoV/2).
    pub fn new(camera: &Camera) -> View {
        let m = camera.world_to_camera;
        let t = -(m * camera.centre);
        let (w, h) = (f64::from(camera.width), f64::from(camera.height));
        let margin = [0.15 * w / camera.fx, 0.15 * h / camera.fy];
        let row = |i: usize| m.row(i).to_array().map(|v| v as f32);
        View {
            rotation: [row(0), row(1), row(2)],
            translation: t.to_array().map(|v| v as f32),
            centre: camera.centre.to_array().map(|v| v as f32),
            focal: [camera.fx as f32, camera.fy as f32],
            principal: [(camera.cx - 0.5) as f32, (camera.cy - 0.5) as f32],
            limits: [
                (-camera.cx / camera.fx - margin[0]) as f32,
                ((w - camera.cx) / camera.fx + margin[0]) as f32,
                (-camera.cy / camera.fy - margin[1]) as f32,
                ((h - camera.cy) / camera.fy + margin[1]) as f32,
            ],
            grid: TileGrid::new(camera.width, camera.height, TILE_MAX),
            floor: 0.0,
        }
    }

    /// The view of `camera`, with colours that may be below black: those of another level are these
    /// and a difference.
    pub fn unclamped(camera: &Camera) -> View {
        View { floor: f32::NEG_INFINITY, ..View::new(camera) }
    }
}

/// One bit per Gaussian, least significant first: its centre is in front of the near plane, and no
/// further outside of the picture than 0.15 of its width or height. That is the test of the frustum
/// that 3DGS's published rasteriser has and does not use.
pub fn inside_frustum(scene: &Gaussians, camera: &Camera) -> Vec<u8> {
    let view = View::new(camera);
    let [left, right, top, bottom] = view.limits;
    let is_inside = |mean: &[f32; 3]| {
        let along = |axis: usize| {
            let r = view.rotation[axis];
            r[0] * mean[0] + r[1] * mean[1] + r[2] * mean[2] + view.translation[axis]
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        z > NEAR && x >= left * z && x <= right * z && y >= top * z && y <= bottom * z
    };
    let byte = |means: &[[f32; 3]]| {
        (0..).zip(means).map(|(bit, mean)| u8::from(is_inside(mean)) << bit).sum()
    };
    scene.means.par_chunks(8).map(byte).collect()
}

/// Opacities of raw ones, with the bits of [`project_block`].
#[simd]
pub fn opacities<S: Simd>(simd: S, logits: [f32; LANES]) -> [f32; LANES] {
    let one = f32x16::splat(simd, 1.0);
    (one / (one + exp(simd, -f32x16::simd_from(simd, logits)))).into()
}

/// A visible splat and its colour.
#[derive(Debug, Clone, Copy)]
pub struct Visible {
    /// The projected Gaussian.
    pub splat: Splat,
    /// Colour seen from the camera, sRGB, not clamped from above.
    pub colour: [f32; 3],
}

/// Projects Gaussians `first..end` (at most [`LANES`]); appends the visible ones in index order,
/// still black, and returns one bit per Gaussian that passed the cull.
#[simd]
pub fn project_block<S: Simd>(
    simd: S,
    scene: &Gaussians,
    view: &View,
    first: usize,
    end: usize,
    out: &mut Vec<Visible>,
) -> u16 {
    let range = first..end;
    let means = &scene.means[range.clone()];
    let world = [
        lanes_of(simd, means, |v| v[0]),
        lanes_of(simd, means, |v| v[1]),
        lanes_of(simd, means, |v| v[2]),
    ];
    let camera = to_camera(simd, view, &world);
    let valid = ((1u32 << (end - first)) - 1) as u16;
    let survivors = camera[2].simd_gt(f32x16::splat(simd, NEAR)).to_bitmask() as u16 & valid;
    if survivors == 0 {
        return 0;
    }
    let (scales, rotations) = (&scene.log_scales[range.clone()], &scene.rotations[range.clone()]);
    let scale = [
        exp(simd, lanes_of(simd, scales, |v| v[0])),
        exp(simd, lanes_of(simd, scales, |v| v[1])),
        exp(simd, lanes_of(simd, scales, |v| v[2])),
    ];
    let quaternion = [
        lanes_of(simd, rotations, |v| v[0]),
        lanes_of(simd, rotations, |v| v[1]),
        lanes_of(simd, rotations, |v| v[2]),
        lanes_of(simd, rotations, |v| v[3]),
    ];
    let logit = lanes_of(simd, &scene.logit_opacities[range], |v| *v);
    let one = f32x16::splat(simd, 1.0);
    let mut opacity = one / (one + exp(simd, -logit));
    let mean = project_mean(simd, view, &camera);
    let footprint = Footprint::new(simd, view, &camera, &scale, &quaternion);
    let cov = footprint.covariance();
    if scene.antialiased {
        opacity *= footprint.compensation(simd);
    }
    let seen = in_reach(simd, &view.grid, &mean, &cov).to_bitmask() as u16 & survivors;
    let lanes = Lanes {
        depth: camera[2].into(),
        mean: [mean[0].into(), mean[1].into()],
        cov: [cov[0].into(), cov[1].into(), cov[2].into()],
        opacity: opacity.into(),
    };
    let mut visible = seen;
    while visible != 0 {
        let lane = visible.trailing_zeros() as usize;
        visible &= visible - 1;
        out.push(Visible { splat: lanes.splat(lane, (first + lane) as u32), colour: [0.0; 3] });
    }
    survivors
}

/// What the opacities of up to [`LANES`] Gaussians of an anti-aliased model are multiplied by in
/// `view`, with the bits of [`project_block`].
#[simd]
pub fn compensations<S: Simd>(
    simd: S,
    scene: &Gaussians,
    view: &View,
    indices: &[u32],
) -> [f32; LANES] {
    let mean = |axis: usize| lanes_of(simd, indices, |i| scene.means[*i as usize][axis]);
    let scale = |axis: usize| lanes_of(simd, indices, |i| scene.log_scales[*i as usize][axis]);
    let turn = |part: usize| lanes_of(simd, indices, |i| scene.rotations[*i as usize][part]);
    let camera = to_camera(simd, view, &[mean(0), mean(1), mean(2)]);
    let scales = [exp(simd, scale(0)), exp(simd, scale(1)), exp(simd, scale(2))];
    let turns = [turn(0), turn(1), turn(2), turn(3)];
    Footprint::new(simd, view, &camera, &scales, &turns).compensation(simd).into()
}

/// Colours of up to [`LANES`] visible splats.
#[simd]
pub fn colour_block<S: Simd>(simd: S, scene: &Gaussians, view: &View, visible: &mut [Visible]) {
    let mean = |v: &Visible| scene.means[v.splat.index as usize];
    let world = [
        lanes_of(simd, visible, |v| mean(v)[0]),
        lanes_of(simd, visible, |v| mean(v)[1]),
        lanes_of(simd, visible, |v| mean(v)[2]),
    ];
    let basis = basis_by_gaussian(simd, scene.sh_degree, &direction(simd, view.centre, &world));
    touch(visible.iter().map(|v| scene.sh_of(v.splat.index as usize)));
    for (item, basis) in visible.iter_mut().zip(&basis) {
        let sh = scene.sh_of(item.splat.index as usize);
        item.colour = colour(sh, basis, view.floor);
    }
}

/// One bit for each of up to [`LANES`] Gaussians: whether `view` may see it. None is missed that
/// [`project_block`] finds; centres and scales are enough to tell.
#[simd]
pub fn may_see<S: Simd>(simd: S, view: &View, means: &[[f32; 3]], log_scales: &[[f32; 3]]) -> u16 {
    let world = [
        lanes_of(simd, means, |v| v[0]),
        lanes_of(simd, means, |v| v[1]),
        lanes_of(simd, means, |v| v[2]),
    ];
    let camera = to_camera(simd, view, &world);
    let largest = exp(simd, lanes_of(simd, log_scales, |v| v[0].max(v[1]).max(v[2])));
    // The trace of the covariance of a ball of that size bounds its larger root.
    let mut squares = f32x16::splat(simd, 0.0);
    let iz = f32x16::splat(simd, 1.0) / camera[2];
    for (axis, position) in camera.iter().take(2).enumerate() {
        let low = f32x16::splat(simd, view.limits[2 * axis]);
        let high = f32x16::splat(simd, view.limits[2 * axis + 1]);
        let slope = (*position * iz).max(low).min(high);
        let focal = iz * view.focal[axis];
        squares = (focal * focal).mul_add(slope.mul_add(slope, f32x16::splat(simd, 1.0)), squares);
    }
    let reach = ((squares * largest * largest + 1.0).sqrt() * 3.03) + 1.0;
    let mean = project_mean(simd, view, &camera);
    let mut seen = camera[2].simd_gt(f32x16::splat(simd, NEAR));
    for (m, n) in mean.iter().zip([view.grid.nx, view.grid.ny]) {
        let end = f32x16::splat(simd, (n * view.grid.tile) as f32);
        let zero = f32x16::splat(simd, 0.0);
        seen = seen & (*m + reach).simd_ge(zero) & (*m - reach).simd_lt(end);
    }
    seen.to_bitmask() as u16 & ((1u32 << means.len()) - 1) as u16
}

/// One component of up to 16 records; missing lanes are zero.
#[inline(always)]
pub(super) fn lanes_of<S: Simd, T>(
    simd: S,
    records: &[T],
    component: impl Fn(&T) -> f32,
) -> f32x16<S> {
    let mut lanes = [0.0f32; LANES];
    for (lane, record) in lanes.iter_mut().zip(records) {
        *lane = component(record);
    }
    f32x16::simd_from(simd, lanes)
}

struct Lanes {
    depth: [f32; LANES],
    mean: [[f32; LANES]; 2],
    cov: [[f32; LANES]; 3],
    opacity: [f32; LANES],
}

impl Lanes {
    #[inline(always)]
    fn splat(&self, lane: usize, index: u32) -> Splat {
        Splat {
            index,
            depth: self.depth[lane],
            mean: [self.mean[0][lane], self.mean[1][lane]],
            cov: [self.cov[0][lane], self.cov[1][lane], self.cov[2][lane]],
            opacity: self.opacity[lane],
        }
    }
}

/// Lanes with a regular, finite covariance whose bounding square touches the tiles of `grid`: those
/// for which [`Splat::tile_rect`] is not empty.
#[inline(always)]
fn in_reach<S: Simd>(
    simd: S,
    grid: &TileGrid,
    mean: &[f32x16<S>; 2],
    cov: &[f32x16<S>; 3],
) -> mask32x16<S> {
    let [a, b, d] = *cov;
    let det = a * d - b * b;
    let mid = (a + d) * 0.5;
    let spread = (mid * mid - det).max(f32x16::splat(simd, 0.1)).sqrt();
    let radius = ((mid + spread).sqrt() * 3.0).ceil();
    let zero = f32x16::splat(simd, 0.0);
    let mut seen = det.simd_ne(zero) & det.abs().simd_lt(f32x16::splat(simd, f32::INFINITY));
    for (m, n) in mean.iter().zip([grid.nx, grid.ny]) {
        let end = f32x16::splat(simd, (n * grid.tile) as f32);
        let one = f32x16::splat(simd, 1.0);
        seen = seen & (*m + radius).simd_ge(one) & (*m - radius).simd_lt(end);
    }
    seen
}

#[inline(always)]
pub(super) fn to_camera<S: Simd>(simd: S, view: &View, world: &[f32x16<S>; 3]) -> [f32x16<S>; 3] {
    let mut out = *world;
    for (k, [a, b, c]) in view.rotation.into_iter().enumerate() {
        let t = f32x16::splat(simd, view.translation[k]);
        out[k] = world[2].mul_add(c, world[1].mul_add(b, world[0].mul_add(a, t)));
    }
    out
}

#[inline(always)]
fn project_mean<S: Simd>(simd: S, view: &View, camera: &[f32x16<S>; 3]) -> [f32x16<S>; 2] {
    let w = f32x16::splat(simd, 1.0) / (camera[2] + 1e-7);
    let principal = view.principal.map(|p| f32x16::splat(simd, p));
    [
        (camera[0] * w).mul_add(view.focal[0], principal[0]),
        (camera[1] * w).mul_add(view.focal[1], principal[1]),
    ]
}

/// The factors of the 2D covariance: Σ2D = A Aᵀ plus the low-pass, with A = J W R S.
pub(super) struct Footprint<S: Simd> {
    /// 1/z.
    pub(super) inverse_z: f32x16<S>,
    /// x/z and y/z, clamped.
    pub(super) slopes: [f32x16<S>; 2],
    /// R.
    pub(super) rotation: [[f32x16<S>; 3]; 3],
    /// J W: J = [[fx/z, 0, −fx x/z²], [0, fy/z, −fy y/z²]], with x/z clamped.
    pub(super) jw: [[f32x16<S>; 3]; 2],
    /// A.
    pub(super) axes: [[f32x16<S>; 3]; 2],
}

impl<S: Simd> Footprint<S> {
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        view: &View,
        camera: &[f32x16<S>; 3],
        scale: &[f32x16<S>; 3],
        quaternion: &[f32x16<S>; 4],
    ) -> Self {
        let iz = f32x16::splat(simd, 1.0) / camera[2];
        let r = rotation(simd, quaternion);
        let (mut slopes, mut jws) = ([iz; 2], [[iz; 3]; 2]);
        let mut axes = [[iz; 3]; 2];
        for axis in 0..2 {
            let low = f32x16::splat(simd, view.limits[2 * axis]);
            let high = f32x16::splat(simd, view.limits[2 * axis + 1]);
            let slope = (camera[axis] * iz).max(low).min(high);
            let focal = iz * view.focal[axis];
            let mut jw = [iz; 3];
            for (k, value) in jw.iter_mut().enumerate() {
                let own = f32x16::splat(simd, view.rotation[axis][k]);
                *value = focal * (-slope).mul_add(view.rotation[2][k], own);
            }
            for k in 0..3 {
                let dot = jw[2].mul_add(r[2][k], jw[1].mul_add(r[1][k], jw[0] * r[0][k]));
                axes[axis][k] = dot * scale[k];
            }
            (slopes[axis], jws[axis]) = (slope, jw);
        }
        Footprint { inverse_z: iz, slopes, rotation: r, jw: jws, axes }
    }

    /// Σ2D: `[a, b, d]` of `[[a, b], [b, d]]`, pixels².
    #[inline(always)]
    pub(super) fn covariance(&self) -> [f32x16<S>; 3] {
        let [u, v] = self.axes;
        [dot3(&u, &u) + LOW_PASS, dot3(&u, &v), dot3(&v, &v) + LOW_PASS]
    }

    /// The vector product of the rows of A. Its square is the determinant of A Aᵀ, without the
    /// cancellation of thin splats, and so never negative.
    #[inline(always)]
    pub(super) fn normal(&self) -> [f32x16<S>; 3] {
        let [u, v] = &self.axes;
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    }

    /// √(det A Aᵀ / det Σ2D): how much of a splat's opacity is left when the low-pass spreads it
    /// (Mip-Splatting). 0 for a splat without area.
    #[inline(always)]
    pub(super) fn compensation(&self, simd: S) -> f32x16<S> {
        let [a, b, d] = self.covariance();
        let n = self.normal();
        let share = dot3(&n, &n) / (a * d - b * b);
        // Infinite splats are not seen; what is no number must not become one.
        let zero = f32x16::splat(simd, 0.0);
        let one = f32x16::splat(simd, 1.0);
        share.simd_gt(zero).select(share, zero).min(one).sqrt()
    }
}

#[inline(always)]
pub(super) fn twice<S: Simd>(a: f32x16<S>) -> f32x16<S> {
    a + a
}

#[inline(always)]
pub(super) fn dot3<S: Simd>(u: &[f32x16<S>; 3], v: &[f32x16<S>; 3]) -> f32x16<S> {
    u[2].mul_add(v[2], u[1].mul_add(v[1], u[0] * v[0]))
}

/// Rotation matrices of un-normalised quaternions (w, x, y, z).
#[inline(always)]
fn rotation<S: Simd>(simd: S, q: &[f32x16<S>; 4]) -> [[f32x16<S>; 3]; 3] {
    let one = f32x16::splat(simd, 1.0);
    let norm2 = q[3].mul_add(q[3], q[2].mul_add(q[2], q[1].mul_add(q[1], q[0] * q[0])));
    let inverse = one / norm2.sqrt();
    let [w, x, y, z] = [q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse];
    [
        [one - twice(y * y + z * z), twice(x * y - w * z), twice(x * z + w * y)],
        [twice(x * y + w * z), one - twice(x * x + z * z), twice(y * z - w * x)],
        [twice(x * z - w * y), twice(y * z + w * x), one - twice(x * x + y * y)],
    ]
}

/// The colours of all Gaussians seen from `eye` (world units): max(0, SH + ½), sRGB.
pub fn colours(scene: &Gaussians, eye: [f32; 3], level: Level) -> Vec<[f32; 3]> {
    let mut out = Vec::with_capacity(scene.len());
    for first in (0..scene.len()).step_by(LANES) {
        let end = (first + LANES).min(scene.len());
        let basis = dispatch!(level, simd => {
            let means = &scene.means[first..end];
            let world = [
                lanes_of(simd, means, |v| v[0]),
                lanes_of(simd, means, |v| v[1]),
                lanes_of(simd, means, |v| v[2]),
            ];
            basis_by_gaussian(simd, scene.sh_degree, &direction(simd, eye, &world))
        });
        out.extend((first..end).zip(&basis).map(|(i, basis)| colour(scene.sh_of(i), basis, 0.0)));
    }
    out
}

#[inline(always)]
pub(super) fn direction<S: Simd>(simd: S, eye: [f32; 3], world: &[f32x16<S>; 3]) -> [f32x16<S>; 3] {
    let d = [world[0] - eye[0], world[1] - eye[1], world[2] - eye[2]];
    let inverse = f32x16::splat(simd, 1.0) / dot3(&d, &d).sqrt();
    [d[0] * inverse, d[1] * inverse, d[2] * inverse]
}

/// The real spherical harmonics of 16 directions in the 3DGS sign convention,
/// `[coefficient]`.
#[inline(always)]
pub(super) fn sh_basis<S: Simd>(simd: S, degree: u8, d: &[f32x16<S>; 3]) -> [f32x16<S>; 16] {
    let [x, y, z] = *d;
    let mut basis = [f32x16::splat(simd, 0.0); 16];
    basis[0] = f32x16::splat(simd, SH_C0);
    if degree >= 1 {
        const C1: f32 = 0.488_602_5;
        basis[1] = y * -C1;
        basis[2] = z * C1;
        basis[3] = x * -C1;
    }
    let (xx, yy, zz) = (x * x, y * y, z * z);
    if degree >= 2 {
        basis[4] = x * y * 1.092_548_4;
        basis[5] = y * z * -1.092_548_4;
        basis[6] = (zz + zz - xx - yy) * 0.315_391_57;
        basis[7] = x * z * -1.092_548_4;
        basis[8] = (xx - yy) * 0.546_274_2;
    }
    if degree >= 3 {
        basis[9] = y * (xx * 3.0 - yy) * -0.590_043_6;
        basis[10] = x * y * z * 2.890_611_4;
        basis[11] = y * (zz * 4.0 - xx - yy) * -0.457_045_8;
        basis[12] = z * (zz * 2.0 - xx * 3.0 - yy * 3.0) * 0.373_176_34;
        basis[13] = x * (zz * 4.0 - xx - yy) * -0.457_045_8;
        basis[14] = z * (xx - yy) * 1.445_305_7;
        basis[15] = x * (xx - yy * 3.0) * -0.590_043_6;
    }
    basis
}

/// The values of the spherical harmonics in each of 16 directions.
#[inline(always)]
fn basis_by_gaussian<S: Simd>(simd: S, degree: u8, d: &[f32x16<S>; 3]) -> [[f32; 16]; LANES] {
    let mut rows = sh_basis(simd, degree, d);
    transpose(&mut rows);
    rows.map(Into::into)
}

/// The constant basis function.
pub const SH_C0: f32 = 0.282_094_8;

/// max(floor, SH + ½) per channel, floor 0 but for [`View::unclamped`]; no clamp from above.
#[inline(always)]
fn colour(sh: &[f32], basis: &[f32; 16], floor: f32) -> [f32; 3] {
    match sh.len() {
        3 => colour_of::<1>(sh, basis, floor),
        12 => colour_of::<4>(sh, basis, floor),
        27 => colour_of::<9>(sh, basis, floor),
        _ => colour_of::<16>(sh, basis, floor),
    }
}

/// [`colour`] for `N` coefficients a channel: unrolled, in registers.
#[inline(always)]
fn colour_of<const N: usize>(sh: &[f32], basis: &[f32; 16], floor: f32) -> [f32; 3] {
    let mut out = [0.0f32; 3];
    let (channels, _) = sh.as_chunks::<N>();
    for (value, sh) in out.iter_mut().zip(channels) {
        let mut partial = [0.0f32; 4];
        for k in 0..N {
            partial[k & 3] += sh[k] * basis[k];
        }
        let sum = (partial[0] + partial[1]) + (partial[2] + partial[3]);
        *value = (sum + 0.5).max(floor);
    }
    out
}
