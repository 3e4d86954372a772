//! From samples to the optimum, to the best model, to savings over ratios.

use powergs_optimize::conclusion::conclude;
use powergs_optimize::job::{Job, Place};
use powergs_optimize::oracle::OracleWatts;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::plan::{Plan, Variant};
use powergs_optimize::ratio_study::{RATIOS, ratios};
use powergs_optimize::role::{Baseline, Role};
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::Settings;
use powergs_optimize::setup::Seen;
use powergs_optimize::target::{Quality, Target, TargetRule};
use powergs_optimize::tune::{DisplayTerm, Pruning};

use super::scenes::tiny;

const LIKENESS: Quality = Quality::likeness(35.0, 0.9);
const TARGET: Target = Target::Likeness(LIKENESS);

fn outcome(name: &str, role: Role, rho: f64, (display_w, render_w): (f64, f64)) -> Outcome {
    let quality = Quality::likeness(35.1, 0.95);
    let seen = Seen { quality, display_w };
    Outcome {
        name: name.into(),
        role,
        place: Place::default(),
        rho,
        points: 100,
        iterations: 10,
        kept_at: Some(9),
        lambda: Some(0.1),
        passing_lambda: Some(0.2),
        gains: None,
        is_end: false,
        gate: seen,
        confirmation: None,
        error_db: [None; 2],
        passed: true,
        test: seen,
        flip_test: 0.0,
        lpips_test: None,
        watts: OracleWatts { render_w, display_w, ..OracleWatts::default() },
    }
}

/// Samples of convex curves with their minimum inside, and a dense model.
fn samples() -> Vec<Outcome> {
    let mut done = vec![outcome("dense", Role::Dense, 0.0, (0.5, 1.0))];
    for i in 0..5 {
        let rho = 0.2 * f64::from(i);
        let (u, x) = (rho / 0.8, 1.0 - rho / 0.8);
        let display = 0.5 - 0.2 * 1.3 * x / (0.3 + x);
        let render = 0.9 - 0.5 * 1.5 * u / (0.5 + u);
        done.push(outcome(&format!("sample-{i}"), Role::Sample, rho, (display, render)));
    }
    done
}

#[test]
fn the_fit_finds_the_minimum_and_promises_what_the_curves_say() {
    let conclusion = conclude(&samples(), Some(TARGET), None);
    assert_eq!(conclusion.passed, 5);
    let rho = conclusion.rho.unwrap();
    let total = |u: f64| {
        let x = 1.0 - u;
        1.4 - 0.26 * x / (0.3 + x) - 0.75 * u / (0.5 + u)
    };
    let least = (0..=1000).map(|i| total(f64::from(i) / 1000.0)).fold(f64::INFINITY, f64::min);
    let promised = conclusion.predicted().unwrap().total_w();
    assert!((promised - least).abs() < 1e-4, "{promised} W promised, {least} W there");
    assert!((total(rho / 0.8) - least).abs() < 1e-4);
}

#[test]
fn a_minimum_that_a_sample_contradicts_is_looked_for_between_it_and_the_best() {
    // The demonstration at a ratio of 2: slack is used up between the last two samples, so that the
    // curve of the display is a step at the last one, and its minimum just before.
    let all = [
        (0.0, 4.346, 2.489),
        (0.3, 4.299, 1.899),
        (0.566, 4.301, 1.321),
        (0.699, 4.314, 1.018),
        (0.832, 4.917, 0.708),
    ];
    let sample = |(i, &(rho, d, r)): (usize, &(f64, f64, f64))| {
        outcome(&format!("sample-{i}"), Role::Sample, rho, (d, r))
    };
    let mut done: Vec<Outcome> = all.iter().enumerate().map(sample).collect();
    let conclusion = conclude(&done, Some(TARGET), None);
    assert!((conclusion.optimum.unwrap().rho - 0.832).abs() < 0.02, "{:?}", conclusion.optimum);
    assert!((conclusion.rho.unwrap() - 0.7655).abs() < 1e-9, "{:?}", conclusion.rho);
    // The last sample is the best: nothing contradicts.
    done[4].watts.display_w = 4.5;
    let conclusion = conclude(&done, Some(TARGET), None);
    assert!((conclusion.rho.unwrap() - 0.832).abs() < 0.02, "{:?}", conclusion.rho);
}

#[test]
fn the_result_is_never_worse_than_an_end_of_the_search() {
    // Whatever the curve is like: the display end, the rendering end, or something between.
    for (display, render) in [(0.1, 0.9), (0.9, 0.1), (0.5, 0.5)] {
        let mut done = samples();
        done[1].watts = OracleWatts { display_w: display, render_w: 0.4, ..OracleWatts::default() };
        let last = done.last_mut().unwrap();
        (last.lambda, last.watts) =
            (None, OracleWatts { display_w: 0.4, render_w: render, ..OracleWatts::default() });
        let best = conclude(&done, Some(TARGET), None).best.unwrap();
        let watts = |name: &str| done.iter().find(|o| o.name == name).unwrap().watts.total_w();
        assert!(watts(&best) <= watts("sample-0") && watts(&best) <= watts("sample-4"));
    }
}

#[test]
fn samples_that_missed_are_named_with_their_distance() {
    let mut done = samples();
    for i in [4, 5] {
        done[i].passed = false;
        done[i].gate.quality.psnr_db = 33.0;
    }
    let conclusion = conclude(&done, Some(TARGET), None);
    assert_eq!((conclusion.passed, conclusion.missed.len()), (3, 2));
    assert_eq!(conclusion.missed[0].name, "sample-3");
    assert!((conclusion.missed[0].by.psnr_db - 2.0).abs() < 1e-12);
    // Nothing beyond the last ratio that passed is promised.
    assert!(conclusion.rho.unwrap() <= 0.4 + 1e-12);
    for o in &mut done[1..] {
        o.passed = false;
        o.gate.quality.psnr_db = 20.0;
    }
    let conclusion = conclude(&done, Some(TARGET), None);
    assert!(conclusion.rho.is_none() && conclusion.best.is_none() && conclusion.fit.is_err());
}

#[test]
fn the_best_model_is_the_cheapest_that_passes_the_final_one_or_a_sample() {
    let mut done = samples();
    done.push(outcome("optimum", Role::Optimum, 0.35, (0.3, 0.4)));
    assert_eq!(conclude(&done, Some(TARGET), None).best.as_deref(), Some("optimum"));
    done.last_mut().unwrap().passed = false;
    let best = conclude(&done, Some(TARGET), None).best.unwrap();
    assert!(best.starts_with("sample-"), "{best}");
    // A baseline is never ours, however cheap.
    done.push(outcome("render-only", Role::Baseline(Baseline::RenderOnly), 0.5, (0.1, 0.1)));
    assert_eq!(conclude(&done, Some(TARGET), None).best.unwrap(), best);
    // But it is what the run ends with, if it passes.
    let plan = plan(Vec::new());
    assert_eq!(plan.result(&done, 0).unwrap().name, "render-only");
    done.last_mut().unwrap().passed = false;
    assert_eq!(plan.result(&done, 0).unwrap().name, best);
    done.last_mut().unwrap().passed = true;
    done.last_mut().unwrap().watts.display_w = 9.0;
    assert_eq!(plan.result(&done, 0).unwrap().name, best);
}

#[test]
fn savings_over_ratios_have_the_published_signs() {
    let mut done = samples();
    done.push(outcome("render-only", Role::Baseline(Baseline::RenderOnly), 0.8, (0.5, 0.39)));
    done.push(outcome("display-only", Role::Baseline(Baseline::DisplayOnly), 0.0, (0.3, 0.9)));
    let rows = ratios(&done);
    assert_eq!(rows.len(), 13);
    assert!((rows[0].ratio - RATIOS.0).abs() < 1e-12 && (rows[12].ratio - RATIOS.1).abs() < 1e-12);
    let first =
        |of: fn(&powergs_optimize::ratio_study::RatioRow) -> f64| (of(&rows[0]), of(&rows[12]));
    let (low, high) = first(|r| r.over_render_only.unwrap());
    assert!(high > low, "the more the panel draws, the more we save over render-only");
    let (low, high) = first(|r| r.over_display_only.unwrap());
    assert!(high < low, "and the less over display-only");
    assert!(rows.windows(2).all(|w| w[1].rho <= w[0].rho + 1e-9), "less is pruned");
}

/// A plan of five samples for one quality.
fn plan(baselines: Vec<Baseline>) -> Plan {
    Plan {
        schedule: Schedule::FIVE,
        baselines,
        externals: Vec::new(),
        sweep_weights: Vec::new(),
        variants: vec![Variant { name: "H".into(), rule: TargetRule::Absolute(LIKENESS) }],
        holds_out: false,
        reference: None,
        given: None,
        levels: 1,
    }
}

/// The jobs of a campaign in which everything passes.
fn jobs(campaign: &Plan) -> Vec<Job> {
    let settings = tiny(10, 24, (16, 12)).settings;
    let (mut done, mut jobs) = (Vec::new(), Vec::new());
    while let Some(job) = campaign.next(&settings, 1000, &done) {
        let watts = (0.4 + 0.1 * job.rho, 1.0 - 0.5 * job.rho);
        let mut made = outcome(&job.name, job.role, job.rho, watts);
        let is_pruned =
            job.config.is_some_and(|c| matches!(c.pruning, Pruning::WhilePassing { .. }));
        made.is_end = job.is_end;
        made.rho = if is_pruned { 0.7 } else { made.rho };
        done.push(made);
        jobs.push(job);
        assert!(jobs.len() < 100, "no end");
    }
    jobs
}

#[test]
fn a_campaign_measures_samples_realises_and_compares() {
    let campaign = Plan {
        externals: vec!["mini".into()],
        sweep_weights: vec![0.1],
        ..plan(Baseline::ALL.to_vec())
    };
    let jobs = jobs(&campaign);
    let names: Vec<&str> = jobs.iter().map(|j| j.name.as_str()).collect();
    let expected = [
        "dense",
        "sample-01",
        "sample-02",
        "sample-03",
        "sample-04",
        "sample-05",
        "optimum",
        "display-only",
        "render-only",
        "two-stage",
        "lightgs-66",
        "lightgs-76",
        "lightgs-86",
        "mini",
        "lambda-0.1",
    ];
    assert_eq!(names, expected);
    assert_eq!(jobs[2].from.as_deref(), Some("sample-01"));
    // The search holds its own two ends: what pruning alone and what the display alone can save.
    let config = |i: usize| jobs[i].config.unwrap();
    assert_eq!((jobs[1].rho, config(1).pruning), (0.0, Pruning::Never));
    assert_eq!(config(1).display, DisplayTerm::Gains { from: 0 });
    assert_eq!(config(3).display, DisplayTerm::Gains { from: config(3).iterations });
    assert!(matches!(config(3).pruning, Pruning::WhilePassing { .. }) && jobs[3].is_end);
    // Pruned samples recover.
    let DisplayTerm::Gains { from } = config(4).display else { panic!("no gains") };
    let Pruning::Steps { steps, every, .. } = config(4).pruning else { panic!("not pruned") };
    assert!(from > every * (steps.get() - 1), "{from}, {steps} steps, one in {every}");
    assert_eq!(jobs[9].from.as_deref(), Some("render-only"));
    let settings = tiny(10, 24, (16, 12)).settings;
    let iterations: u64 =
        jobs.iter().filter_map(|j| j.config).map(|o| u64::from(o.iterations)).sum();
    assert_eq!(iterations, campaign.most_iterations(&settings));
}

#[test]
fn a_share_is_one_of_what_the_dense_model_reaches_without_the_gate_views() {
    let campaign = Plan {
        schedule: Schedule::Listed(vec![0.0, 0.3]),
        baselines: vec![Baseline::RenderOnly, Baseline::TwoStage],
        externals: Vec::new(),
        sweep_weights: vec![0.1],
        variants: vec![Variant { name: "H".into(), rule: TargetRule::Share(0.5) }],
        holds_out: true,
        reference: None,
        given: None,
        levels: 1,
    };
    let all = jobs(&campaign);
    let names: Vec<&str> = all.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names[..3], ["dense", "held-out", "sample-01"]);
    assert!(all[1].config.is_some() && all[1].from.is_none());
    // A share is the same quality, however long the search is.
    let dense = [outcome("dense", Role::Dense, 0.0, (0.5, 1.0))];
    for iterations in [12, 1_000] {
        let settings = Settings { iterations, ..Settings::DEFAULT };
        let job = campaign.next(&settings, 300, &dense).unwrap();
        assert_eq!(job.config.map(|c| (job.name, c.iterations)), Some(("held-out".into(), 1_000)));
    }
    for (name, from) in [
        ("sample-01", "held-out"),
        ("sample-02", "sample-01"),
        ("optimum", "held-out"),
        ("render-only", "held-out"),
        ("two-stage", "render-only"),
        ("lambda-0.1", "held-out"),
    ] {
        let job = all.iter().find(|j| j.name == name).unwrap();
        assert_eq!(job.from.as_deref(), Some(from), "{name}");
    }
    let mut held_out = outcome("held-out", Role::HeldOut, 0.0, (0.5, 1.0));
    held_out.gate.quality = Quality::likeness(30.0, 0.9);
    let done = [outcome("dense", Role::Dense, 0.0, (0.5, 1.0)), held_out];
    assert_eq!(campaign.target(&done[..1], 0), None, "not before it is there");
    let expected = Target::Likeness(Quality::likeness(15.0, 0.45));
    assert_eq!(campaign.target(&done, 0), Some(expected));
}

#[test]
fn kept_samples_take_no_more_room_than_four_dense_ones_and_the_result_is_among_them() {
    let campaign = Plan { holds_out: true, ..plan(Vec::new()) };
    let held_out = outcome("held-out", Role::HeldOut, 0.0, (0.5, 1.0));
    let mut done = vec![outcome("dense", Role::Dense, 0.0, (0.5, 1.0)), held_out];
    // All that is made lies near to no pruning at all, the cheapest is the largest but one.
    for (i, (rho, watts)) in
        [(0.0, 1.0), (0.3, 0.9), (0.02, 0.4), (0.05, 0.8), (0.08, 0.7)].into_iter().enumerate()
    {
        let name = format!("sample-{:02}", i + 1);
        let mut sample = outcome(&name, Role::Sample, rho, (watts, 0.1));
        sample.points = (1000.0 * (1.0 - rho)) as usize;
        sample.gate.quality = Quality::likeness(36.0, 0.95);
        done.push(sample);
        let kept = campaign.kept(1000, &done);
        let is_searched = |o: &&&Outcome| matches!(o.role, Role::Sample | Role::Optimum);
        let total: usize = kept.iter().filter(is_searched).map(|o| o.points).sum();
        assert!(total <= 4000, "{total} Gaussians after {name}");
        let names: Vec<&str> = kept.iter().map(|o| o.name.as_str()).collect();
        assert!(names.contains(&campaign.result(&done, 0).unwrap().name.as_str()));
        assert!(names.contains(&name.as_str()), "the last may be retried: {names:?}");
        assert!(names.contains(&"sample-01"), "whatever follows starts from it at least");
        assert!(names.contains(&"held-out"), "of another size it is measured again");
    }
    // A sample that missed goes when another follows, unless a lower quality may start from it.
    let mut missed = outcome("sample-06", Role::Sample, 0.4, (0.3, 0.1));
    (missed.passed, missed.points) = (false, 600);
    done.push(missed);
    let mut last = outcome("optimum", Role::Optimum, 0.03, (0.39, 0.1));
    last.points = 970;
    done.push(last);
    let has = |plan: &Plan, name: &str| plan.kept(1000, &done).iter().any(|o| o.name == name);
    assert!(!has(&campaign, "sample-06") && has(&campaign, "optimum"));
    assert!(campaign.kept(1000, &done).iter().map(|o| o.points).sum::<usize>() <= 5000);
    let mut lower = plan(Vec::new());
    lower.variants.push(Variant { name: "M".into(), rule: TargetRule::Share(0.5) });
    lower.schedule = Schedule::Adaptive { count: 7, first: Some(0.15) };
    done.truncate(5);
    done.push(Outcome { passed: false, points: 600, ..done[4].clone() });
    done[5].name = "sample-04".into();
    done.push(outcome("sample-05", Role::Sample, 0.4, (0.3, 0.1)));
    assert!(lower.kept(1000, &done).iter().any(|o| o.name == "sample-04"));
}
