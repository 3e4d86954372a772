//! Elementary functions on SIMD lanes.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16};

/// Minimax polynomial of 2^x on [−½, ½]: relative error 7.5e-8 (Remez).
const EXP2: [f32; 6] =
    [1.000_000_1, 0.693_146_97, 0.240_221_2, 0.055_507_13, 0.009_675_541, 0.001_327_647_2];

/// Adding this rounds a float of up to 22 bits to a whole number, which stands in the low bits.
pub const ROUND: f32 = 12_582_912.0;

/// 2^x for x in [−126, 127]; relative error below 2e-7.
#[inline(always)]
pub fn exp2<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let shifted = x + ROUND;
    let f = x - (shifted - ROUND);
    let mut p = f32x16::splat(simd, EXP2[5]);
    for c in EXP2[..5].iter().rev() {
        p = p.mul_add(f, f32x16::splat(simd, *c));
    }
    // The whole part goes into the exponent of p, which is between ½ and 2.
    let exponent = shifted.bitcast::<i32x16<S>>() << 23;
    (p.bitcast::<i32x16<S>>() + exponent).bitcast()
}

/// e^x, clamped to the range where 2^(x log2 e) is normal.
#[inline(always)]
pub(crate) fn exp<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let y = x * std::f32::consts::LOG2_E;
    exp2(simd, y.max(f32x16::splat(simd, -126.0)).min(f32x16::splat(simd, 127.0)))
}

/// Transposes 16 vectors.
#[inline(always)]
pub fn transpose<S: Simd>(rows: &mut [f32x16<S>; 16]) {
    for _ in 0..4 {
        let old = *rows;
        for i in 0..8 {
            rows[2 * i] = old[i].zip_low(old[i + 8]);
            rows[2 * i + 1] = old[i].zip_high(old[i + 8]);
        }
    }
}
