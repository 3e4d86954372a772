//! Sorting keys: a depth at some precision.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What of a depth is in a sorting key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DepthKey {
    /// IEEE binary16, rounded to nearest.
    Fp16,
    /// The upper half of binary32, truncated.
    Bf16,
    /// IEEE binary32.
    Fp32,
}

impl DepthKey {
    /// The bits of the key of a positive `depth`. They order like the depths do, as whole numbers;
    /// depths that are equal at this precision have equal keys.
    pub fn of(self, depth: f32) -> u32 {
        match self {
            DepthKey::Fp16 => binary16(depth),
            DepthKey::Bf16 => depth.to_bits() >> 16,
            DepthKey::Fp32 => depth.to_bits(),
        }
    }
}

/// The smallest normal binary16.
const NORMAL: f32 = 1.0 / 16384.0;
/// Half a step above the largest binary16: from here on it is infinity.
const INFINITE: f32 = 65520.0;

/// Positive `x` as binary16, rounded to nearest, ties to even.
fn binary16(x: f32) -> u32 {
    if x >= INFINITE {
        return 0x7c00;
    }
    if x < NORMAL {
        // Below it the numbers are multiples of 2^-24.
        return (f64::from(x) * f64::from(1 << 24)).round_ties_even() as u32;
    }
    let bits = x.to_bits();
    // 13 bits of mantissa go; exponents are biased by 15 instead of 127.
    ((bits + 0xfff + ((bits >> 13) & 1)) >> 13) - ((127 - 15) << 10)
}
