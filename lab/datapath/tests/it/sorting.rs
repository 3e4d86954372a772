//! The sorting units of `rtl/` against sorting, entry for entry and cycle for cycle.

use powergs_datapath::vectors::{self, Vectors};
use powergs_testkit::verilator::Bench;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bench;

/// Lists of all lengths up to `longest`; of every four one has few keys, so that many are equal,
/// and one is sorted.
fn lists(count: usize, longest: usize) -> Vec<Vec<u16>> {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let one = |i: usize| {
        let length = if i < longest { i + 1 } else { random.random_range(1..=longest) };
        let most = if i % 4 == 1 { 5 } else { u16::MAX };
        let mut list: Vec<u16> = (0..length).map(|_| random.random_range(0..=most)).collect();
        if i % 4 == 2 {
            list.sort_unstable();
        }
        list
    };
    (0..count).map(one).collect()
}

fn check(unit: &str, bench: &Bench, vectors: &Vectors) {
    for head in [[3, 0, 0], [3, 4, 0], [3, 0, 4], [3, 6, 3]] {
        let found = vectors.events(&bench.run(&vectors.stalled(head)));
        assert_eq!(vectors.difference(&found, head == [3, 0, 0]), None, "{unit}, {head:?}");
    }
}

#[test]
fn the_quick_sorting_unit_deals_keys_to_parts() {
    let Some(bench) = bench("qsu", &[]) else { return };
    check("qsu", &bench, &vectors::qsu(&lists(100, 600)));
}

#[test]
fn the_bitonic_sorting_unit_sorts_chunks() {
    let Some(bench) = bench("bsu", &[]) else { return };
    check("bsu", &bench, &vectors::bsu(&lists(300, 256)));
}
