//! Reciprocals and reciprocal roots: straight lines between the entries of tables.
//!
//! The first bits of the significand choose one of 128 lines, the rest is the way on it. The lines
//! are as much below the function at their ends as above it in their middle. Subnormal arguments
//! count as zero.

use std::sync::OnceLock;

use crate::WideFormat;
use powergs_base::number::{Number, Parts, Rounding};

/// Bits of the index into a table.
pub(crate) const INDEX: u32 = 7;
/// Bits after the point of an entry.
pub(crate) const FRACTION: u32 = 22;
/// Bits of the mantissa, at most: behind them lines are too coarse.
pub(crate) const MANTISSA_MOST: u32 = 17;

/// Entries of a table: a line begins at the first number and falls by the second, in 2^-22.
pub type Table = [[u32; 2]; 1 << INDEX];

/// Lines of 1/x, x from 1 in steps of 1/128.
pub fn reciprocal_table() -> Table {
    line_table(|i| {
        let x = 1.0 + f64::from(i) / 128.0;
        (1.0 / x, 2.0 / (x * x * x), 1.0 / 128.0)
    })
}

/// Lines of 1/sqrt(x), x from 1 in steps of 1/64, then from 2 in steps of 1/32.
pub fn root_table() -> Table {
    let entry = |x: f64, step: f64| (1.0 / x.sqrt(), 0.75 / (x * x * x.sqrt()), step);
    let line = |i: u32| match i {
        0..64 => entry(1.0 + f64::from(i) / 64.0, 1.0 / 64.0),
        _ => entry(2.0 + f64::from(i - 64) / 32.0, 1.0 / 32.0),
    };
    let mut table = line_table(line);
    // The last line of the first octave ends where the second begins.
    let end = ends(entry(2.0, 1.0 / 64.0));
    table[63][1] = table[63][0] - end;
    let end = ends(entry(4.0, 1.0 / 32.0));
    table[127][1] = table[127][0] - end;
    table
}

/// Value, second derivative and length of a step: the line lies lower by half of what a chord is
/// too high.
fn ends((value, curvature, step): (f64, f64, f64)) -> u32 {
    let unit = f64::from(1u32 << FRACTION);
    ((value - step * step * curvature / 16.0) * unit + 0.5) as u32
}

fn line_table(entry: impl Fn(u32) -> (f64, f64, f64)) -> Table {
    std::array::from_fn(|i| {
        let (from, to) = (ends(entry(i as u32)), ends(entry(i as u32 + 1)));
        [from, from - to]
    })
}

/// Bits of the way on a line.
fn step_bits(format: WideFormat) -> u32 {
    format.mantissa_bits().saturating_sub(INDEX).max(1)
}

/// The line of a table at a mantissa: `bits` bits are the last ones of the index.
fn line(format: WideFormat, table: &Table, first: usize, bits: u32, mantissa: u32) -> u64 {
    let all = INDEX + step_bits(format);
    // Short mantissas get zeros behind.
    let whole = u64::from(mantissa) << (all - format.mantissa_bits());
    let below = all - bits;
    let [from, fall] = table[first + (whole >> below) as usize].map(u64::from);
    from - ((fall * (whole & ((1 << below) - 1))) >> below)
}

/// Sign, exponent and mantissa of a normal number, or the result of the others.
fn normal(
    format: WideFormat,
    a: u32,
    of_zero: u32,
    of_infinity: u32,
) -> Result<(bool, i32, u32), u32> {
    match format.unpack(a) {
        Number::Nan => Err(format.nan()),
        Number::Infinity(_) => Err(of_infinity),
        Number::Finite(Parts { sign, exponent, significand }) => {
            let mantissa = significand as u32 ^ 1 << format.mantissa_bits();
            let is_normal = significand >> format.mantissa_bits() == 1;
            let exponent = exponent + format.mantissa_bits() as i32;
            if is_normal { Ok((sign, exponent, mantissa)) } else { Err(of_zero) }
        }
    }
}

/// 1 / a; infinite for zero and subnormals.
pub(crate) fn reciprocal(format: WideFormat, a: u32) -> u32 {
    assert!(format.mantissa_bits() <= MANTISSA_MOST, "lines are fine enough");
    let sign = a & format.sign();
    match normal(format, a, format.infinity() | sign, sign) {
        Err(number) => number,
        Ok((sign, exponent, mantissa)) => {
            let significand = line(format, reciprocal_lines(), 0, INDEX, mantissa);
            let exponent = -exponent - FRACTION as i32;
            format.round(Parts { sign, exponent, significand }, Rounding::NearestEven)
        }
    }
}

/// 1 / sqrt(a); infinite for zeros and subnormals, NaN for what is below.
pub(crate) fn reciprocal_root(format: WideFormat, a: u32) -> u32 {
    assert!(format.mantissa_bits() <= MANTISSA_MOST, "lines are fine enough");
    let below = a & format.sign() != 0;
    let of_infinity = if below { format.nan() } else { 0 };
    match normal(format, a, format.infinity(), of_infinity) {
        Err(number) => number,
        Ok((true, ..)) => format.nan(),
        Ok((false, exponent, mantissa)) => {
            let odd = exponent & 1;
            let significand = line(format, root_lines(), 64 * odd as usize, INDEX - 1, mantissa);
            let exponent = -(exponent - odd) / 2 - FRACTION as i32;
            let parts = Parts { sign: false, exponent, significand };
            format.round(parts, Rounding::NearestEven)
        }
    }
}
fn reciprocal_lines() -> &'static Table {
    static LINES: OnceLock<Table> = OnceLock::new();
    LINES.get_or_init(reciprocal_table)
}

fn root_lines() -> &'static Table {
    static LINES: OnceLock<Table> = OnceLock::new();
    LINES.get_or_init(root_table)
}
