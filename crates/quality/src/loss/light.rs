//! The sRGB curve on SIMD lanes: linear light and its slope, without a power function.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16};

/// Linear light and its derivative by the sRGB value; both 0 at and below black. Relative error
/// below 1e-6 against double precision.
#[inline(always)]
pub(crate) fn light<S: Simd>(simd: S, v: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    let zero = f32x16::splat(simd, 0.0);
    let t = (v.max(zero) + 0.055) * (1.0 / 1.055);
    // t^1.4 = t² t^(−3/5).
    let root = inverse_fifth_root(simd, t);
    let power = (t * root) * (t * root) * root;
    let low = v.simd_le(f32x16::splat(simd, 0.04045));
    let black = v.simd_le(zero);
    let slope = low.select(f32x16::splat(simd, 1.0 / 12.92), power * (2.4 / 1.055));
    let value = low.select(v * (1.0 / 12.92), power * t);
    (black.select(zero, value), black.select(zero, slope))
}

/// t^(−1/5) for positive t: a guess from the exponent, then Newton steps `z (6 − t z⁵) / 5`, which
/// need no division and triple the square of the relative error: 3e-2, 3e-3, 3e-5, 2e-9.
#[inline(always)]
fn inverse_fifth_root<S: Simd>(simd: S, t: f32x16<S>) -> f32x16<S> {
    /// Bits of 1.0 times 6/5, less what centres the error of the guess.
    const GUESS: f32 = 1_065_353_216.0 * 1.2 - 500_000.0;
    let bits = t.bitcast::<i32x16<S>>().to_float::<f32x16<S>>();
    let guess = bits.mul_add(f32x16::splat(simd, -0.2), f32x16::splat(simd, GUESS));
    let mut z = guess.to_int::<i32x16<S>>().bitcast::<f32x16<S>>();
    for _ in 0..3 {
        let z2 = z * z;
        let tz5 = (z2 * z2) * (z * t);
        z *= tz5.mul_add(f32x16::splat(simd, -0.2), f32x16::splat(simd, 1.2));
    }
    z
}
