//! Levels of the periphery: which jobs there are, what trains, and that they become one model.

use powergs_base::budget::Budget;
use powergs_base::picture::Picture;
use powergs_core::run::System;
use powergs_frame::display::d22::Filter;
use powergs_frame::fovea::{POOLINGS, Screen};
use powergs_optimize::foveated::{FilterCost, LevelState, Levels, Method, Viewer, lines};
use powergs_optimize::job::{Job, Place};
use powergs_optimize::lambda::{Control, LambdaRule};
use powergs_optimize::oracle::{CycleOracle, OracleWatts};
use powergs_optimize::outcome::{Outcome, at};
use powergs_optimize::plan::{Plan, Variant};
use powergs_optimize::prune::Score;
use powergs_optimize::role::{Baseline, Role};
use powergs_optimize::schedule::Schedule;
use powergs_optimize::settings::{Dimming, Settings};
use powergs_optimize::setup::Seen;
use powergs_optimize::target::{Quality, Target, TargetRule};
use powergs_optimize::tune::{
    Check, DisplayTerm, Keep, Model, Objective, Pace, Pruning, State, Trains, TuneConfig, Tuner,
};
use powergs_quality::Loss;
use powergs_quality::loss::display_term;
use powergs_scene::Foveated;

use super::scenes::tiny;

fn campaign(levels: u8) -> Plan {
    let variant = |name: &str, share| Variant { name: name.into(), rule: TargetRule::Share(share) };
    Plan {
        schedule: Schedule::Listed(vec![0.0, 0.4]),
        baselines: vec![Baseline::DisplayOnly, Baseline::RenderOnly, Baseline::TwoStage],
        externals: Vec::new(),
        sweep_weights: Vec::new(),
        variants: vec![variant("H", 0.99), variant("L", 0.97)],
        holds_out: false,
        reference: None,
        given: None,
        levels,
    }
}

/// An outcome whose power falls with ρ and whose HVSQ is `hvsq`.
fn outcome(job: &Job, hvsq: f64, passed: bool) -> Outcome {
    let quality = Quality { hvsq: Some(hvsq), ..Quality::likeness(40.0, 0.99) };
    let seen = Seen { quality, display_w: 0.5 };
    let base = job.base.unwrap_or(1000) as f64;
    Outcome {
        name: job.name.clone(),
        role: job.role,
        place: job.place,
        rho: job.rho,
        points: (base * (1.0 - job.rho)).round() as usize,
        iterations: 10,
        kept_at: Some(9),
        lambda: Some(0.1),
        passing_lambda: Some(0.2),
        gains: None,
        is_end: job.is_end,
        gate: seen,
        confirmation: None,
        error_db: [None; 2],
        passed,
        test: seen,
        flip_test: 0.0,
        lpips_test: None,
        watts: OracleWatts {
            render_w: base / 1000.0 - 0.5 * job.rho,
            display_w: 0.5 + 0.1 * job.rho,
            ..OracleWatts::default()
        },
    }
}

/// All jobs of a campaign, and their outcomes; `passes` judges.
fn play(campaign: &Plan, passes: impl Fn(&Job) -> bool) -> (Vec<Job>, Vec<Outcome>) {
    play_with(&tiny(10, 24, (16, 12)).settings, campaign, passes)
}

fn play_with(
    settings: &Settings,
    campaign: &Plan,
    passes: impl Fn(&Job) -> bool,
) -> (Vec<Job>, Vec<Outcome>) {
    let (mut jobs, mut done) = (Vec::new(), Vec::new());
    while let Some(job) = campaign.next(settings, 1000, &done) {
        done.push(outcome(&job, 1e-5, passes(&job)));
        jobs.push(job);
        assert!(jobs.len() < 200, "no end");
    }
    let iterations: u64 =
        jobs.iter().filter_map(|j| j.config).map(|o| u64::from(o.iterations)).sum();
    let most = campaign.most_iterations(settings);
    let all: Vec<_> = jobs.iter().map(|j| (&j.name, j.config.map(|c| c.iterations))).collect();
    assert!(iterations <= most, "{iterations} of {most}: {all:?}");
    (jobs, done)
}

#[test]
fn every_level_has_a_search_that_starts_from_the_level_before() {
    let campaign = campaign(4);
    let (jobs, done) = play(&campaign, |_| true);
    let names: Vec<&str> = jobs.iter().map(|j| j.name.as_str()).collect();
    let expected = [
        "dense",
        "sample-01",
        "sample-02",
        "optimum",
        "display-only",
        "render-only",
        "two-stage",
        "level2-sample-01",
        "level2-sample-02",
        "level2-optimum",
        "level3-sample-01",
        "level3-sample-02",
        "level3-optimum",
        "level4-sample-01",
        "level4-sample-02",
        "level4-optimum",
        "level2-display-only",
        "level3-display-only",
        "level4-display-only",
        "level2-render-only",
        "level3-render-only",
        "level4-render-only",
        "L-sample-01",
    ];
    assert_eq!(names[..expected.len()], expected);
    // The other variant has the same jobs but the baseline without levels.
    assert_eq!(names.len(), 2 * (expected.len() - 1) - 1 - 1);
    let of = |name: &str| jobs.iter().find(|j| j.name == name).unwrap();
    let from = |name: &str| of(name).from.as_deref().unwrap();
    let best = campaign.conclusion(&done, Place::default()).best.unwrap();
    assert_eq!(from("level2-sample-01"), best);
    assert_eq!(from("level2-sample-02"), "level2-sample-01");
    assert_eq!(from("level2-optimum"), best, "the realised optimum starts where its search does");
    assert_eq!(from("level4-render-only"), "level3-render-only");
    assert_eq!(from("level2-display-only"), "display-only");
    for (level, name) in [(1, "level2-optimum"), (2, "level3-sample-02"), (3, "level4-render-only")]
    {
        let config = of(name).config.unwrap();
        assert_eq!(of(name).place.level, level);
        assert_eq!(config.objective, Objective::Hvsq { pooling: POOLINGS[usize::from(level)] });
        assert_eq!(config.trains, Trains::ColoursAndOpacities);
    }
    // Ratios are shares of the level before.
    let base = of("level3-sample-02").base.unwrap();
    let goal = match of("level3-sample-02").config.unwrap().pruning {
        Pruning::Steps { goal, .. } => goal,
        other => panic!("{other:?}"),
    };
    assert_eq!(goal, base - (base as f64 * 0.4) as usize);
    // All levels of a line must reach the HVSQ that its level 1 has at pooling 1.
    let target = campaign.target_at(&done, None, Place { variant: 0, level: 3 });
    assert_eq!(target, Some(Target::Hvsq(1e-5)));
}

#[test]
fn the_pruned_end_of_a_level_starts_from_the_level_before_as_it_was_shown() {
    let mut campaign = campaign(2);
    campaign.schedule = Schedule::FIVE;
    let (jobs, done) = play(&campaign, |_| true);
    let best = campaign.conclusion(&done, Place::default()).best.unwrap();
    let of = |name: &str| jobs.iter().find(|j| j.name == name).unwrap();
    let (first, end) = (of("level2-sample-01"), of("level2-sample-02"));
    // Not from the unpruned sample, which has spent on the display what pruning is to spend.
    assert!(!first.is_end && end.is_end);
    assert_eq!([&first.from, &end.from], [&Some(best.clone()), &Some(best)]);
    // It and what goes on from it have most of the iterations.
    let iterations = |job: &Job| job.config.unwrap().iterations;
    assert_eq!(iterations(end), 9 * iterations(first), "{first:?}");
    // Where no unpruned model passes it is made all the same.
    let (jobs, _) = play(&campaign, |job| job.place.level == 0 || job.is_end);
    assert!(jobs.iter().any(|j| j.name == "level2-sample-03" && j.is_end), "{jobs:?}");
}

#[test]
fn near_its_target_a_level_is_pruned_only_where_all_views_that_choose_were_looked_at() {
    let mut tiny = tiny(300, 4, (48, 36));
    let all = tiny.cameras.len();
    tiny.split.validation = (0..all / 2).collect();
    tiny.split.train = (all / 2..all).collect();
    let setup = tiny.setup();
    let pruning = Pruning::WhilePassing { most: 15, share: 0.05 };
    let (display, keep) = (DisplayTerm::Off, Keep::LastPassing);
    let config = TuneConfig { iterations: 90, pruning, display, keep, ..config(300, 3.0) };
    let target = Target::Hvsq(5e-6);
    let state = State::begin(Model::fresh(&tiny.dense));
    let mut tuner = Tuner::new(&setup, config, target, 1, state);
    let (mut before, mut prunes, mut rows) = (None, 0, Vec::new());
    while !tuner.is_done() {
        let row = tuner.step().unwrap();
        if let Some((points, check)) = before
            && row.points < points
        {
            let check: Check = check;
            let margin_db = target.margin_db(check.seen.quality);
            assert!(check.passed && (check.confirmed || margin_db >= 2.0), "{check:?}");
            prunes += u32::from(margin_db < 2.0);
        }
        rows.extend(row.check.map(|c| (row.points, target.margin_db(c.seen.quality))));
        before = row.check.map(|check| (row.points, check)).or(before);
    }
    assert!(prunes > 1, "none near the target: {rows:?}");
    let (model, check, _) = tuner.finish();
    assert!(check.unwrap().passed && model.scene.len() < 300);
}

#[test]
fn a_level_where_nothing_passes_shows_the_level_before() {
    let campaign = campaign(4);
    let (jobs, done) = play(&campaign, |job| job.place.level != 2);
    // Without a sample that passes there is nothing to realise.
    assert!(jobs.iter().all(|j| j.name != "level3-optimum"));
    let own = |level| campaign.model_at(&done, None, Place { variant: 0, level }).unwrap();
    assert_eq!(own(2).name, own(1).name);
    assert_eq!(own(3).place.level, 3, "level 4 goes on from level 2");
    let all = lines(&campaign, &done);
    let methods: Vec<Method> = all.iter().filter(|l| l.variant == 0).map(|l| l.method).collect();
    assert_eq!(methods, Method::ALL);
    for line in &all {
        use LevelState::{Fallback, Passed};
        assert_eq!(line.state, [Passed, Passed, Fallback, Passed], "{line:?}");
        assert_eq!(line.jobs[2], line.jobs[1]);
    }
    // What is to spare is spent by gains, as at level 1.
    let displays = || jobs.iter().filter(|j| j.place.level > 0).filter_map(|j| j.config);
    let spends = |c: TuneConfig| matches!(c.display, DisplayTerm::Gains { .. } | DisplayTerm::Off);
    assert!(displays().count() > 0 && displays().all(spends));
    // The λ of level 1 belongs to another loss.
    let settings =
        Settings { dimming: Dimming::Term(LambdaRule::Damped), ..tiny(10, 24, (16, 12)).settings };
    let (jobs, _) = play_with(&settings, &campaign, |job| job.place.level != 1);
    let config = jobs.iter().find(|j| j.name == "level3-sample-01").unwrap().config.unwrap();
    let DisplayTerm::Controlled { control, .. } = config.display else { panic!("no display term") };
    assert!(control.is_estimated, "{control:?}");
    assert_eq!(control.start, Settings::DEFAULT.level_display_weight / 0.5, "level 1 ended at 0.2");
    // A baseline that misses at level 1 is shown all the same.
    let (_, done) = play(&campaign, |job| job.name != "render-only");
    let all = lines(&campaign, &done);
    let pruned = all.iter().find(|l| l.method == Method::RtgsD22).unwrap();
    assert_eq!(pruned.state[0], LevelState::Missed);
}

#[test]
fn levels_that_no_view_shows_are_not_made() {
    let (jobs, done) = play(&campaign(3), |_| true);
    assert!(jobs.iter().all(|j| j.place.level < 3));
    let all = lines(&campaign(3), &done);
    assert!(all.iter().all(|l| l.state[3] == LevelState::NotShown && l.jobs[3] == l.jobs[2]));
    let (jobs, done) = play(&campaign(1), |_| true);
    assert!(jobs.iter().all(|j| j.place.level == 0) && lines(&campaign(1), &done).is_empty());
    assert_eq!(at(&done, Place { variant: 1, level: 0 }).len(), 5);
}

const CONTROL: Control = Control {
    rule: LambdaRule::Damped,
    start: 0.01,
    is_estimated: false,
    interval: 2,
    adjust: 8,
    epsilon_db: 0.05,
};

/// TuneConfig for a level: prune, then colours and opacities at a pooling.
fn config(points: usize, pooling: f64) -> TuneConfig {
    let control = Control { is_estimated: true, ..CONTROL };
    TuneConfig {
        iterations: 12,
        pruning: Pruning::Steps {
            score: Score::Dominance,
            goal: points * 7 / 10,
            steps: std::num::NonZeroU32::MIN,
            every: 0,
        },
        display: DisplayTerm::Controlled { from: 2, control },
        objective: Objective::Hvsq { pooling },
        trains: Trains::ColoursAndOpacities,
        keep: Keep::Last,
        pace: Pace::RECOVERING,
    }
}

#[test]
fn trained_levels_share_all_but_their_paint_and_become_one_model() {
    let mut tiny = tiny(300, 16, (48, 36));
    tiny.settings.opacity_cap = 0.5;
    let setup = tiny.setup();
    let mut levels = vec![tiny.dense.clone()];
    for pooling in POOLINGS.into_iter().skip(1) {
        let before = levels.last().unwrap();
        let config = config(before.len(), pooling);
        let target = Target::Hvsq(1e-3);
        let state = State::begin(Model::fresh(before));
        let mut tuner = Tuner::new(&setup, config, target, 1, state);
        let first = tuner.step().unwrap();
        assert!(first.loss.hvsq.unwrap() > 0.0 && first.loss.likeness.is_none());
        let mut last = first;
        while !tuner.is_done() {
            last = tuner.step().unwrap();
        }
        assert!(last.check.unwrap().seen.quality.hvsq.unwrap().is_finite());
        let (model, ..) = tuner.finish();
        assert_eq!(model.scene.len(), before.len() * 7 / 10);
        assert_ne!(model.scene.sh, before.sh, "colours have trained");
        levels.push(model.scene);
    }
    let levels: [_; 4] = levels.try_into().unwrap();
    // Bit for bit: nothing that levels share has moved.
    let model = Foveated::compose(&levels).unwrap();
    assert_eq!(model.counts(), levels.each_ref().map(|l| l.len()));
    for (k, level) in levels.iter().enumerate() {
        assert_eq!(model.level(k), *level);
    }
}

#[test]
fn a_level_goes_on_bit_for_bit() {
    let tiny = tiny(120, 24, (40, 30));
    let setup = tiny.setup();
    let start = || State::begin(Model::fresh(&tiny.dense));
    let tuner = |state| Tuner::new(&setup, config(120, 3.0), Target::Hvsq(1e-3), 4, state);
    let mut whole = tuner(start());
    while !whole.is_done() {
        whole.step().unwrap();
    }
    let mut first = tuner(start());
    for _ in 0..5 {
        first.step().unwrap();
    }
    let state = first.state().clone();
    let mut second = tuner(state);
    while !second.is_done() {
        second.step().unwrap();
    }
    assert_eq!(whole.finish().0, second.finish().0);
}

#[test]
fn the_display_term_alone_is_that_of_the_loss() {
    // Black, beyond white, negative, and both sides of the linear part; no whole number of vectors.
    let value = |i: usize| [-0.2, 0.0, 0.02, 0.04045, 0.3, 0.99, 1.7][i % 7] + (i as f32) * 1e-4;
    let pixels = (0..37 * 23).map(|i| [value(3 * i), value(3 * i + 1), value(3 * i + 2)]);
    let picture = Picture { width: 37, height: 23, pixels: pixels.collect() };
    let display = tiny(4, 48, (16, 12)).display;
    let evaluate = |lambda| {
        let mut gradient = vec![[0.0; 3]; picture.pixels.len()];
        let mut loss = Loss::new(37, 23);
        let parts = loss.evaluate(&picture, &picture, lambda, &display, &mut gradient);
        (parts.display_w, gradient)
    };
    let (watts, with) = evaluate(3.0);
    let (_, without) = evaluate(0.0);
    let mut alone = vec![[0.5f32; 3]; picture.pixels.len()];
    let own = display_term(&picture, 3.0, &display, &mut alone);
    assert!((own / watts - 1.0).abs() < 1e-6, "{own} W, {watts} W");
    for ((a, b), c) in with.iter().zip(&without).zip(&alone) {
        for k in 0..3 {
            let (expected, got) = (a[k] - b[k], c[k] - 0.5);
            // Half a unit of the last place of 0.5 is 3e-8.
            assert!((expected - got).abs() < 1e-7, "{expected} and {got}");
        }
    }
}

#[test]
fn the_filter_costs_its_operations_and_saves_display_power() {
    let mut tiny = tiny(400, 24, (96, 72));
    tiny.settings.interval = 1;
    let setup = tiny.setup();
    let levels = [0.0, 0.2, 0.5, 0.7].map(|rho: f64| {
        let mut scene = tiny.dense.clone();
        let kept: Vec<u32> = (0..(400.0 * (1.0 - rho)) as u32).collect();
        powergs_optimize::prune::select(&mut scene, &kept);
        scene
    });
    let model = Foveated::compose(&levels).unwrap();
    let clock = CycleOracle {
        system: System::named("gscore").unwrap(),
        fps: 60.0,
        memory: Budget::DEFAULT,
    };
    let screens = Screen { pooling_rate: 0.6, ..Screen::PUBLISHED }.into();
    let cost = FilterCost { flops: 215.0, flop_pj: 0.53, flops_per_cycle: 1536.0 };
    let viewer = Viewer { setup: &setup, screens, clock: &clock, cost };
    let measure = |method| {
        let jobs = std::array::from_fn(|k| format!("job-{k}"));
        let levels = Levels { method, variant: 0, jobs, state: [LevelState::Passed; 4] };
        viewer.measure(levels, &model).unwrap()
    };
    let (plain, filtered) = (measure(Method::FrRender), measure(Method::RtgsD22));
    assert_eq!(plain.counts, [400, 320, 200, 120]);
    assert!(filtered.watts.display_w < plain.watts.display_w);
    assert!(filtered.filter_w > 0.0 && plain.filter_w == 0.0);
    let added = filtered.watts.render_w - plain.watts.render_w;
    assert!((added / filtered.filter_w - 1.0).abs() < 1e-9);
    assert!((filtered.watts.parts.total_w() / filtered.watts.render_w - 1.0).abs() < 1e-12);
    assert!(filtered.fps < plain.fps);
    // What is shown is what is judged: the filter costs decibels.
    let like = filtered.filtered.expect("the filter is looked through");
    let whole = setup.see(&model.level(0), &setup.split.test, None).quality;
    assert!(like.psnr_db < whole.psnr_db && like.ssim < whole.ssim, "{like:?}, {whole:?}");
    assert_eq!(plain.filtered, None);
    // Every pixel outside of the fovea pays: no more than all of them.
    let most = 96.0 * 72.0 * 215.0 * 0.53e-12 * 60.0;
    assert!(filtered.filter_w <= most && filtered.filter_w > 0.3 * most);
    assert!(!Filter::changes(8.4) && Filter::changes(8.6));
    // The fovea is not filtered: the same there, worse beyond.
    let at = |f: &powergs_optimize::foveated::MeasuredFoveated, k: usize| f.hvsq[k].unwrap();
    assert!(at(&filtered, 3) > at(&plain, 3));
    assert!((plain.tiles.iter().sum::<f64>() - 6.0 * 5.0).abs() < 1e-9);
    assert!(plain.region_j.iter().zip(plain.tiles).all(|(j, n)| (*j > 0.0) == (n > 0.0)));
    assert_eq!(Role::Optimum.baseline(), None);
}
