//! The adaptive search.

use std::collections::BTreeSet;

use powergs_study::sweep::file::{Method, Sampling};
use powergs_study::sweep::lattice::{Lattice, LatticeSide};
use powergs_study::sweep::search::Search;
use powergs_study::sweep::search::front::{FrontTrial, Ranked, best, dominates};
use proptest::prelude::*;

fn lattice(lens: &[u32]) -> Lattice {
    let side = |&len: &u32| LatticeSide { len, ordered: true };
    Lattice::new(lens.iter().map(side).collect()).expect("a lattice")
}

fn sampling(population: u32, generations: u32, points: Option<u64>) -> Sampling {
    Sampling { method: Method::Nsga2, points, seed: 5, population, generations }
}

/// ZDT1 on a lattice: the front is where all axes but the first are 0.
fn zdt1(digits: &[u32], len: u32) -> Vec<f64> {
    let unit = |d: u32| f64::from(d) / f64::from(len - 1);
    let first = unit(digits[0]);
    let rest = digits[1..].iter().map(|&d| unit(d)).sum::<f64>() / (digits.len() - 1) as f64;
    let g = 1.0 + 9.0 * rest;
    vec![first, g * (1.0 - (first / g).sqrt())]
}

fn run(
    search: &mut Search,
    allowed: &dyn Fn(u64) -> Option<u64>,
    result: impl Fn(u64) -> Option<Vec<f64>>,
) -> Vec<u64> {
    let mut all = Vec::new();
    loop {
        let asked = search.ask(allowed);
        if asked.is_empty() {
            return all;
        }
        let mut told: Vec<_> =
            asked.iter().map(|&i| (i, result(i).map(FrontTrial::from))).collect();
        told.reverse();
        search.tell(&told);
        all.extend(asked);
    }
}

#[test]
fn it_finds_the_front_of_zdt1() {
    const LEN: u32 = 32;
    let lattice = lattice(&[LEN; 6]);
    let mut search = Search::new(&lattice, &sampling(40, 40, None));
    let asked = run(&mut search, &Some::<u64>, |i| Some(zdt1(&lattice.digits(i), LEN)));
    let once: BTreeSet<u64> = asked.iter().copied().collect();
    assert_eq!((asked.len(), once.len()), (1600, 1600), "no point is asked for twice");
    // 1600 of 2^30 points. The front has 32; random sampling finds none of them.
    let front = search.front();
    let optimal = front.iter().filter(|&&i| lattice.digits(i)[1..].iter().all(|&d| d == 0));
    assert!(optimal.count() >= 24, "{front:?}");
}

#[test]
fn it_is_the_same_every_time_and_stays_in_its_budget() {
    let lattice = lattice(&[9, 9, 9, 9]);
    let go = || {
        let mut search = Search::new(&lattice, &sampling(16, 10, Some(100)));
        let asked = run(&mut search, &Some::<u64>, |i| Some(zdt1(&lattice.digits(i), 9)));
        (asked, search.front())
    };
    let (asked, front) = go();
    assert_eq!(asked.len(), 100);
    assert_eq!((asked, front), go());
}

#[test]
fn what_is_left_out_costs_nothing_and_what_fails_is_no_parent() {
    let lattice = lattice(&[16, 16, 16]);
    let mut search = Search::new(&lattice, &sampling(12, 8, None));
    // Odd first digits are left out; the second half of the second axis fails.
    let allowed = |i: u64| (lattice.digits(i)[0].is_multiple_of(2)).then_some(i);
    let result = |i: u64| (lattice.digits(i)[1] < 8).then(|| zdt1(&lattice.digits(i), 16));
    let asked = run(&mut search, &allowed, result);
    assert!(asked.iter().all(|&i| lattice.digits(i)[0].is_multiple_of(2)));
    assert!(search.front().iter().all(|&i| lattice.digits(i)[1] < 8));
    assert!(!search.front().is_empty());
}

/// The cheapest half of the space misses the bound: the front is that of the other half.
#[test]
fn points_that_miss_a_bound_lose() {
    let lattice = lattice(&[16, 16]);
    let mut search = Search::new(&lattice, &sampling(16, 12, None));
    loop {
        let asked = search.ask(&Some::<u64>);
        if asked.is_empty() {
            break;
        }
        let told = |&i: &u64| {
            let digits = lattice.digits(i);
            let costs = digits.iter().map(|&d| f64::from(d)).collect();
            let miss = f64::from(8u32.saturating_sub(digits[0] + digits[1]));
            (i, Some(FrontTrial { costs, miss }))
        };
        search.tell(&asked.iter().map(told).collect::<Vec<_>>());
    }
    let sums = search.front().into_iter().map(|i| lattice.digits(i).iter().sum::<u32>());
    let sums: BTreeSet<u32> = sums.collect();
    assert_eq!(sums, BTreeSet::from([8]), "the least that keeps the bound");
}

#[test]
fn hopeless_answers_end_it() {
    let lattice = lattice(&[3, 3]);
    let mut search = Search::new(&lattice, &sampling(8, 50, None));
    assert_eq!(
        run(&mut search, &Some::<u64>, |_| None).len(),
        9,
        "a small space is asked for whole"
    );
    let mut search = Search::new(&lattice, &sampling(8, 50, None));
    assert!(run(&mut search, &|_| None, |_| None).is_empty());
    let mut search = Search::new(&lattice, &sampling(8, 3, None));
    let asked = run(&mut search, &Some::<u64>, |_| Some(vec![f64::NAN, 1.0]));
    assert!(asked.len() == 9 && search.front().is_empty(), "NaN is a failure");
}

fn points() -> impl Strategy<Value = Vec<(u64, FrontTrial)>> {
    let value = (0u8..6).prop_map(f64::from);
    // Half of the points keep the bound.
    let miss = prop_oneof![Just(0.0), (0u8..3).prop_map(f64::from)];
    let row = (prop::collection::vec(value, 3), miss);
    let row = row.prop_map(|(costs, miss)| FrontTrial { costs, miss });
    prop::collection::vec(row, 1..40)
        .prop_map(|rows| rows.into_iter().enumerate().map(|(i, r)| (i as u64, r)).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn ranks_are_those_of_brute_force(points in points()) {
        let ranked = Ranked::new(&points);
        let mut rest: BTreeSet<usize> = (0..points.len()).collect();
        let mut rank = 0;
        while !rest.is_empty() {
            let beaten = |&i: &usize| rest.iter().any(|&j| dominates(&points[j].1, &points[i].1));
            let free: Vec<usize> = rest.iter().copied().filter(|i| !beaten(i)).collect();
            for i in free {
                prop_assert_eq!(ranked.rank[i], rank);
                rest.remove(&i);
            }
            rank += 1;
        }
    }

    #[test]
    fn the_best_have_the_lowest_ranks(points in points(), n in 1usize..20) {
        let kept = best(&points, n);
        prop_assert_eq!(kept.len(), n.min(points.len()));
        let ranked = Ranked::new(&points);
        let worst = kept.iter().map(|&i| ranked.rank[i as usize]).max().unwrap_or(0);
        let lost = (0..points.len()).filter(|i| !kept.contains(&(*i as u64)));
        prop_assert!(lost.map(|i| ranked.rank[i]).all(|rank| rank >= worst));
    }
}
