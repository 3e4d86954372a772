//! What a campaign would take: parts that add up, by a clock of our own.

use std::cell::Cell;

use powergs_optimize::estimate::Estimate;
use powergs_optimize::request::{Goals, Request};
use powergs_optimize::role::Baseline;

use super::campaign::{open, request};

/// The estimate of a request by a clock that goes on a second whenever it is looked at.
fn estimated(change: impl Fn(&mut Request)) -> Estimate {
    let mut request = request();
    request.goals.baselines.clear();
    request.goals.ratio_study = false;
    change(&mut request);
    let seconds = Cell::new(0.0);
    let clock = || {
        seconds.set(seconds.get() + 1.0);
        seconds.get()
    };
    let estimate = open(request).estimate(&clock, &()).unwrap();
    estimate.expect("it was not cancelled")
}

#[test]
fn the_parts_of_the_time_are_what_one_takes_times_how_often_it_is_done() {
    let seen = estimated(|_| ());
    assert_eq!(seen.jobs[..4], ["dense", "sample-01", "sample-02", "sample-03"]);
    let time = seen.time;
    assert_eq!(time.models_s, seen.model_s * seen.jobs.len() as f64);
    let iterations_s = seen.iteration_s * seen.iterations as f64;
    assert!((time.iterations_s - iterations_s).abs() < 1e-9, "{time:?}");
    // Four steps of a twentieth for each fifth that goes.
    let prunes = time.scores_s / seen.score_s;
    assert!(prunes >= 8.0 && prunes.fract() < 1e-9, "{prunes} prunes");
    assert!(time.checks_s > 0.0);
    let sum = time.iterations_s + time.checks_s + time.scores_s + time.models_s;
    assert!((time.total_s() - sum).abs() < 1e-9);
    // Pruning whenever it passes scores at each check what is left: a twentieth of that less every
    // time.
    let more = estimated(|r| {
        r.goals = Goals { baselines: vec![Baseline::RenderOnly], ..r.goals.clone() };
    });
    let scored = more.time.scores_s / more.score_s - prunes;
    let (mut left, mut sum): (f64, f64) = (1.0, 0.0);
    while sum < scored - 1e-9 && left > 0.01 {
        sum += left;
        left *= 0.95;
    }
    assert!((sum - scored).abs() < 1e-6 && left <= 0.86, "{scored} dense models");
}

#[test]
fn memory_grows_with_the_threads_and_the_model() {
    let on = |threads: usize, copies: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let grow = |r: &mut Request| {
            let dense = r.dense.clone();
            for _ in 1..copies {
                r.dense.means.extend(&dense.means);
                r.dense.log_scales.extend(&dense.log_scales);
                r.dense.rotations.extend(&dense.rotations);
                r.dense.logit_opacities.extend(&dense.logit_opacities);
                r.dense.sh.extend(&dense.sh);
            }
        };
        pool.install(|| estimated(grow)).memory_b
    };
    let parameters = 200 * 59 * 4;
    // In training there are nine times the parameters, whatever the threads.
    assert_eq!(on(1, 2) - on(1, 1), 9 * parameters);
    // With many threads a frame for each is measured at a time.
    assert_eq!(on(8, 2) - on(8, 1), 12 * parameters);
    assert!(on(2, 1) > on(1, 1));
}
