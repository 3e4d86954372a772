//! The backward pass of the view-dependent colour: spherical harmonics and viewing direction.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;

use super::{SH_MOST, Stretch};
use crate::splat::project::{LANES, View, dot3};
use crate::splat::simd::transpose;

/// Writes the gradients by the SH coefficients of the Gaussians at the places `seen` of `part`;
/// returns the gradient by the unit viewing direction.
#[inline(always)]
pub(super) fn backward<S: Simd>(
    simd: S,
    part: &Stretch<'_>,
    seen: &[u32],
    toward: &[f32x16<S>; 3],
    basis: &[f32x16<S>; 16],
    by_colour: &[[f32; LANES]; 3],
    out: &mut [[f32; SH_MOST]; LANES],
) -> [f32x16<S>; 3] {
    let zero = f32x16::splat(simd, 0.0);
    let mut by_gaussian = *basis;
    transpose(&mut by_gaussian);
    let block = HarmonicsBlock { part, seen, by_colour, by_gaussian };
    let mut by_basis = match part.sh_degree {
        0 => block.spread::<1>(simd, out),
        1 => block.spread::<4>(simd, out),
        2 => block.spread::<9>(simd, out),
        _ => block.spread::<16>(simd, out),
    };
    if part.sh_degree == 0 {
        return [zero; 3];
    }
    transpose(&mut by_basis);
    slopes(part.sh_degree, toward, &by_basis)
}

struct HarmonicsBlock<'a, S: Simd> {
    part: &'a Stretch<'a>,
    seen: &'a [u32],
    by_colour: &'a [[f32; LANES]; 3],
    /// The basis functions of each Gaussian.
    by_gaussian: [f32x16<S>; 16],
}

impl<S: Simd> HarmonicsBlock<'_, S> {
    /// Writes the gradients by `N` coefficients a channel; returns those by the basis functions of
    /// each Gaussian.
    #[inline(always)]
    fn spread<const N: usize>(
        &self,
        simd: S,
        out: &mut [[f32; SH_MOST]; LANES],
    ) -> [f32x16<S>; 16] {
        let zero = f32x16::splat(simd, 0.0);
        let mut by_basis = [zero; 16];
        for (lane, place) in self.seen.iter().take(LANES).enumerate() {
            let sh = self.part.sh_of(*place as usize);
            let basis = self.by_gaussian[lane];
            let mut sum = zero;
            for channel in 0..3 {
                let by_colour = self.by_colour[channel][lane];
                let range = channel * N..(channel + 1) * N;
                let coefficients = load::<S, N>(simd, &sh[range.clone()]);
                sum = coefficients.mul_add(by_colour, sum);
                let gradient: [f32; 16] = (basis * by_colour).into();
                out[lane][range].copy_from_slice(&gradient[..N]);
            }
            by_basis[lane] = sum;
        }
        by_basis
    }
}

/// `N` numbers, then zeros.
#[inline(always)]
fn load<S: Simd, const N: usize>(simd: S, values: &[f32]) -> f32x16<S> {
    let mut lanes = [0.0; 16];
    lanes[..N].copy_from_slice(&values[..N]);
    f32x16::simd_from(simd, lanes)
}

/// The gradient by x, y and z of the direction, given the gradient `v` by the basis functions.
#[inline(always)]
fn slopes<S: Simd>(degree: u8, toward: &[f32x16<S>; 3], v: &[f32x16<S>; 16]) -> [f32x16<S>; 3] {
    let [x, y, z] = *toward;
    const C1: f32 = 0.488_602_5;
    let mut out = [v[3] * -C1, v[1] * -C1, v[2] * C1];
    if degree >= 2 {
        let (xy, yz, xz) = (v[4] * 1.092_548_4, v[5] * -1.092_548_4, v[7] * -1.092_548_4);
        let (zz, xx_yy) = (v[6] * (2.0 * 0.315_391_57), v[8] * (2.0 * 0.546_274_2));
        out[0] += xy * y + xz * z + (xx_yy - zz) * x;
        out[1] += xy * x + yz * z - (xx_yy + zz) * y;
        out[2] += yz * y + xz * x + (zz + zz) * z;
    }
    if degree >= 3 {
        let cubic = cubic_slopes(toward, v);
        for k in 0..3 {
            out[k] += cubic[k];
        }
    }
    out
}

#[inline(always)]
fn cubic_slopes<S: Simd>(toward: &[f32x16<S>; 3], v: &[f32x16<S>; 16]) -> [f32x16<S>; 3] {
    let [x, y, z] = *toward;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, yz, xz) = (x * y, y * z, x * z);
    let (v9, v10) = (v[9] * -0.590_043_6, v[10] * 2.890_611_4);
    let (v11, v12) = (v[11] * -0.457_045_8, v[12] * 0.373_176_34);
    let (v13, v14) = (v[13] * -0.457_045_8, v[14] * 1.445_305_7);
    let v15 = v[15] * -0.590_043_6;
    let across = (xx - yy) * 3.0;
    [
        v9 * xy * 6.0 + v10 * yz - v11 * xy * 2.0 - v12 * xz * 6.0
            + v13 * (zz * 4.0 - xx * 3.0 - yy)
            + v14 * xz * 2.0
            + v15 * across,
        v9 * across + v10 * xz + v11 * (zz * 4.0 - xx - yy * 3.0)
            - v12 * yz * 6.0
            - v13 * xy * 2.0
            - v14 * yz * 2.0
            - v15 * xy * 6.0,
        v10 * xy
            + v11 * yz * 8.0
            + v12 * (zz * 6.0 - xx * 3.0 - yy * 3.0)
            + v13 * xz * 8.0
            + v14 * (xx - yy),
    ]
}

/// The gradient by the centre, in world units, through the viewing direction.
#[inline(always)]
pub(super) fn through_direction<S: Simd>(
    view: &View,
    world: &[f32x16<S>; 3],
    toward: &[f32x16<S>; 3],
    by_direction: &[f32x16<S>; 3],
) -> [f32x16<S>; 3] {
    let mut out = *by_direction;
    let eye = view.centre;
    let d = [world[0] - eye[0], world[1] - eye[1], world[2] - eye[2]];
    let length = dot3(&d, &d).sqrt();
    let radial = dot3(toward, by_direction);
    for k in 0..3 {
        out[k] = (by_direction[k] - radial * toward[k]) / length;
    }
    out
}
