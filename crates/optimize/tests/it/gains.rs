//! Gains of the colour channels: they spend what a model has above its target, and are taken back.

use powergs_optimize::lambda::{Control, LambdaRule};
use powergs_optimize::references::Reference;
use powergs_optimize::target::{Quality, Target};
use powergs_optimize::tune::{
    Check, DisplayTerm, Gains, Keep, Model, Objective, Pace, Pruning, State, Trains, TuneConfig,
    Tuner,
};
use powergs_raster::{Detail, Options, render};
use powergs_scene::Foveated;

use super::scenes::{Tiny, tiny};

fn config(iterations: u32, display: DisplayTerm) -> TuneConfig {
    TuneConfig {
        iterations,
        pruning: Pruning::Never,
        display,
        objective: Objective::Likeness,
        trains: Trains::All,
        keep: Keep::Dimmest,
        pace: Pace::RECOVERING,
    }
}

/// A scene whose references are not its own renders: they have noise of so much of full scale, so
/// that it is as far from them as a trained model from photos.
fn noisy(size: f32) -> Tiny {
    let mut tiny = tiny(300, 4, (48, 36));
    for (view, reference) in tiny.references.iter_mut().enumerate() {
        let options = Options::reference(Detail::Image);
        let mut picture = render(&tiny.dense, &tiny.cameras[view], &options).picture;
        let mut state = view as u32 + 1;
        for value in picture.pixels.as_flattened_mut() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *value += size * ((state >> 8) as f32 / (1 << 23) as f32 - 1.0);
        }
        *reference = Reference::new(&picture);
    }
    tiny
}

fn tuned(tiny: &Tiny, config: TuneConfig, target: Target) -> (Model, Check, Option<Gains>) {
    let setup = tiny.setup();
    let state = State::begin(Model::fresh(&tiny.dense));
    let mut tuner = Tuner::new(&setup, config, target, 5, state);
    while !tuner.is_done() {
        tuner.step().unwrap();
    }
    let gains = tuner.spent().map(|spent| spent.gains);
    let (model, check, _) = tuner.finish();
    (model, check.unwrap(), gains)
}

#[test]
fn a_picture_over_black_is_scaled_and_gains_are_taken_back() {
    let tiny = tiny(300, 16, (48, 36));
    let gains = Gains([0.9, 0.95, 0.6]);
    let mut scene = tiny.dense.clone();
    gains.apply(&mut scene, Trains::All);
    let options = Options::reference(Detail::Image);
    let [bright, dim] =
        [&tiny.dense, &scene].map(|scene| render(scene, &tiny.cameras[0], &options).picture);
    for (bright, dim) in bright.pixels.iter().zip(&dim.pixels) {
        for c in 0..3 {
            assert!((gains.0[c] * bright[c] - dim[c]).abs() < 1e-5, "{bright:?} {dim:?}");
        }
    }
    assert!(bright.pixels.iter().any(|p| p.iter().all(|v| *v > 0.2)), "something is seen");
    gains.undo(&mut scene, Trains::All);
    let off = scene.sh.iter().zip(&tiny.dense.sh).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off < 1e-5, "{off}");
}

#[test]
fn slack_is_spent_whether_it_is_a_third_of_a_decibel_or_ten() {
    let tiny = noisy(0.1);
    let gate = tiny.setup().gate_views().to_vec();
    let before = tiny.setup().see(&tiny.dense, &gate, None);
    for slack_db in [0.3, 1.0, 10.0] {
        let psnr_db = before.quality.psnr_db - slack_db;
        let target = Target::Likeness(Quality::likeness(psnr_db, 0.0));
        // Hardly any training: what is spent is what there was.
        let config = config(2, DisplayTerm::Gains { from: 0 });
        let (model, check, gains) = tuned(&tiny, config, target);
        let seen = tiny.setup().see(&model.scene, &gate, None);
        let left = target.margin_db(seen.quality);
        assert!(target.passes(seen.quality) && left < 0.1 * slack_db, "{left} of {slack_db} dB");
        assert_eq!(check.seen, seen, "the check is that of the model with its gains");
        let [_, green, blue] = gains.expect("there is something to spend").0;
        assert!(blue < green && green < 1.0, "blue costs most on this panel: {gains:?}");
        assert!(seen.display_w < before.display_w, "{seen:?}");
    }
    // With nothing to spare nothing is spent.
    let target = Target::Likeness(Quality::likeness(before.quality.psnr_db + 3.0, 0.0));
    let (_, check, gains) = tuned(&tiny, config(2, DisplayTerm::Gains { from: 0 }), target);
    assert!(gains.is_none() && !check.passed);
}

#[test]
fn a_level_of_the_periphery_spends_its_slack_in_hvsq_and_shares_all_but_its_paint() {
    let tiny = noisy(0.1);
    let gate = tiny.setup().gate_views().to_vec();
    let pooling = 3.0;
    let before = tiny.setup().see(&tiny.dense, &gate, Some(pooling));
    for share in [1.1, 4.0] {
        let target = Target::Hvsq(share * before.quality.hvsq.unwrap());
        let config = TuneConfig {
            objective: Objective::Hvsq { pooling },
            trains: Trains::ColoursAndOpacities,
            ..config(2, DisplayTerm::Gains { from: 0 })
        };
        let (model, check, gains) = tuned(&tiny, config, target);
        let seen = tiny.setup().see(&model.scene, &gate, Some(pooling));
        let (slack_db, left) = (10.0 * f64::log10(share), target.margin_db(seen.quality));
        assert!(target.passes(seen.quality) && left < 0.2 * slack_db, "{left} of {slack_db} dB");
        assert_eq!(check.seen, seen);
        assert!(gains.is_some() && seen.display_w < before.display_w, "{seen:?}");
        let levels = [&tiny.dense, &model.scene, &model.scene, &model.scene].map(Clone::clone);
        let foveated = Foveated::compose(&levels).expect("they share all but their paint");
        assert_eq!(foveated.level(1), model.scene);
        // Taken back, what is left is what two steps have moved.
        let mut bright = model.scene.clone();
        gains.unwrap().undo(&mut bright, config.trains);
        let again = tiny.setup().see(&bright, &gate, Some(pooling));
        assert!((again.display_w / before.display_w - 1.0).abs() < 0.01, "{again:?} {before:?}");
    }
}

#[test]
fn gains_buy_more_than_a_display_term_does_in_as_many_few_iterations() {
    let tiny = noisy(0.05);
    let gate = tiny.setup().gate_views().to_vec();
    let before = tiny.setup().see(&tiny.dense, &gate, None);
    let quality = Quality::likeness(before.quality.psnr_db - 3.0, 0.0);
    let target = Target::Likeness(quality);
    let control = Control {
        rule: LambdaRule::Damped,
        start: 0.05 / before.display_w,
        is_estimated: true,
        interval: 3,
        adjust: 27,
        epsilon_db: 0.05,
    };
    // Where the term has arrived, after 120, both buy the same here.
    let with = |display| {
        let (model, _, _) = tuned(&tiny, config(30, display), target);
        let seen = tiny.setup().see(&model.scene, &gate, None);
        assert!(target.passes(seen.quality), "{seen:?}");
        seen.display_w / before.display_w
    };
    let gains = with(DisplayTerm::Gains { from: 0 });
    let term = with(DisplayTerm::Controlled { from: 0, control });
    assert!(gains < term && term < 1.0, "{gains} and {term} of the display power");
}

#[test]
fn a_fine_tune_that_was_interrupted_ends_with_the_same_gains() {
    let tiny = noisy(0.1);
    let setup = tiny.setup();
    let before = setup.see(&tiny.dense, setup.gate_views(), None);
    let target = Target::Likeness(Quality::likeness(before.quality.psnr_db - 1.0, 0.0));
    let config = config(6, DisplayTerm::Gains { from: 0 });
    let end = |state: State, stop: u32| {
        let mut tuner = Tuner::new(&setup, config, target, 5, state);
        while !tuner.is_done() && tuner.state().iteration < stop {
            tuner.step().unwrap();
        }
        tuner.state().clone()
    };
    let whole = end(State::begin(Model::fresh(&tiny.dense)), u32::MAX);
    assert!(whole.spent.is_some());
    for stop in [1, 5, 6] {
        let half = end(State::begin(Model::fresh(&tiny.dense)), stop);
        assert_eq!(end(half, u32::MAX), whole, "stopped after {stop}");
    }
}
