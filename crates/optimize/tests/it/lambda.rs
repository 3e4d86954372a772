//! The controller on plants that are known in closed form.

use powergs_optimize::lambda::{Control, Controller, FLOOR, Rule, Verdict};
use powergs_optimize::target::{Quality, Target};
use serde_json::Value;

const TARGET: Target = Target::Likeness(Quality::likeness(35.0, 0.0));

fn control(rule: Rule, start: f64, adjust: u32) -> Control {
    Control { rule, start, interval: 10, adjust, epsilon_db: 0.05 }
}

/// What a model at rest has with this λ: 45 dB without, 20 dB less per decade beyond 0.1.
fn at_rest(lambda: f64) -> f64 {
    45.0 - 20.0 * (1.0 + lambda / 0.1).log10()
}

/// λ at which the model at rest is on the target.
fn solution() -> f64 {
    0.1 * (10f64.powf(10.0 / 20.0) - 1.0)
}

/// Runs a plant that follows its resting value with a delay, and returns the controller and the
/// worst quality over the last tenth.
fn run(rule: Rule, start: f64, iterations: u32, delay: f64) -> (Controller, f64) {
    let adjust = iterations * 3 / 4;
    let mut controller = Controller::new(control(rule, start, adjust));
    let (mut quality, mut worst) = (45.0, f64::INFINITY);
    for iteration in 0..iterations {
        quality += (at_rest(controller.lambda()) - quality) / delay;
        if controller.is_due(iteration) {
            let seen = Quality::likeness(quality, 1.0);
            // It goes on after it has settled, so that resting is seen too.
            controller.observe(iteration, seen, &TARGET);
        }
        if iteration >= iterations * 9 / 10 {
            worst = worst.min(quality);
        }
    }
    (controller, worst)
}

#[test]
fn both_rules_find_the_target_of_a_prompt_plant() {
    for rule in [Rule::Published, Rule::Damped] {
        for start in [1e-4, 1e-2, 10.0] {
            let (controller, worst) = run(rule, start, 2000, 1.0);
            let off = controller.lambda() / solution();
            // The last steps of the cosine are below 1 %, and what passed is on the safe side.
            assert!((0.98..=1.0).contains(&off), "{rule:?} from {start}: {off}");
            assert!(worst >= 35.0, "{rule:?} from {start}: rests at {worst} dB");
        }
    }
}

#[test]
fn the_damped_rule_rests_on_the_target_of_a_slow_plant() {
    for (iterations, delay) in [(200, 25.0), (400, 40.0), (1000, 60.0)] {
        let (controller, worst) = run(Rule::Damped, 0.01, iterations, delay);
        let rest = at_rest(controller.lambda());
        // The same rule evaluated elsewhere rests 0.02 to 0.04 dB above the target.
        assert!((35.0..35.2).contains(&rest), "{iterations}, {delay}: λ rests at {rest} dB");
        assert!(worst >= 35.0, "{iterations}, {delay}: {worst} dB");
    }
}

#[test]
fn the_damped_rule_overshoots_less_than_the_published_one() {
    let lowest = |rule| {
        let mut controller = Controller::new(control(rule, 0.01, 300));
        let (mut quality, mut lowest) = (45.0f64, f64::INFINITY);
        for iteration in 0..300 {
            quality += (at_rest(controller.lambda()) - quality) / 40.0;
            lowest = lowest.min(quality);
            if controller.is_due(iteration) {
                controller.observe(iteration, Quality::likeness(quality, 1.0), &TARGET);
            }
        }
        lowest
    };
    let (damped, published) = (lowest(Rule::Damped), lowest(Rule::Published));
    assert!(damped > 34.5 && published < damped - 1.5, "{damped} and {published} dB");
}

#[test]
fn a_failed_fine_tune_is_no_trap() {
    for rule in [Rule::Published, Rule::Damped] {
        let mut failed = Controller::new(control(rule, 1e-3, 900));
        for iteration in (0..1000).step_by(10) {
            failed.observe(iteration, Quality::likeness(10.0, 1.0), &TARGET);
            assert!(failed.lambda() >= FLOOR, "{rule:?}: λ {}", failed.lambda());
        }
        assert_eq!(failed.passing(), None);
        let (recovered, _) = run(rule, 1e-3, 2000, 1.0);
        assert!(recovered.lambda() > 0.1, "{rule:?}: λ stays at {}", recovered.lambda());
    }
}

#[test]
fn it_stops_when_the_quality_has_settled_just_above_the_target() {
    let settings = Control { epsilon_db: 0.1, ..control(Rule::Damped, 1e-2, 1000) };
    let mut controller = Controller::new(settings);
    let mut hear =
        |i: u32, psnr_db| controller.observe(i, Quality::likeness(psnr_db, 1.0), &TARGET);
    assert_eq!(hear(0, 35.05), Verdict::Continue);
    assert_eq!(hear(10, 35.09), Verdict::Continue);
    assert_eq!(hear(20, 35.20), Verdict::Continue, "too far above");
    assert_eq!(hear(30, 35.05), Verdict::Continue);
    assert_eq!(hear(40, 34.99), Verdict::Continue, "below");
    assert_eq!(hear(50, 35.01), Verdict::Continue);
    assert_eq!(hear(60, 35.02), Verdict::Continue);
    assert_eq!(hear(70, 35.00), Verdict::Settled);
}

#[test]
fn both_numbers_must_pass_and_the_nearer_one_counts() {
    let target = Target::Likeness(Quality::likeness(35.0, 0.95));
    let of = |psnr_db, ssim| Quality::likeness(psnr_db, ssim);
    assert!(target.passes(of(35.0, 0.95)));
    assert!(!target.passes(of(34.9, 0.99)) && !target.passes(of(50.0, 0.949)));
    assert!(!target.passes(of(f64::NAN, 0.99)) && !target.passes(of(40.0, f64::NAN)));
    assert!((target.margin_db(of(37.0, 0.99)) - 2.0).abs() < 1e-12);
    // Half the structural error is 3 dB.
    assert!((target.margin_db(of(60.0, 0.975)) - 3.0103).abs() < 1e-3);
    let short = target.shortfall(of(34.5, 0.99));
    assert!((short.psnr_db - 0.5).abs() < 1e-12 && short.ssim == 0.0);
}

#[test]
fn published_traces_are_reproduced() {
    let text =
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/schedules.json"));
    let vectors: Value = serde_json::from_str(text).unwrap();
    for case in vectors["lambda_schedule"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64().unwrap();
        let adjust = number("adjust_iters") as u32;
        let mut controller = Controller::new(Control {
            interval: number("interval") as u32,
            ..control(Rule::Published, number("lambda0"), adjust)
        });
        for check in case["checks"].as_array().unwrap() {
            let iteration = check["counter"].as_u64().unwrap() as u32;
            let psnr_db = if check["passed"].as_bool().unwrap() { 40.0 } else { 30.0 };
            assert!(controller.is_due(iteration));
            controller.observe(iteration, Quality::likeness(psnr_db, 1.0), &TARGET);
            let expected = check["lam"].as_f64().unwrap();
            let off = (controller.lambda() / expected - 1.0).abs();
            assert!(off < 1e-12, "{iteration}: {} is not {expected}", controller.lambda());
        }
        controller.observe(adjust, Quality::likeness(40.0, 1.0), &TARGET);
        let expected = number("final_lambda");
        assert!((controller.lambda() / expected - 1.0).abs() < 1e-12);
    }
}
