//! A random order of the numbers below `n`, each number computed on its own.
//!
//! A Feistel network over an even number of bits is a permutation of a power of four, which is at
//! most four times `n`; numbers at or above `n` are sent through it again until they are below.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const ROUNDS: usize = 6;

#[derive(Debug, Clone)]
pub(super) struct Permutation {
    n: u64,
    half_bits: u32,
    keys: [u64; ROUNDS],
}

impl Permutation {
    pub(super) fn new(n: u64, seed: u64) -> Self {
        let bits = 64 - n.saturating_sub(1).leading_zeros();
        let mut random = Pcg64::seed_from_u64(seed);
        let keys = std::array::from_fn(|_| random.random());
        Self { n, half_bits: bits.div_ceil(2).max(1), keys }
    }

    /// The number at a place.
    pub(super) fn at(&self, place: u64) -> u64 {
        let mut number = place;
        loop {
            number = self.once(number);
            if number < self.n {
                return number;
            }
        }
    }

    fn once(&self, number: u64) -> u64 {
        let mask = (1u64 << self.half_bits) - 1;
        let (mut left, mut right) = (number >> self.half_bits, number & mask);
        for key in self.keys {
            // An exclusive-or can be taken back whatever `mix` gives, so that no two numbers become
            // one.
            let mixed = mix(right ^ key) & mask;
            (left, right) = (right, left ^ mixed);
        }
        (left << self.half_bits) | right
    }
}

/// The finaliser of SplitMix64.
fn mix(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
