//! The front equals brute force; the knee is where its definition says.

use powergs_study::analysis::distance::distance;
use powergs_study::analysis::front::{Costs, dominates, front};
use powergs_study::analysis::knee::{KneeScaling, ends, knee};
use proptest::collection::vec;
use proptest::prelude::*;

fn costs(k: usize, rows: &[Vec<f64>]) -> Costs {
    let mut costs = Costs::new(k);
    rows.iter().for_each(|row| costs.push(&row[..k]));
    costs
}

fn brute(costs: &Costs) -> Vec<usize> {
    let finite = |i: usize| costs.of(i).iter().all(|c| c.is_finite());
    let beaten = |i: usize| (0..costs.len()).any(|j| dominates(costs.of(j), costs.of(i)));
    (0..costs.len()).filter(|&i| finite(i) && !beaten(i)).collect()
}

/// Few different values make ties and duplicates; some values are no numbers.
fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (0..6_i32).prop_map(f64::from),
        8 => -1.0..1.0_f64,
        1 => Just(-0.0),
        1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn equals_brute_force(k in 1_usize..=5, rows in vec(vec(value(), 5), 0..160)) {
        let costs = costs(k, &rows);
        prop_assert_eq!(front(&costs), brute(&costs));
    }
}

/// Large enough for every branch of the recursion, on few values so that it ties.
#[test]
fn equals_brute_force_on_thousands() {
    for k in 1..=6 {
        for levels in [3_u64, 12, 1 << 20] {
            let mut state = 7_u64;
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                ((state >> 33) % levels) as f64
            };
            let rows: Vec<Vec<f64>> = (0..1500).map(|_| (0..k).map(|_| next()).collect()).collect();
            let costs = costs(k, &rows);
            assert_eq!(front(&costs), brute(&costs), "{k} objectives, {levels} levels");
        }
    }
}

/// Nobody beats anybody: quadratic algorithms would take minutes here.
#[test]
fn a_hundred_thousand_designs_all_on_the_front() {
    let n = 100_000_u64;
    let mut costs = Costs::new(3);
    for i in 0..n {
        let (x, y) = ((i % 317) as f64, (i / 317) as f64);
        costs.push(&[x, y, -(x + y)]);
    }
    assert_eq!(front(&costs).len(), n as usize);
}

#[test]
fn equal_designs_stand_or_fall_together() {
    let both = [[1.0, 1.0], [2.0, 2.0], [1.0, 1.0], [2.0, 2.0]].map(Vec::from);
    assert_eq!(front(&costs(2, &both)), [0, 2]);
    assert!(front(&Costs::new(3)).is_empty());
}

#[test]
fn the_knee_is_farthest_from_the_line_between_the_ends() {
    let rows = [[0.0, 10.0], [1.0, 4.0], [2.0, 3.5], [6.0, 1.0], [10.0, 0.0], [9.0, 9.0]];
    let costs = costs(2, &rows.map(Vec::from));
    let members = front(&costs);
    let scaling = KneeScaling::of(&costs, &members);
    // The line x + y = 10: the farthest below it is (1, 4).
    assert_eq!(knee(&costs, &members, &scaling), Some(1));
    assert_eq!(ends(&costs, &members, &scaling), [0, 4]);
    assert_eq!(scaling.merit(&[1.0, 4.0]), 0.25);
}

/// An objective that is equal on the front still ranks the designs off it.
#[test]
fn a_front_of_one_design_scales_by_all() {
    let costs = costs(2, &[[1.0, 1.0], [3.0, 1.0], [2.0, 1.0]].map(Vec::from));
    let members = front(&costs);
    let scaling = KneeScaling::of(&costs, &members);
    assert_eq!((members.as_slice(), scaling.range.as_slice()), (&[0][..], &[2.0, 0.0][..]));
    assert_eq!([0, 1, 2].map(|d| scaling.merit(costs.of(d))), [0.0, 1.0, 0.5]);
}

#[test]
fn the_distance_names_the_nearest_design_that_beats() {
    let rows = [[0.0, 10.0], [4.0, 4.0], [10.0, 0.0]].map(Vec::from);
    let costs = costs(2, &rows);
    let members = front(&costs);
    let scaling = KneeScaling::of(&costs, &members);
    let from = distance(&costs, &members, &scaling, &[5.0, 6.0], 0.0);
    let nearest = from.nearest.expect("(4, 4) beats it");
    assert_eq!((nearest.design, nearest.gains.as_slice()), (1, &[1.0, 2.0][..]));
    assert!((nearest.distance - 0.05_f64.sqrt()).abs() < 1e-12, "(0.1, 0.2) of the ranges");
    assert!(distance(&costs, &members, &scaling, &[4.0, 4.0], 0.0).nearest.is_none());
    assert!(distance(&costs, &members, &scaling, &[-1.0, 6.0], 0.0).best.is_empty());
}
