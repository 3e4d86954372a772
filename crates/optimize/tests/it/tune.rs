//! Fine-tunes on a tiny scene: they go on bit for bit, on any number of threads, and refuse
//! numbers that are none.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicUsize, Ordering};

use powergs_base::picture::Picture;
use powergs_optimize::lambda::{Control, LambdaRule};
use powergs_optimize::prune::Score;
use powergs_optimize::references::{Reference, References};
use powergs_optimize::settings::Settings;
use powergs_optimize::setup::{Seen, Setup};
use powergs_optimize::target::{Quality, Target};
use powergs_optimize::tune::{
    DisplayTerm, Gauge, Heat, Iteration, Keep, Model, Objective, Pace, Pruning, State, Stride,
    Trains, TuneConfig, TuneError, Tuner, confirming,
};

use super::scenes::{Tiny, tiny};

const TARGET: Target = Target::Likeness(Quality::likeness(34.0, 0.9));

fn config(points: usize) -> TuneConfig {
    TuneConfig {
        iterations: 14,
        pruning: Pruning::Steps {
            score: Score::Dominance,
            goal: points * 6 / 10,
            steps: NonZeroU32::new(2).unwrap(),
            every: 4,
        },
        display: DisplayTerm::Controlled {
            from: 2,
            control: Control {
                rule: LambdaRule::Damped,
                start: 0.05,
                is_estimated: true,
                interval: 3,
                adjust: 9,
                epsilon_db: 0.0,
            },
        },
        objective: Objective::Likeness,
        trains: Trains::All,
        keep: Keep::Dimmest,
        pace: Pace::RECOVERING,
    }
}

fn run(tiny: &Tiny, config: TuneConfig, state: State, stop: u32) -> (Vec<Iteration>, State) {
    let setup = tiny.setup();
    let mut tuner = Tuner::new(&setup, config, TARGET, 5, state);
    let mut rows = Vec::new();
    while !tuner.is_done() && tuner.state().iteration < stop {
        rows.push(tuner.step().unwrap());
    }
    let state = tuner.state().clone();
    (rows, state)
}

#[test]
fn a_fine_tune_goes_on_bit_for_bit_from_any_iteration() {
    let tiny = tiny(300, 4, (48, 36));
    let config = config(300);
    let begin = || State::begin(Model::fresh(&tiny.dense));
    let (rows, whole) = run(&tiny, config, begin(), u32::MAX);
    assert_eq!(rows.len(), 14);
    assert_eq!(whole.model.scene.len(), 180);
    for stop in [1, 3, 5, 9] {
        let (mut first, half) = run(&tiny, config, begin(), stop);
        let (second, end) = run(&tiny, config, half, u32::MAX);
        first.extend(second);
        assert_eq!(first, rows, "stopped after {stop}");
        assert_eq!(end, whole, "stopped after {stop}");
    }
}

#[test]
fn everything_is_pruned_however_few_iterations_there_are() {
    let tiny = tiny(300, 4, (48, 36));
    for iterations in 1..7 {
        let pruning = Pruning::Steps {
            score: Score::Dominance,
            goal: 120,
            steps: NonZeroU32::new(5).unwrap(),
            every: iterations / 5,
        };
        let config = TuneConfig { iterations, pruning, ..config(300) };
        let (_, state) = run(&tiny, config, State::begin(Model::fresh(&tiny.dense)), u32::MAX);
        assert_eq!(state.model.scene.len(), 120, "{iterations} iterations");
        assert!(state.last.unwrap().confirmed, "the last check looks at all views");
    }
}

#[test]
fn a_gauge_that_looks_at_few_views_comes_to_the_mean_of_all() {
    let mut tiny = tiny(300, 2, (48, 36));
    tiny.split.validation = (0..tiny.cameras.len()).collect();
    assert!(tiny.cameras.len() > 8, "{} views", tiny.cameras.len());
    let setup = tiny.setup();
    let dimmed = |by: f32| {
        let mut scene = tiny.dense.clone();
        scene.sh.iter_mut().for_each(|c| *c *= by);
        scene
    };
    let (before, dim) = (dimmed(0.82), dimmed(0.8));
    let exact = setup.see(&dim, setup.gate_views(), None);
    let mut gauge = Gauge::default();
    let first = gauge.some(&setup, &before, None);
    assert_eq!(first, setup.see(&before, setup.gate_views(), None), "the first look is exact");
    let off = |seen: Seen| (seen.quality.psnr_db - exact.quality.psnr_db).abs();
    let at_once = off(gauge.some(&setup, &dim, None));
    for _ in 0..40 {
        gauge.some(&setup, &dim, None);
    }
    // What is left is how the views that do not choose differ from the others now.
    let some = gauge.some(&setup, &dim, None).quality.psnr_db;
    let chosen = gauge.chosen(&setup, &dim, None);
    assert!((some - chosen.quality.psnr_db).abs() < 1e-3, "{some} dB");
    assert!(off(chosen) < 0.1 && off(chosen) <= at_once, "{at_once} dB, then {}", off(chosen));
    assert_ne!(chosen, exact, "views that do not choose were not looked at");
    assert_eq!(gauge.all(&setup, &dim, None), exact);
    assert!(off(gauge.some(&setup, &dim, None)) < 1e-9, "once they were looked at it is exact");
}

/// Reference pictures, and how often each was asked for.
struct Counted<'a>(&'a Vec<Reference>, Vec<AtomicUsize>);

impl References for Counted<'_> {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        self.1[view].fetch_add(1, Ordering::Relaxed);
        self.0[view].write_to(picture);
    }

    fn digest(&self) -> u128 {
        self.0.digest()
    }
}

#[test]
fn views_that_confirm_do_not_choose() {
    let mut tiny = tiny(400, 2, (48, 36));
    let all = tiny.cameras.len();
    tiny.split.validation = (0..9).collect();
    tiny.split.train = (9..all).collect();
    let counted = Counted(&tiny.references, (0..all).map(|_| AtomicUsize::new(0)).collect());
    let setup = Setup { references: &counted, ..tiny.setup() };
    let pruning = Pruning::WhilePassing { most: 3, share: 0.05 };
    let (iterations, display) = (120, DisplayTerm::Off);
    let keep = Keep::LastPassing;
    let config = TuneConfig { iterations, pruning, display, keep, ..config(300) };
    let state = State::begin(Model::fresh(&tiny.dense));
    let mut tuner = Tuner::new(&setup, config, TARGET, 5, state);
    while !tuner.is_done() {
        tuner.step().unwrap();
    }
    let looks: Vec<usize> = counted.1.iter().map(|n| n.load(Ordering::Relaxed)).collect();
    let (confirm, choose): (Vec<_>, Vec<_>) = (0..9).partition(|i| i % 3 == 2);
    // At the beginning and in each further eighth, whatever they show, and what is chosen.
    assert!(confirm.iter().all(|&i| looks[i] == 9), "{looks:?}");
    assert!(choose.iter().all(|&i| looks[i] > 9), "{looks:?}");
    // What is kept was chosen by an estimate of them, with a little to spare.
    let (model, check, _) = tuner.finish();
    let (check, found) = (check.unwrap(), setup.see(&model.scene, setup.gate_views(), None));
    assert!(check.passed && model.scene.len() < 400);
    assert!(TARGET.margin_db(check.seen.quality) >= 0.5 * tiny.settings.epsilon_db);
    let luck = check.seen.quality.psnr_db - found.quality.psnr_db;
    assert!(luck != 0.0 && luck.abs() < 1.0, "{luck} dB");
    assert_eq!([1, 2, 3, 9].map(confirming), [0, 0, 1, 3], "of two views both choose");
}

/// Reference pictures of which every third is dark when it is looked at for the `when`-th time.
struct Turning<'a> {
    counted: Counted<'a>,
    when: std::ops::Range<usize>,
}

impl References for Turning<'_> {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        self.counted.write_to(view, picture);
        let looks = self.counted.1[view].load(Ordering::Relaxed);
        if view % 3 == 2 && view < 9 && self.when.contains(&looks) {
            picture.pixels.iter_mut().flatten().for_each(|v| *v *= 0.5);
        }
    }

    fn digest(&self) -> u128 {
        self.counted.digest()
    }
}

#[test]
fn a_model_that_other_views_find_too_bad_is_trained_on() {
    let mut tiny = tiny(300, 2, (48, 36));
    let all = tiny.cameras.len();
    tiny.split.validation = (0..9).collect();
    tiny.split.train = (9..all).collect();
    let Settings { interval, epsilon_db, .. } = tiny.settings;
    let (rule, is_estimated) = (LambdaRule::Damped, true);
    let control = Control { rule, start: 0.05, is_estimated, interval, adjust: 54, epsilon_db };
    let display = DisplayTerm::Controlled { from: 0, control };
    let (iterations, keep, pruning) = (60, Keep::Dimmest, Pruning::Never);
    let config = TuneConfig { iterations, pruning, display, keep, ..config(300) };
    // Eight looks whatever they show; the ninth is the first at what was chosen.
    for (when, is_extended) in [(0..0, false), (9..10, true), (9..99, true)] {
        let counts = (0..all).map(|_| AtomicUsize::new(0)).collect();
        let turning = Turning { counted: Counted(&tiny.references, counts), when: when.clone() };
        let setup = Setup { references: &turning, ..tiny.setup() };
        let state = State::begin(Model::fresh(&tiny.dense));
        let mut tuner = Tuner::new(&setup, config, TARGET, 5, state);
        let (mut lambdas, mut last, mut spare) = (Vec::new(), 0, None);
        while !tuner.is_done() {
            if last == 59 {
                spare.clone_from(&tuner.state().spare);
            }
            let iteration = tuner.step().unwrap();
            lambdas.push(iteration.lambda);
            last = iteration.iteration + 1;
        }
        let state = tuner.state();
        assert_eq!(state.extended.is_some(), is_extended, "{when:?}");
        // A tenth, but two checks at least.
        let most = state.extended.map_or(60, |done| done + 6);
        assert!(state.settled || last == most, "{last} {when:?}");
        assert!(!is_extended || lambdas.last() < lambdas.get(59), "less display term");
        let (model, check, _) = tuner.finish();
        let found = tiny.setup().see(&model.scene, setup.gate_views(), None);
        assert!(is_extended || check.unwrap().passed && TARGET.passes(found.quality), "{found:?}");
        // Half as bright a third of the pictures is missed by all: an earlier model is kept that
        // had more to spare, if there was one.
        if let Some((scene, kept)) = spare.filter(|_| is_extended) {
            assert!((scene == model.scene) && check == Some(kept), "{when:?}");
            assert!(TARGET.margin_db(kept.seen.quality) >= 2.0 * epsilon_db);
        }
    }
}

#[test]
fn what_is_trained_on_goes_on_bit_for_bit() {
    let mut tiny = tiny(300, 2, (48, 36));
    let all = tiny.cameras.len();
    tiny.split.validation = (0..9).collect();
    tiny.split.train = (9..all).collect();
    let (iterations, display, keep) = (30, DisplayTerm::Off, Keep::LastPassing);
    let pruning = Pruning::WhilePassing { most: 20, share: 0.05 };
    let config = TuneConfig { iterations, pruning, display, keep, ..config(300) };
    // Views that did not choose say no from their ninth look on; `stop` iterations after that it
    // is stopped.
    let ends = |stop: u32| {
        let counts = (0..all).map(|_| AtomicUsize::new(0)).collect();
        let turning = Turning { counted: Counted(&tiny.references, counts), when: 9..99 };
        let setup = Setup { references: &turning, ..tiny.setup() };
        let mut state = State::begin(Model::fresh(&tiny.dense));
        let mut tuner = Tuner::new(&setup, config, TARGET, 5, state);
        let is_stopped = |state: &State| {
            state.extended.is_some_and(|done| state.iteration >= done.saturating_add(stop))
        };
        while !tuner.is_done() && !is_stopped(tuner.state()) {
            tuner.step().unwrap();
        }
        state = tuner.state().clone();
        let was_done = tuner.is_done();
        let mut tuner = Tuner::new(&setup, config, TARGET, 5, state);
        while !tuner.is_done() {
            tuner.step().unwrap();
        }
        (was_done, tuner.state().clone())
    };
    let (was_done, whole) = ends(99);
    assert!(was_done && whole.extended.is_some(), "{:?}", whole.extended);
    for stop in [0, 1, 4] {
        let (was_done, state) = ends(stop);
        assert!(!was_done && state == whole, "stopped after {stop}");
    }
}

#[test]
fn rates_rise_with_the_damage_and_fall_where_the_quality_is_flat() {
    let pace = Pace { heat: 6.0, rest: 0.5, averaged: 20 };
    let observed = |heat: &mut Heat, margin_db: f64| {
        heat.observe(margin_db, pace, false);
        heat.factor
    };
    let mut heat = Heat::begin(0.5, pace);
    assert_eq!(observed(&mut heat, 0.5), 0.5, "nothing is damaged");
    heat.pruned();
    let damaged = observed(&mut heat, -1.5);
    assert!(damaged > 2.5, "2 dB are gone: {damaged}");
    let rising = observed(&mut heat, -0.5);
    assert!(rising > damaged, "{damaged}, then {rising}");
    for _ in 0..50 {
        observed(&mut heat, 0.2);
    }
    assert!(heat.factor < 1.0, "flat, but still {}", heat.factor);
    // What the display takes is no damage.
    let mut dimming = Heat::begin(1.0, pace);
    for _ in 0..50 {
        dimming.observe(0.0, pace, true);
    }
    assert!(dimming.factor < 0.51, "{}", dimming.factor);
}

#[test]
fn steps_that_lose_quality_by_themselves_get_shorter() {
    let pace = Pace { heat: 6.0, rest: 0.5, averaged: 20 };
    let shaken = |margins_db: [f64; 4]| {
        let mut heat = Heat::begin(0.1, pace);
        heat.pruned();
        margins_db.map(|margin_db| {
            heat.observe(margin_db, pace, false);
            heat.factor
        })
    };
    // The prune took little; what goes after it is not its damage, but that of the steps.
    let [first, second, third, last] = shaken([-0.1, -0.3, -0.5, -0.7]);
    assert!(first > second && second > third && third > last, "{first} {second} {third} {last}");
    assert!(last < 0.5, "{last} below the rates at rest");
    // The same losses by a prune.
    let by_prune = shaken([-0.7, -0.6, -0.5, -0.4])[3];
    assert!(by_prune > 2.0, "{by_prune}");
    // Above the target there is nothing to save.
    let above = shaken([8.0, 7.0, 6.0, 5.0])[3];
    assert_eq!(above, 0.5);
}

#[test]
fn what_a_few_views_differ_by_is_no_fall() {
    let pace = Pace { heat: 6.0, rest: 0.5, averaged: 20 };
    let after = |margins_db: &[f64]| {
        let mut heat = Heat::begin(0.1, pace);
        heat.pruned();
        heat.observe(-0.3, pace, false);
        let first = heat.factor;
        margins_db.iter().for_each(|&margin_db| heat.observe(margin_db, pace, false));
        heat.factor / first
    };
    let noise = after(&[-0.22, -0.3, -0.22, -0.3, -0.22, -0.3]);
    assert!(noise > 0.9, "{noise}");
    // As much in all, but always down.
    let fall = after(&[-0.33, -0.36, -0.39, -0.42, -0.45, -0.48]);
    assert!(fall < 0.5, "{fall}");
}

#[test]
fn strides_shrink_where_recovering_takes_long_and_grow_again() {
    let mut stride = Stride::FIRST;
    assert_eq!(stride.passed(0.0), 1.0);
    for expected in [0.5, 0.25, 0.125, 0.0625, 0.0625] {
        (0..3).for_each(|_| stride.missed(-0.1));
        assert_eq!(stride.passed(0.0), expected);
    }
    stride.missed(-0.1);
    assert_eq!(stride.passed(0.0), 0.0625, "it took a moment");
    assert_eq!([0.0; 3].map(|margin_db| stride.passed(margin_db)), [0.125, 0.25, 0.5]);
    // Half of what is missing comes back with each check: it will be there.
    (0..19).for_each(|i| {
        stride.missed(-0.5f64.powi(i));
        assert!(!stride.gives_up(), "after {i}");
    });
    stride.missed(-1e-6);
    assert!(stride.gives_up() && stride.length == 0.25, "but it is not");
    assert!(!stride.gives_up());
    assert_eq!(stride.passed(0.0), 0.25);
}

#[test]
fn a_prune_that_it_will_not_recover_from_is_given_up_early() {
    let checks = |found: fn(f64) -> f64| {
        let mut stride = Stride::FIRST;
        stride.passed(0.0);
        (1..=20).find(|&i| {
            stride.missed(found(f64::from(i)));
            stride.gives_up()
        })
    };
    assert_eq!(checks(|_| -0.1), Some(6), "it does not rise");
    // Rising with the logarithm it would be there after 27 checks, or 18.
    let early = checks(|i| 0.1 * (i / 27.0).ln());
    assert!(early.is_some_and(|i| i < 12), "{early:?}");
    let late = checks(|i| 0.1 * (i / 18.0).ln().min(-0.01));
    assert_eq!(late, Some(20));
}

#[test]
fn strides_are_long_far_above_the_target_where_prunes_cost_little() {
    let strides = |cost_db: f64| {
        let (mut stride, mut margin_db) = (Stride::FIRST, 12.0);
        [(); 6].map(|()| {
            let length = stride.passed(margin_db);
            margin_db -= cost_db * length;
            (length, margin_db)
        })
    };
    let lengths = strides(0.1).map(|(length, _)| length);
    assert_eq!(lengths, [1.0, 2.0, 4.0, 4.0, 4.0, 4.0], "four longest are the most");
    for (length, margin_db) in strides(2.0) {
        assert!((1.0..=4.0).contains(&length));
        let is_usual = length == 1.0;
        assert!(is_usual || margin_db > -1e-9, "{length} went through the target: {margin_db}");
    }
    assert_eq!(strides(2.0).map(|(length, _)| length)[..4], [1.0, 2.0, 3.0, 1.0]);
}

#[test]
fn a_prune_that_it_does_not_recover_from_is_undone() {
    let tiny = tiny(300, 2, (48, 36));
    let setup = tiny.setup();
    let pruning = Pruning::WhilePassing { most: 200, share: 0.6 };
    let (display, keep) = (DisplayTerm::Off, Keep::LastPassing);
    let config = TuneConfig { iterations: 400, pruning, display, keep, ..config(300) };
    let state = State::begin(Model::fresh(&tiny.dense));
    // Nothing with half of the Gaussians comes near.
    let target = Target::Likeness(Quality::likeness(45.0, 0.0));
    let mut tuner = Tuner::new(&setup, config, target, 5, state);
    let mut points = Vec::new();
    while !tuner.is_done() {
        points.push(tuner.step().unwrap().points);
    }
    let least = *points.iter().min().unwrap();
    let rises = points.windows(2).filter(|pair| pair[1] > pair[0]).count();
    assert!(least < 200 && rises > 0, "{least} Gaussians at least, {rises} returns");
    let (model, check, _) = tuner.finish();
    assert!(check.unwrap().passed && model.scene.len() > least, "{}", model.scene.len());
}

#[test]
fn threads_do_not_matter() {
    let tiny = tiny(300, 4, (48, 36));
    let on = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let state = State::begin(Model::fresh(&tiny.dense));
        pool.install(|| run(&tiny, config(300), state, u32::MAX))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn the_display_term_dims_the_image_and_pruning_alone_does_not() {
    let tiny = tiny(300, 4, (48, 36));
    let with = |display| {
        let config = TuneConfig {
            iterations: 40,
            pruning: Pruning::Never,
            display,
            objective: Objective::Likeness,
            trains: Trains::All,
            keep: Keep::Last,
            pace: Pace::RECOVERING,
        };
        let (_, state) = run(&tiny, config, State::begin(Model::fresh(&tiny.dense)), u32::MAX);
        state.last.unwrap().seen.display_w
    };
    let (plain, dimmed) = (with(DisplayTerm::Off), with(DisplayTerm::Fixed(0.5)));
    assert!(dimmed < 0.95 * plain, "{dimmed} W is not below {plain} W");
}

#[test]
fn only_colours_move_if_only_colours_may() {
    let tiny = tiny(200, 6, (48, 36));
    let config = TuneConfig { trains: Trains::Colours, pruning: Pruning::Never, ..config(200) };
    let (_, state) = run(&tiny, config, State::begin(Model::fresh(&tiny.dense)), u32::MAX);
    let (now, before) = (&state.model.scene, &tiny.dense);
    assert_ne!(now.sh, before.sh);
    assert_eq!(now.means, before.means);
    assert_eq!(now.logit_opacities, before.logit_opacities);
}

#[test]
fn render_only_prunes_while_it_passes_and_ends_with_a_model_that_did() {
    let mut tiny = tiny(300, 4, (48, 36));
    tiny.settings.interval = 2;
    let config = TuneConfig {
        iterations: 30,
        pruning: Pruning::WhilePassing { most: 15, share: 1.0 },
        display: DisplayTerm::Off,
        objective: Objective::Likeness,
        trains: Trains::All,
        keep: Keep::LastPassing,
        pace: Pace::RECOVERING,
    };
    let setup = tiny.setup();
    let state = State::begin(Model::fresh(&tiny.dense));
    let mut tuner = Tuner::new(&setup, config, TARGET, 5, state);
    let (mut points, mut passed) = (300, true);
    while !tuner.is_done() {
        let row = tuner.step().unwrap();
        if !passed {
            assert_eq!(row.points, points, "pruned without passing");
        }
        points = row.points;
        passed = row.check.is_none_or(|c| c.passed);
    }
    let (model, check, _) = tuner.finish();
    assert!(check.unwrap().passed);
    assert!(model.scene.len() < 300, "nothing was pruned");
    assert!(TARGET.passes(setup.see(&model.scene, setup.gate_views(), None).quality));
}

#[test]
fn numbers_that_are_none_are_named_and_end_the_iteration() {
    let tiny = tiny(200, 6, (48, 36));
    let mut model = Model::fresh(&tiny.dense);
    // Its square overflows single precision.
    model.scene.sh.fill(1e30);
    let setup = tiny.setup();
    let before = State::begin(model);
    let config = TuneConfig { pruning: Pruning::Never, ..config(200) };
    let mut tuner = Tuner::new(&setup, config, TARGET, 5, before);
    let error = tuner.step().unwrap_err();
    let (TuneError::Loss { iteration, .. } | TuneError::Gradient { iteration, .. }) = &error else {
        panic!("{error}")
    };
    assert_eq!(*iteration, 0);
    assert!(error.to_string().contains("view view_"), "{error}");
    assert_eq!(tuner.state().iteration, 0);
}
