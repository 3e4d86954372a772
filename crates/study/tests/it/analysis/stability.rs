//! Rank correlations, and what other prices and traces do to a ranking.

use powergs_study::analysis::stability::rank::{kendall, ranks, spearman};
use powergs_study::analysis::{Analysis, Objective, Question, Scope};
use proptest::collection::vec;
use proptest::prelude::*;

use super::support::Sweep;

fn naive_kendall(x: &[f64], y: &[f64]) -> Option<f64> {
    let (mut s, mut tx, mut ty) = (0.0, 0.0, 0.0);
    for i in 0..x.len() {
        for j in 0..i {
            let sign = |a: f64, b: f64| {
                if a > b {
                    1.0
                } else if a < b {
                    -1.0
                } else {
                    0.0
                }
            };
            let (a, b) = (sign(x[i], x[j]), sign(y[i], y[j]));
            (s, tx, ty) = (s + a * b, tx + a * a, ty + b * b);
        }
    }
    (tx * ty > 0.0).then(|| s / f64::sqrt(tx * ty))
}

proptest! {
    #[test]
    fn kendall_equals_all_pairs(pairs in vec((0..9_i32, 0..9_i32), 0..60)) {
        let x: Vec<f64> = pairs.iter().map(|p| f64::from(p.0)).collect();
        let y: Vec<f64> = pairs.iter().map(|p| f64::from(p.1)).collect();
        match (kendall(&x, &y), naive_kendall(&x, &y)) {
            (Some(a), Some(b)) => prop_assert!((a - b).abs() < 1e-12, "{a} {b}"),
            (a, b) => prop_assert_eq!(a, b),
        }
    }
}

#[test]
fn correlations_of_known_rankings() {
    let x = [1.0, 2.0, 3.0, 4.0, 5.0];
    assert_eq!(kendall(&x, &x), Some(1.0));
    assert_eq!(spearman(&x, &[5.0, 4.0, 3.0, 2.0, 1.0]), Some(-1.0));
    assert_eq!(kendall(&x, &[2.0; 5]), None);
    assert_eq!(spearman(&x, &[2.0; 5]), None);
    assert_eq!(ranks(&[3.0, 1.0, 3.0]), [2.5, 1.0, 2.5]);
    // One swap of neighbours among five: 1 - 2/10, and 1 - 6 * 2 / (5 * 24).
    let swapped = [1.0, 2.0, 4.0, 3.0, 5.0];
    assert!((kendall(&x, &swapped).expect("varies") - 0.8).abs() < 1e-12);
    assert!((spearman(&x, &swapped).expect("varies") - 0.9).abs() < 1e-12);
}

fn question() -> Question {
    Question::of(vec![
        Objective::minimize("energy_pj.mean"),
        Objective::minimize("area_mm2"),
        Objective::maximize("fps.mean"),
    ])
}

#[test]
fn alternatives_are_tables_then_scopes_then_traces() {
    let table = Sweep::default().table();
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    let labels: Vec<&str> =
        analysis.stability.alternatives.iter().map(|a| a.label.as_str()).collect();
    assert_eq!(labels, ["hbm2", "worst trace of each column", "garden", "room"]);
    let hbm = &analysis.stability.alternatives[0];
    assert_eq!(hbm.designs, 50);
    assert_eq!(hbm.objectives[1], Some(1.0), "the area does not know the table");
    assert_eq!(hbm.objectives[2], Some(1.0), "nor does the time");
    assert!(hbm.objectives[0].expect("varies") < 1.0, "the energy does");
    assert!(hbm.ranks.iter().all(|r| r.is_some_and(|r| (1..=50).contains(&r))));
}

/// Without a DRAM price the small buffer wins; with a high one the large does.
#[test]
fn the_winner_flips_with_the_price() {
    let sweep = Sweep {
        cores: vec![4],
        tests: vec!["obb"],
        tables: vec![("free", 0.0, 1.0), ("dear", 500.0, 1.0)],
        traces: vec![("garden", 1.0, 1.0)],
        baseline: false,
        ..Sweep::default()
    };
    let table = sweep.table();
    let question =
        Question::of(vec![Objective::minimize("energy_pj.mean"), Objective::minimize("area_mm2")]);
    let analysis = Analysis::of(&table, &question).expect("an answer");
    let [dear] = &analysis.stability.alternatives[..] else { panic!("one alternative") };
    let (here, there) = (dear.winner.expect("one"), dear.reference_winner.expect("one"));
    assert_eq!(table.points[analysis.knee as usize], table.points[there as usize]);
    assert!(table.points[here as usize] > table.points[there as usize], "a larger buffer");
    assert!(dear.kendall.expect("varies") < 1.0);
}

/// The same designs under equal prices: nothing moves.
#[test]
fn equal_alternatives_are_perfectly_stable() {
    let sweep = Sweep {
        tables: vec![("one", 10.0, 1.0), ("same", 10.0, 1.0)],
        traces: vec![("garden", 1.0, 1.0)],
        ..Sweep::default()
    };
    let table = sweep.table();
    let analysis = Analysis::of(&table, &question()).expect("an answer");
    let same = &analysis.stability.alternatives[0];
    assert_eq!((same.kendall, same.top_kept), (Some(1.0), 10));
    assert_eq!(same.spearman.map(|s| (s - 1.0).abs() < 1e-12), Some(true));
    assert_eq!((same.front_kept, same.front), (analysis.front.len(), analysis.front.len()));
    assert!(same.ranks.iter().copied().eq((1..=10).map(Some)));
    assert_eq!(
        same.winner.map(|r| table.points[r as usize]),
        same.reference_winner.map(|r| table.points[r as usize])
    );
    assert!(analysis.stability.membership.iter().all(|(_, n)| *n == 2));
}

#[test]
fn the_mean_is_an_alternative_of_a_trace() {
    let table = Sweep::default().table();
    let question = Question { scope: Scope::Trace("room".into()), ..question() };
    let analysis = Analysis::of(&table, &question).expect("an answer");
    let labels: Vec<&str> =
        analysis.stability.alternatives.iter().map(|a| a.label.as_str()).collect();
    assert_eq!(labels, ["hbm2", "mean of traces", "worst trace of each column", "garden"]);
}
