//! Number formats against arithmetic of others: `half`, f32 and f64.

use std::cmp::Ordering;

use half::f16;
use powergs_datapath::{Arithmetic, Exponential};
use powergs_datapath::{FormatError, NumberFormat};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const FP16: NumberFormat = NumberFormat::FP16;

/// Formats of all widths, with and without room for many exponents.
pub fn formats() -> Vec<NumberFormat> {
    let names = ["e5m10", "e8m7", "e4m11", "e6m5", "e5m6", "e4m3", "e5m2", "e3m4", "e2m13", "e6m9"];
    names.iter().map(|name| name.parse().expect("a format")).collect()
}

/// Numbers where something happens: zeros, the ends of subnormals and of normal numbers, one and
/// its neighbours, infinities, NaN; of both signs.
pub fn corners(format: NumberFormat) -> Vec<u16> {
    let normal = 1 << format.mantissa_bits();
    let (one, infinity) = (format.one(), format.infinity());
    let odd = (normal / 2) | 1;
    let mut corners = vec![0, 1, 2, 3, odd, normal - 1, normal, normal + 1, 2 * normal - 1];
    corners.extend([2 * normal, one - 1, one, one + 1, one | odd, one + normal - 1]);
    corners.extend([one + normal, infinity - normal, infinity - 2, infinity - 1, infinity]);
    corners.extend([infinity + 1, format.nan(), format.nan() | 1, infinity | (normal - 1)]);
    let negative: Vec<u16> = corners.iter().map(|c| c | format.sign()).collect();
    corners.extend(negative);
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// Bits of ours against a number of `half`, whose NaN have payloads.
#[track_caller]
fn same(ours: u16, theirs: f16, what: &str, a: u16, b: u16) {
    let theirs = if theirs.is_nan() { FP16.nan() } else { theirs.to_bits() };
    assert_eq!(ours, theirs, "{what} of {a:#06x} and {b:#06x}");
}

fn check_against_half(a: u16, b: u16) {
    let (x, y) = (f16::from_bits(a), f16::from_bits(b));
    same(FP16.add(a, b), x + y, "sum", a, b);
    same(FP16.subtract(a, b), x - y, "difference", a, b);
    same(FP16.multiply(a, b), x * y, "product", a, b);
    assert_eq!(FP16.compare(a, b), x.partial_cmp(&y), "order of {a:#06x} and {b:#06x}");
}

#[test]
fn fp16_adds_and_multiplies_like_half_at_random_pairs() {
    let mut random = Pcg64Mcg::seed_from_u64(16);
    for _ in 0..10_000_000 {
        let pair: u32 = random.random();
        check_against_half(pair as u16, (pair >> 16) as u16);
    }
}

#[test]
fn fp16_adds_and_multiplies_like_half_at_all_pairs_of_corners() {
    for &a in &corners(FP16) {
        for &b in &corners(FP16) {
            check_against_half(a, b);
        }
    }
}

#[test]
fn fp16_converts_like_half() {
    for bits in 0..=u16::MAX {
        let theirs = f16::from_bits(bits);
        if theirs.is_nan() {
            assert!(FP16.is_nan(bits) && FP16.to_f32(bits).is_nan());
            continue;
        }
        assert_eq!(FP16.to_f32(bits).to_bits(), theirs.to_f32().to_bits());
        assert_eq!(FP16.from_f32(theirs.to_f32()), bits);
        // Halfway to the next number, and just on both sides of that.
        let next = f16::from_bits(bits + 1);
        if theirs.is_infinite() || next.is_infinite() || next.is_nan() {
            continue;
        }
        let half = 0.5 * (theirs.to_f32() + next.to_f32());
        for value in [half.next_down(), half, half.next_up()] {
            assert_eq!(FP16.from_f32(value), f16::from_f32(value).to_bits(), "{value:e}");
        }
    }
    let ends =
        [65519.99, 65520.0, 1e30, f32::INFINITY, 2.0f32.powi(-25), 1e-30, 0.0, f32::MIN_POSITIVE];
    for value in ends.into_iter().chain([f32::from_bits(1)]) {
        for value in [value, -value] {
            assert_eq!(FP16.from_f32(value), f16::from_f32(value).to_bits(), "{value:e}");
        }
    }
    assert_eq!(FP16.from_f32(-f32::NAN), FP16.nan());
}

/// In f64 sums and products of numbers with less than 25 bits are rounded harmlessly, and so is
/// what becomes of them here.
#[test]
fn all_formats_add_and_multiply_like_f64() {
    let mut random = Pcg64Mcg::seed_from_u64(8);
    for format in formats() {
        let mask = u16::MAX >> (16 - format.bits());
        let mut pairs: Vec<(u16, u16)> = Vec::new();
        if format.bits() == 8 {
            pairs.extend(format.all().flat_map(|a| format.all().map(move |b| (a, b))));
        } else {
            let corners = corners(format);
            pairs.extend(corners.iter().flat_map(|&a| corners.iter().map(move |&b| (a, b))));
            for _ in 0..300_000 {
                let pair: u32 = random.random();
                pairs.push((pair as u16 & mask, (pair >> 16) as u16 & mask));
            }
        }
        for (a, b) in pairs {
            let (x, y) = (format.to_f64(a), format.to_f64(b));
            let what = format!("{format}: {a:#x} {b:#x}");
            assert_eq!(format.add(a, b), format.from_f64(x + y), "{what}");
            assert_eq!(format.multiply(a, b), format.from_f64(x * y), "{what}");
            assert_eq!(format.compare(a, b), x.partial_cmp(&y), "{what}");
        }
    }
}

#[test]
fn every_format_converts_its_own_numbers_exactly() {
    for format in formats() {
        for number in format.all() {
            let back = format.from_f32(format.to_f32(number));
            let expected = if format.is_nan(number) { format.nan() } else { number };
            assert_eq!(back, expected, "{format} {number:#x}");
        }
    }
}

#[test]
fn directed_rounding_encloses() {
    for format in formats() {
        for value in [1.0 / 255.0, 0.99, 1e-4, 0.3, 1.0, 1.5] {
            let (below, above) = (format.at_most(value), format.at_least(value));
            assert!(format.to_f64(below) <= value && format.to_f64(above) >= value, "{format}");
            assert!(above - below <= 1, "{format} {value}");
        }
    }
    assert_eq!(FP16.to_f64(FP16.at_most(1e9)), 65504.0);
}

/// The largest error of 2^-|x| over all finite x, ulp of the exact result.
fn largest_error(format: NumberFormat) -> f64 {
    let least = format.to_f64(1);
    let finite = format.all().filter(|&x| format.to_f64(x).is_finite());
    let error = |x| {
        let exact = (-format.to_f64(x).abs()).exp2();
        let ulp = exact.log2().floor().exp2() / f64::from(1 << format.mantissa_bits());
        (format.to_f64(format.exp2_negative(x)) - exact).abs() / ulp.max(least)
    };
    finite.map(error).fold(0.0, f64::max)
}

/// The README of `rtl/` quotes this table.
#[test]
fn the_exponential_is_faithful_in_every_format() {
    let published = "\
        e5m10 0.678\ne8m7 0.575\ne4m11 0.792\ne6m5 0.593\ne5m6 0.637\ne4m3 0.553\ne5m2 0.503\n\
        e3m4 0.552\ne2m13 0.937\ne6m9 0.617\n";
    let line = |format: NumberFormat| format!("{format} {:.3}\n", largest_error(format));
    let found: String = formats().into_iter().map(line).collect();
    assert_eq!(found, published);
}

#[test]
fn the_exponential_falls_and_knows_its_ends() {
    for format in formats() {
        let (one, sign) = (format.one(), format.sign());
        for zero in [0, sign] {
            assert_eq!(format.exp2_negative(zero), one, "{format}");
        }
        let finite: Vec<u16> = (0..=format.infinity()).collect();
        for pair in finite.windows(2) {
            let (near, far) = (format.exp2_negative(pair[0]), format.exp2_negative(pair[1]));
            assert_eq!(format.exp2_negative(pair[1] | sign), far);
            assert_ne!(format.compare(near, far), Some(Ordering::Less), "{format} {:#x}", pair[1]);
        }
        assert_eq!(format.exp2_negative(format.infinity()), 0);
        assert_eq!(format.exp2_negative(format.nan()), format.nan());
        for whole in 0..6 {
            let x = format.from_f64(f64::from(whole));
            if format.to_f64(x) == f64::from(whole) {
                let power = (-f64::from(whole)).exp2();
                assert_eq!(format.exp2_negative(x), format.from_f64(power), "{format}: {whole}");
            }
        }
    }
}

#[test]
fn formats_are_read_and_written() {
    for format in formats() {
        assert_eq!(format.to_string().parse(), Ok(format));
    }
    assert_eq!("e5m10".parse(), Ok(FP16));
    for text in ["", "fp16", "e5", "m10", "e+5m10", "e5m10 ", "e5m", "e99999999999m1"] {
        assert_eq!(text.parse::<NumberFormat>(), Err(FormatError::Spelling(text.to_owned())));
    }
    for (exponent, mantissa) in [(1, 10), (9, 6), (5, 11), (4, 2), (7, 0), (u32::MAX, u32::MAX)] {
        let error = FormatError::Range(exponent, mantissa);
        assert_eq!(NumberFormat::new(exponent, mantissa), Err(error.clone()));
        assert!(error.to_string().contains("8 to 16 bits"));
    }
}
