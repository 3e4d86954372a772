//! The modules `fp_add`, `fp_mul` and `fp_exp` of `rtl/` against the model, bit for bit.

use powergs_datapath::NumberFormat;
use powergs_datapath::{Arithmetic, Exponential};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bench;
use super::numbers::{corners, formats};

/// Pairs of a format: all of those with 8 bits; otherwise every number once, all pairs of corners
/// and random ones, a million for FP16.
fn pairs(format: NumberFormat, random: &mut Pcg64Mcg) -> Vec<(u16, u16)> {
    if format.bits() == 8 {
        return format.all().flat_map(|a| format.all().map(move |b| (a, b))).collect();
    }
    let corners = corners(format);
    let mut pairs: Vec<(u16, u16)> =
        corners.iter().flat_map(|&a| corners.iter().map(move |&b| (a, b))).collect();
    let mask = u16::MAX >> (16 - format.bits());
    pairs.extend(format.all().map(|a| (a, random.random::<u16>() & mask)));
    let count = if format == NumberFormat::FP16 { 1_000_000 } else { 100_000 };
    // Half of the random pairs have exponents that are not far apart, where sums cancel.
    let near = (4 << format.mantissa_bits()) - 1;
    for i in 0..count {
        let (a, b) = (random.random::<u16>() & mask, random.random::<u16>() & mask);
        let close = (a ^ format.sign()).wrapping_add(b & near).wrapping_sub(near / 2) & mask;
        pairs.push((a, if i % 2 == 0 { b } else { close }));
    }
    pairs
}

#[test]
fn operations_in_hardware_are_those_of_the_model() {
    let Some(bench) = bench("fp_bench", &[]) else { return };
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for (index, format) in formats().into_iter().enumerate() {
        let pairs = pairs(format, &mut random);
        let words: Vec<u16> = pairs.iter().flat_map(|&(a, b)| [index as u16, a, b]).collect();
        let results = bench.run(&words);
        assert_eq!(results.len(), 6 * pairs.len());
        for (&(a, b), found) in pairs.iter().zip(results.chunks_exact(6)) {
            let expected = [format.add(a, b), format.multiply(a, b), format.exp2_negative(a)];
            assert_eq!(found[..3], expected, "{format}: {a:#06x} and {b:#06x}");
            assert_eq!(found[3..], expected, "{format}, split: {a:#06x} and {b:#06x}");
        }
    }
}
