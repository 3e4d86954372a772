//! From Gaussians to splats: cull, EWA projection, view-dependent colour (`powergs.md` §1.1).
//!
//! Sixteen Gaussians at a time; the instruction set is chosen at run time.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16};
use fearless_simd_macros::simd;

use super::simd::exp;
use super::{NEAR, Splat, TILE_MAX, TileGrid};
use crate::scene::{Camera, Gaussians};

/// Lanes of a block.
pub const LANES: usize = 16;
/// The low-pass filter on both diagonal entries of the 2D covariance, pixels².
const LOW_PASS: f32 = 0.3;

/// A camera in the form that the projection uses.
#[derive(Debug, Clone, Copy)]
pub struct View {
    rotation: [[f32; 3]; 3],
    translation: [f32; 3],
    centre: [f32; 3],
    focal: [f32; 2],
    /// Principal point where pixel centres are at integer coordinates.
    principal: [f32; 2],
    /// Limits of x/z and y/z inside the Jacobian: `[x_min, x_max, y_min, y_max]`.
    limits: [f32; 4],
    /// The grid of the largest tiles: what a trace keeps.
    grid: TileGrid,
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
        }
    }
}

/// A visible splat and its colour.
#[derive(Debug, Clone, Copy)]
pub struct Visible {
    /// The projected Gaussian.
    pub splat: Splat,
    /// Colour seen from the camera, sRGB, not clamped from above.
    pub colour: [f32; 3],
}

/// Projects Gaussians `first..end` (at most [`LANES`]); appends the visible ones in index order and
/// returns one bit per Gaussian that passed the cull.
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
    let world: [f32x16<S>; 3] =
        std::array::from_fn(|k| lanes_of(simd, &scene.means[range.clone()], |v| v[k]));
    let camera: [f32x16<S>; 3] = std::array::from_fn(|k| {
        let [a, b, c] = view.rotation[k];
        let t = f32x16::splat(simd, view.translation[k]);
        world[2].mul_add(c, world[1].mul_add(b, world[0].mul_add(a, t)))
    });
    let valid = ((1u32 << (end - first)) - 1) as u16;
    let survivors = camera[2].simd_gt(f32x16::splat(simd, NEAR)).to_bitmask() as u16 & valid;
    if survivors == 0 {
        return 0;
    }
    let (scales, rotations) = (&scene.log_scales[range.clone()], &scene.rotations[range.clone()]);
    let scale: [f32x16<S>; 3] =
        std::array::from_fn(|k| exp(simd, lanes_of(simd, scales, |v| v[k])));
    let quaternion: [f32x16<S>; 4] = std::array::from_fn(|k| lanes_of(simd, rotations, |v| v[k]));
    let logit = lanes_of(simd, &scene.logit_opacities[range.clone()], |v| *v);
    let one = f32x16::splat(simd, 1.0);
    let opacity = one / (one + exp(simd, -logit));
    let mean = project_mean(simd, view, &camera);
    let cov = covariance(simd, view, &camera, &scale, &quaternion);
    let lanes = Lanes {
        depth: camera[2].into(),
        mean: mean.map(Into::into),
        cov: cov.map(Into::into),
        opacity: opacity.into(),
    };
    let mut visible = 0u16;
    let start = out.len();
    for lane in 0..LANES {
        if survivors >> lane & 1 == 1 {
            if let Some(splat) = lanes.splat(lane, (first + lane) as u32, &view.grid) {
                visible |= 1 << lane;
                out.push(Visible { splat, colour: [0.0; 3] });
            }
        }
    }
    if visible != 0 {
        let basis = sh_basis(simd, scene.sh_degree, &direction(simd, view.centre, &world));
        for item in &mut out[start..] {
            let i = item.splat.index as usize;
            item.colour = colour(scene.sh_of(i), scene.sh_coefficients(), &basis, i - first);
        }
    }
    survivors
}

/// One component of up to 16 records; missing lanes are zero.
#[inline(always)]
fn lanes_of<S: Simd, T>(simd: S, records: &[T], component: impl Fn(&T) -> f32) -> f32x16<S> {
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
    /// The splat of one lane, if its bounding square may touch the image.
    fn splat(&self, lane: usize, index: u32, grid: &TileGrid) -> Option<Splat> {
        let splat = Splat {
            index,
            depth: self.depth[lane],
            mean: self.mean.map(|m| m[lane]),
            cov: self.cov.map(|c| c[lane]),
            opacity: self.opacity[lane],
        };
        let finite = splat.mean.iter().chain(&splat.cov).all(|v| v.is_finite())
            && splat.depth.is_finite()
            && splat.opacity.is_finite();
        (finite && splat.conic().is_some() && splat.tile_rect(grid).area() > 0).then_some(splat)
    }
}

#[inline(always)]
fn project_mean<S: Simd>(simd: S, view: &View, camera: &[f32x16<S>; 3]) -> [f32x16<S>; 2] {
    let w = f32x16::splat(simd, 1.0) / (camera[2] + 1e-7);
    std::array::from_fn(|k| {
        (camera[k] * w).mul_add(view.focal[k], f32x16::splat(simd, view.principal[k]))
    })
}

/// Σ2D = J W Σ3D Wᵀ Jᵀ as (J W R S)(J W R S)ᵀ, plus the low-pass.
#[inline(always)]
fn covariance<S: Simd>(
    simd: S,
    view: &View,
    camera: &[f32x16<S>; 3],
    scale: &[f32x16<S>; 3],
    quaternion: &[f32x16<S>; 4],
) -> [f32x16<S>; 3] {
    let iz = f32x16::splat(simd, 1.0) / camera[2];
    let [x_min, x_max, y_min, y_max] = view.limits.map(|l| f32x16::splat(simd, l));
    let x = (camera[0] * iz).max(x_min).min(x_max);
    let y = (camera[1] * iz).max(y_min).min(y_max);
    let w = &view.rotation;
    let (fx, fy) = (iz * view.focal[0], iz * view.focal[1]);
    // Rows of J W: J = [[fx/z, 0, −fx x/z²], [0, fy/z, −fy y/z²]] with x, y already over z.
    let jw: [[f32x16<S>; 3]; 2] = [
        std::array::from_fn(|k| fx * (-x).mul_add(w[2][k], f32x16::splat(simd, w[0][k]))),
        std::array::from_fn(|k| fy * (-y).mul_add(w[2][k], f32x16::splat(simd, w[1][k]))),
    ];
    let r = rotation(simd, quaternion);
    let a: [[f32x16<S>; 3]; 2] = std::array::from_fn(|i| {
        std::array::from_fn(|k| {
            let dot = jw[i][2].mul_add(r[2][k], jw[i][1].mul_add(r[1][k], jw[i][0] * r[0][k]));
            dot * scale[k]
        })
    });
    let dot =
        |i: usize, j: usize| a[i][2].mul_add(a[j][2], a[i][1].mul_add(a[j][1], a[i][0] * a[j][0]));
    [dot(0, 0) + LOW_PASS, dot(0, 1), dot(1, 1) + LOW_PASS]
}

/// Rotation matrices of un-normalised quaternions (w, x, y, z).
#[inline(always)]
fn rotation<S: Simd>(simd: S, q: &[f32x16<S>; 4]) -> [[f32x16<S>; 3]; 3] {
    let one = f32x16::splat(simd, 1.0);
    let norm2 = q[3].mul_add(q[3], q[2].mul_add(q[2], q[1].mul_add(q[1], q[0] * q[0])));
    let inverse = one / norm2.sqrt();
    let [w, x, y, z] = [q[0] * inverse, q[1] * inverse, q[2] * inverse, q[3] * inverse];
    let two = |a: f32x16<S>| a + a;
    [
        [one - two(y * y + z * z), two(x * y - w * z), two(x * z + w * y)],
        [two(x * y + w * z), one - two(x * x + z * z), two(y * z - w * x)],
        [two(x * z - w * y), two(y * z + w * x), one - two(x * x + y * y)],
    ]
}

/// The colours of all Gaussians seen from `eye` (world units): max(0, SH + ½), sRGB.
pub fn colours(scene: &Gaussians, eye: [f32; 3], level: Level) -> Vec<[f32; 3]> {
    let mut out = Vec::with_capacity(scene.len());
    for first in (0..scene.len()).step_by(LANES) {
        let end = (first + LANES).min(scene.len());
        let basis = dispatch!(level, simd => {
            let world = std::array::from_fn(|k| lanes_of(simd, &scene.means[first..end], |v| v[k]));
            sh_basis(simd, scene.sh_degree, &direction(simd, eye, &world))
        });
        out.extend(
            (first..end)
                .map(|i| colour(scene.sh_of(i), scene.sh_coefficients(), &basis, i - first)),
        );
    }
    out
}

#[inline(always)]
fn direction<S: Simd>(simd: S, eye: [f32; 3], world: &[f32x16<S>; 3]) -> [f32x16<S>; 3] {
    let d: [f32x16<S>; 3] = std::array::from_fn(|k| world[k] - eye[k]);
    let norm2 = d[2].mul_add(d[2], d[1].mul_add(d[1], d[0] * d[0]));
    let inverse = f32x16::splat(simd, 1.0) / norm2.sqrt();
    d.map(|v| v * inverse)
}

/// The real spherical harmonics of 16 directions in the 3DGS sign convention, `[coefficient][lane]`.
#[inline(always)]
fn sh_basis<S: Simd>(simd: S, degree: u8, d: &[f32x16<S>; 3]) -> [[f32; LANES]; 16] {
    let [x, y, z] = *d;
    let mut basis = [[0.0; LANES]; 16];
    let mut set = |k: usize, v: f32x16<S>| basis[k] = v.into();
    set(0, f32x16::splat(simd, SH_C0));
    if degree >= 1 {
        const C1: f32 = 0.488_602_5;
        set(1, y * -C1);
        set(2, z * C1);
        set(3, x * -C1);
    }
    let (xx, yy, zz) = (x * x, y * y, z * z);
    if degree >= 2 {
        set(4, x * y * 1.092_548_4);
        set(5, y * z * -1.092_548_4);
        set(6, (zz + zz - xx - yy) * 0.315_391_57);
        set(7, x * z * -1.092_548_4);
        set(8, (xx - yy) * 0.546_274_2);
    }
    if degree >= 3 {
        set(9, y * (xx * 3.0 - yy) * -0.590_043_6);
        set(10, x * y * z * 2.890_611_4);
        set(11, y * (zz * 4.0 - xx - yy) * -0.457_045_8);
        set(12, z * (zz * 2.0 - xx * 3.0 - yy * 3.0) * 0.373_176_34);
        set(13, x * (zz * 4.0 - xx - yy) * -0.457_045_8);
        set(14, z * (xx - yy) * 1.445_305_7);
        set(15, x * (xx - yy * 3.0) * -0.590_043_6);
    }
    basis
}

/// The constant basis function.
pub const SH_C0: f32 = 0.282_094_8;

/// max(0, SH + ½) per channel; no clamp from above.
#[inline(always)]
fn colour(sh: &[f32], n: usize, basis: &[[f32; LANES]; 16], lane: usize) -> [f32; 3] {
    let mut b = [0.0f32; 16];
    for (k, value) in b.iter_mut().enumerate().take(n) {
        *value = basis[k][lane];
    }
    std::array::from_fn(|c| {
        let mut partial = [0.0f32; 4];
        for (k, s) in sh[c * n..(c + 1) * n].iter().enumerate() {
            partial[k & 3] += s * b[k];
        }
        let sum = (partial[0] + partial[1]) + (partial[2] + partial[3]);
        (sum + 0.5).max(0.0)
    })
}
