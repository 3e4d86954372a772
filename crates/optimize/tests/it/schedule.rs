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
                total_w,
                passed,
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

/// Runs a plan; a ratio passes up to `highest`, and the total is least at `best`.
fn run(plan: &Schedule, highest: f64, best: f64) -> Vec<(f64, Option<usize>)> {
    let (mut done, mut taken) = (Vec::new(), Vec::new());
    while let Some(sample) = plan.next(&done, 2.0) {
        let total_w = 1.0 + (sample.rho - best).powi(2);
        done.push(TakenSample { rho: sample.rho, total_w, passed: sample.rho <= highest });
        taken.push((sample.rho, sample.from));
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
fn five_samples_go_up_to_the_highest_ratio() {
    let plan = Schedule::Adaptive { count: 5, highest: 0.8 };
    let all = [(0.0, None), (0.2, Some(0)), (0.4, Some(1)), (0.6, Some(2)), (0.8, Some(3))];
    check(&run(&plan, 1.0, 0.5), &all);
}

#[test]
fn after_a_miss_the_budget_goes_below_it() {
    let plan = Schedule::Adaptive { count: 5, highest: 0.8 };
    // 0.4 misses; two samples are left for the gap from 0.2: a third, then half of what is left.
    let want = [(0.0, None), (0.2, Some(0)), (0.4, Some(1)), (0.8 / 3.0, Some(1))];
    let got = run(&plan, 0.3, 0.1);
    check(&got[..4], &want);
    assert!(got[4].0 > 0.8 / 3.0 && got[4].0 < 0.4, "{got:?}");
    // Not even the unpruned model passes: there is nothing to sample.
    check(&run(&plan, -1.0, 0.1), &[(0.0, None)]);
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
