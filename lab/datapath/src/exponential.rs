//! The exponential of the hardware: 2^-|x|.
//!
//! |x| is cut to a fixed-point number of `mantissa + 4` fraction bits and negated; its whole part
//! is the exponent of the result. On the fraction r the power 2^r is a straight line between the
//! entries of a table, 2^(i/32) to 16 bits after the point; formats of few bits use fewer of its
//! entries and bits of them. The result is rounded once, to nearest even, subnormals included. The
//! error is below one ulp of the result in every format; `tests/it/numbers.rs` has the maxima over
//! all inputs.

use powergs_base::number::NumberFormat;
use powergs_base::number::{Number, Parts, Rounding};

/// Bits of the index into the table.
const INDEX: u32 = 5;
/// Bits after the point of its entries.
const FRACTION: u32 = 16;
/// 2^(i/32), rounded to nearest.
const POWERS: [u32; (1 << INDEX) + 1] = [
    65536, 66971, 68438, 69936, 71468, 73032, 74632, 76266, 77936, 79642, 81386, 83169, 84990,
    86851, 88752, 90696, 92682, 94711, 96785, 98905, 101070, 103283, 105545, 107856, 110218,
    112631, 115098, 117618, 120194, 122825, 125515, 128263, 131072,
];

/// Bits after the point to which |x| is cut.
fn argument_fraction(format: NumberFormat) -> u32 {
    format.mantissa_bits() + 4
}

/// Bits of the index into the table that this format uses.
fn index_bits(format: NumberFormat) -> u32 {
    format.mantissa_bits().div_ceil(2).min(INDEX)
}

/// Bits after the point that its entries have in this format.
fn power_fraction(format: NumberFormat) -> u32 {
    (format.mantissa_bits() + 4).min(FRACTION)
}

/// An entry of the table of this format.
fn power(format: NumberFormat, index: u32) -> u32 {
    let entry = POWERS[(index << (INDEX - index_bits(format))) as usize];
    let dropped = FRACTION - power_fraction(format);
    // Half a unit is added where something is dropped.
    (entry + (1 << dropped >> 1)) >> dropped
}

/// 2^-|x|: 1 of both zeros, 0 of both infinities.
pub(crate) fn exp2_negative(format: NumberFormat, x: u16) -> u16 {
    let Parts { exponent, significand, .. } = match format.unpack(x) {
        Number::Nan => return format.nan(),
        Number::Infinity(_) => return 0,
        Number::Finite(parts) => parts,
    };
    let fraction = argument_fraction(format);
    // From this whole part on even the least subnormal is more than twice the result.
    let limit = (2 - format.least()) as u64;
    let shift = exponent + fraction as i32;
    let argument = match u32::try_from(shift) {
        Ok(left) => u128::from(significand) << left.min(100),
        Err(_) => u128::from(significand.checked_shr(shift.unsigned_abs()).unwrap_or(0)),
    };
    if argument >> fraction >= u128::from(limit) {
        return 0;
    }
    let negated = -(argument as i64);
    let whole = (negated >> fraction) as i32;
    let rest = (negated & ((1 << fraction) - 1)) as u32;
    let below = fraction - index_bits(format);
    let index = rest >> below;
    let step = rest & ((1 << below) - 1);
    let (from, to) = (power(format, index), power(format, index + 1));
    let line = from + (((to - from) * step) >> below);
    let parts = Parts {
        sign: false,
        exponent: whole - power_fraction(format) as i32,
        significand: u64::from(line),
    };
    format.round(parts, Rounding::NearestEven)
}
