//! Which ratios are sampled.

use powergs_optimize::schedule::{
    COARSE_STEP, Fine, Schedule, TakenSample, best_of, coarse_iterations, smoothed,
};
use serde_json::Value;

fn vectors() -> Value {
    serde_json::from_str(include_str!(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../tests/data/schedules.json"
    )))
    .unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn smoothing_and_fine_samples_are_the_published_ones() {
    for case in vectors()["smooth_filter"].as_array().unwrap() {
        let powers = numbers(&case["powers"]);
        let passes: Vec<bool> =
            case["passes"].as_array().unwrap().iter().map(|p| p.as_bool().unwrap()).collect();
        let smooth = smoothed(&powers, &passes);
        for (got, want) in smooth.iter().zip(numbers(&case["filtered"])) {
            assert!((got - want).abs() < 1e-12, "{got} is not {want}");
        }
        let samples: Vec<TakenSample> = powers
            .iter()
            .zip(&passes)
            .enumerate()
            .map(|(i, (&total_w, &passed))| TakenSample {
                rho: COARSE_STEP * i as f64,
                display_w: 0.0,
                render_w: total_w,
                passed,
                is_end: false,
            })
            .collect();
        let best = best_of(&samples);
        assert_eq!(best as u64, case["min_idx"].as_u64().unwrap());
        let fine = Fine::around(best, COARSE_STEP);
        assert_eq!(fine.start as u64, case["start_idx"].as_u64().unwrap());
        assert!((fine.step - case["fine_step"].as_f64().unwrap()).abs() < 1e-12);
        for (got, want) in fine.ratios.iter().zip(numbers(&case["fine_ratios"])) {
            assert!((got - want).abs() < 1e-12, "{got} is not {want}");
        }
    }
}

#[test]
fn coarse_budgets_are_the_published_ones() {
    for (key, budget) in [("coarse_iterations_L1", 10_000), ("coarse_iterations_L2plus", 5_000)] {
        let expected = numbers(&vectors()[key]);
        let got: Vec<f64> = (0..7).map(|i| f64::from(coarse_iterations(i, budget))).collect();
        assert_eq!(got, expected, "{key}");
    }
}

/// Runs a plan; a ratio passes up to `highest`, as far as its end comes, and the total is least at
/// `best`.
fn run(plan: &Schedule, highest: f64, best: f64) -> Vec<(f64, Option<usize>)> {
    let (mut done, mut taken) = (Vec::new(), Vec::new());
    while let Some(sample) = plan.next(&done, 2.0) {
        let rho = if sample.is_end { highest } else { sample.rho };
        // Display power rises and rendering power falls, both convex.
        let (display_w, render_w) = (1.0 + (rho - best).powi(2) + rho, 2.0 - rho);
        let is_end = sample.is_end;
        done.push(TakenSample { rho, display_w, render_w, passed: rho <= highest, is_end });
        taken.push((sample.rho, sample.from));
        assert!(taken.len() < 100, "no end");
    }
    taken
}

#[track_caller]
fn check(got: &[(f64, Option<usize>)], want: &[(f64, Option<usize>)]) {
    assert_eq!(got.len(), want.len(), "{got:?}");
    for (g, w) in got.iter().zip(want) {
        assert!((g.0 - w.0).abs() < 1e-9 && g.1 == w.1, "{got:?} is not {want:?}");
    }
}

#[test]
fn five_samples_are_both_ends_and_then_around_the_minimum() {
    let got = run(&Schedule::FIVE, 0.7, 0.45);
    check(&got[..3], &[(0.0, None), (0.15, Some(0)), (0.15, Some(1))]);
    assert_eq!(got.len(), 5);
    for (rho, from) in &got[3..] {
        assert!((0.15..0.7).contains(rho) && *from >= Some(1), "{got:?}");
    }
    // From the nearest one below.
    assert_eq!(got[3].1, Some(1));
}

#[test]
fn a_miss_is_tried_again_before_its_ratio_is_given_up() {
    // 0.15 misses twice; the end starts from what passed.
    let want = [(0.0, None), (0.15, Some(0)), (0.15, Some(1)), (0.0, Some(0))];
    check(&run(&Schedule::FIVE, 0.1, 0.05)[..4], &want);
    // Not even the unpruned model passes, with twice the iterations: there is nothing to sample.
    check(&run(&Schedule::FIVE, -1.0, 0.1), &[(0.0, None), (0.0, Some(0))]);
}

#[test]
fn in_the_periphery_the_pruned_end_follows_the_unpruned_one_from_where_the_search_starts() {
    let (upper, share) = Schedule::FIVE.upper(0.5);
    assert_eq!((upper.count(), share), (4, 0.5), "its longer end counts as two");
    assert_eq!(upper.most_effort(1.0), Schedule::FIVE.most_effort(1.0));
    // The display counts: what is unpruned is the cheapest, and half way to it is looked at.
    let got = run(&upper, 0.3, -0.5);
    check(&got, &[(0.0, None), (0.0, None), (0.15, Some(0)), (0.075, Some(0))]);
    // Where nothing unpruned reaches the target in few iterations, many without a display term may.
    let (mut done, mut efforts) = (Vec::new(), Vec::new());
    while let Some(sample) = upper.next(&done, 1.0) {
        let (rho, passed) = (if sample.is_end { 0.2 } else { 0.0 }, sample.is_end);
        let (display_w, render_w) = (0.1, 1.0 - rho);
        done.push(TakenSample { rho, display_w, render_w, passed, is_end: sample.is_end });
        efforts.push((sample.effort, sample.from, sample.is_end));
    }
    let want = [(0.5, None, false), (0.5, Some(0), false), (4.5, None, true)];
    assert_eq!(efforts, want);
}

#[test]
fn the_published_plan_is_coarse_then_fine() {
    let got = run(&Schedule::PUBLISHED, 1.0, 0.47);
    assert_eq!(got.len(), 12);
    let coarse: Vec<_> =
        (0..7).map(|i| (0.15 * f64::from(i), (i as usize).checked_sub(1))).collect();
    check(&got[..7], &coarse);
    // The best is 0.45, so the fine ones begin at 0.30; beyond 0.45 they start from that.
    let fine =
        [(0.35, Some(2)), (0.40, Some(2)), (0.45, Some(2)), (0.50, Some(3)), (0.55, Some(3))];
    check(&got[7..], &fine);
}

#[test]
fn listed_ratios_are_taken_as_they_are() {
    let plan = Schedule::Listed(vec![0.1, 0.5]);
    check(&run(&plan, 0.2, 0.0), &[(0.1, None), (0.5, Some(0))]);
}
