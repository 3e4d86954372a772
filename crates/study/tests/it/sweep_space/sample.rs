//! Points chosen beforehand.

use std::collections::BTreeSet;

use powergs_study::sweep::file::{Method, Sampling};
use powergs_study::sweep::lattice::{Lattice, LatticeSide};
use powergs_study::sweep::sample::select;
use powergs_study::sweep::sample::sobol::{DIMENSIONS_MAX, Sobol};
use proptest::prelude::*;

fn lattice(lens: &[u32]) -> Lattice {
    let side = |&len: &u32| LatticeSide { len, ordered: true };
    Lattice::new(lens.iter().map(side).collect()).expect("a lattice")
}

fn chosen(lens: &[u32], method: Method, points: Option<u64>, seed: u64) -> Vec<u64> {
    let sampling = Sampling { method, points, seed, ..Sampling::default() };
    select(&lattice(lens), &sampling).collect()
}

#[test]
fn lattices_know_their_limits() {
    let side = |len| LatticeSide { len, ordered: true };
    assert!(Lattice::new(vec![side(0)]).is_none());
    assert!(Lattice::new(vec![side(u32::MAX); 3]).is_none());
    assert_eq!(Lattice::new(vec![]).map(|l| l.points()), Some(1));
}

#[test]
fn part_of_a_grid_is_spread_over_all_of_it() {
    assert_eq!(chosen(&[4, 5], Method::Grid, None, 1), (0..20).collect::<Vec<_>>());
    assert_eq!(chosen(&[4, 5], Method::Grid, Some(4), 1), [0, 5, 10, 15]);
    assert_eq!(chosen(&[4, 5], Method::Grid, Some(400), 1).len(), 20);
}

#[test]
fn the_first_sobol_points_are_the_published_ones() {
    // In Gray order, dimensions 1 to 5; scipy.stats.qmc.Sobol(5, scramble=False) gives the same.
    let expected = [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [0.5, 0.5, 0.5, 0.5, 0.5],
        [0.75, 0.25, 0.25, 0.25, 0.75],
        [0.25, 0.75, 0.75, 0.75, 0.25],
        [0.375, 0.375, 0.625, 0.875, 0.375],
        [0.875, 0.875, 0.125, 0.375, 0.875],
        [0.625, 0.125, 0.875, 0.625, 0.625],
        [0.125, 0.625, 0.375, 0.125, 0.125],
    ];
    let mut sobol = Sobol::plain(5);
    for point in expected {
        assert_eq!(sobol.next_point(), point);
    }
}

/// Every first part of 2^k points puts one point in each of 2^k cells of every axis, and one in
/// each cell of 2^a x 2^b, a + b = k, of the first two: a (0, k, 2)-net. A shift keeps both.
#[test]
fn sobol_points_lie_evenly() {
    for mut sobol in [Sobol::plain(DIMENSIONS_MAX), Sobol::new(DIMENSIONS_MAX, 7)] {
        let points: Vec<Vec<f64>> = (0..256).map(|_| sobol.next_point()).collect();
        for k in [4u32, 6, 8] {
            let n = 1usize << k;
            for axis in 0..DIMENSIONS_MAX {
                let cells: BTreeSet<u64> =
                    points[..n].iter().map(|p| (p[axis] * n as f64) as u64).collect();
                assert_eq!(cells.len(), n, "axis {axis}, {n} points");
            }
            for a in 0..=k {
                let cell = |p: &Vec<f64>| {
                    ((p[0] * f64::from(1 << a)) as u64, (p[1] * f64::from(1 << (k - a))) as u64)
                };
                let cells: BTreeSet<(u64, u64)> = points[..n].iter().map(cell).collect();
                assert_eq!(cells.len(), n, "{n} points in cells of 2^{a} x 2^{}", k - a);
            }
        }
    }
}

#[test]
fn sobol_seeds_differ_and_repeat() {
    let of = |seed| chosen(&[16, 16, 16], Method::Sobol, Some(32), seed);
    assert_eq!(of(3), of(3));
    assert_ne!(of(3), of(4));
    assert_eq!(of(3).len(), 32);
}

#[test]
fn a_small_space_ends() {
    let all = chosen(&[2, 3], Method::Sobol, Some(1000), 1);
    assert_eq!(all.into_iter().collect::<BTreeSet<_>>().len(), 6);
    assert!(chosen(&[2, 3], Method::Nsga2, None, 1).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn random_points_are_each_there_once(lens in prop::collection::vec(1u32..7, 1..5), seed: u64) {
        let all = chosen(&lens, Method::Random, None, seed);
        let points = lattice(&lens).points();
        prop_assert_eq!(all.len() as u64, points);
        let set: BTreeSet<u64> = all.iter().copied().collect();
        prop_assert_eq!(set, (0..points).collect());
        let first = chosen(&lens, Method::Random, Some(3), seed);
        prop_assert_eq!(&first[..], &all[..first.len()]);
    }

    /// Along an axis, a Latin hypercube of n points has every value n / len times, give or take 1.
    #[test]
    fn latin_hypercubes_are_even(len in 2u32..12, n in 1u64..60, seed: u64) {
        // A second axis so long that points hardly ever fall together.
        let lens = [len, 100_000];
        let points = chosen(&lens, Method::Lhs, Some(n), seed);
        prop_assume!(points.len() as u64 == n);
        let lattice = lattice(&lens);
        let mut counts = vec![0u64; len as usize];
        for index in points {
            counts[lattice.digits(index)[0] as usize] += 1;
        }
        let (least, most) = (n / u64::from(len), n.div_ceil(u64::from(len)));
        for count in counts {
            prop_assert!(count + 1 >= least && count <= most + 1, "{count}: {least} to {most}");
        }
    }

    #[test]
    fn methods_stay_inside_and_repeat(
        lens in prop::collection::vec(1u32..9, 1..6),
        points in prop::option::of(1u64..40),
        seed: u64,
        method in prop::sample::select(
            vec![Method::Grid, Method::Random, Method::Lhs, Method::Sobol]
        ),
    ) {
        let once = chosen(&lens, method, points, seed);
        prop_assert_eq!(&once, &chosen(&lens, method, points, seed));
        let all = lattice(&lens).points();
        prop_assert!(once.iter().all(|i| *i < all));
        prop_assert_eq!(once.iter().collect::<BTreeSet<_>>().len(), once.len());
        prop_assert!(once.len() as u64 <= points.unwrap_or(all).min(all));
    }
}
