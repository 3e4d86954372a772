//! Records in formats of their own: the numbers that are read, and fine-tunes that count with them.

use std::collections::BTreeSet;
use std::num::NonZeroU32;

use powergs_base::number::NumberFormat;
use powergs_optimize::prune::{Score, select};
use powergs_optimize::record::{RecordFormats, codebook};
use powergs_optimize::target::{Quality, Target};
use powergs_optimize::tune::{
    DisplayTerm, Keep, Model, Objective, Pace, Pruning, State, Trains, TuneConfig, Tuner,
};
use powergs_scene::Gaussians;

use super::scenes::{Tiny, tiny};

fn format(text: &str) -> Option<NumberFormat> {
    Some(text.parse().unwrap())
}

/// Few bits for everything but the centres.
fn coarse() -> RecordFormats {
    RecordFormats {
        position: None,
        scale: format("e5m3"),
        rotation: format("e4m3"),
        opacity: format("e4m3"),
        colour_dc: format("e4m3"),
        colour_rest: format("e4m3"),
        codebook: None,
    }
}

/// So many entries for the colours beyond the constant one, nothing else.
fn book(entries: u32) -> RecordFormats {
    RecordFormats { codebook: NonZeroU32::new(entries), ..RecordFormats::default() }
}

#[test]
fn every_format_reads_the_nearest_of_its_numbers() {
    for exponent in 2..=8 {
        for mantissa in 1..=13 {
            let Ok(format) = NumberFormat::new(exponent, mantissa) else { continue };
            let largest = format.to_f32(format.largest());
            let least = format.to_f32(1);
            let mut values = vec![0.0, -0.0, least / 2.0, -least * 1.5, largest, 2.0 * largest];
            // Over the whole range, and a little above and below halves of a step.
            let (mut x, end) = (least / 3.0, largest.min(1e30));
            while x < end {
                values.extend([x, -x]);
                x *= 1.037;
            }
            let numbers: Vec<u16> =
                format.all().filter(|n| format.to_f64(*n).is_finite()).collect();
            for pair in numbers.windows(2) {
                let half = (format.to_f64(pair[0]) + format.to_f64(pair[1])) / 2.0;
                values.extend([half as f32, half as f32 * 1.000_001]);
            }
            values.truncate(values.len() / 3 * 3);
            let means: Vec<[f32; 3]> = values.as_chunks().0.to_vec();
            let n = means.len();
            let scene = Gaussians {
                means,
                log_scales: vec![[0.0; 3]; n],
                rotations: vec![[1.0, 0.0, 0.0, 0.0]; n],
                logit_opacities: vec![0.0; n],
                sh: vec![0.0; 3 * n],
                ..Gaussians::default()
            };
            let formats = RecordFormats { position: Some(format), ..RecordFormats::default() };
            let read = formats.read(&scene);
            for (value, got) in values.iter().zip(read.means.as_flattened()) {
                let nearest = format.to_f32(format.from_f32(*value));
                let wanted = nearest.clamp(-largest, largest);
                assert_eq!(got.to_bits(), wanted.to_bits(), "{format}: {value:e}");
            }
        }
    }
}

#[test]
fn what_is_read_is_finite_and_reads_as_itself() {
    let mut scene = tiny(60, 8, (16, 16)).dense;
    scene.log_scales[0] = [-40.0, 30.0, 0.0];
    scene.logit_opacities[..2].copy_from_slice(&[-60.0, 60.0]);
    scene.rotations[0] = [1e-3, -2e-3, 0.0, 5e-4];
    let once = coarse().read(&scene);
    for list in [
        once.log_scales.as_flattened(),
        once.rotations.as_flattened(),
        &once.logit_opacities,
        &once.sh,
    ] {
        assert!(list.iter().all(|x| x.is_finite()));
    }
    assert_eq!(once.means, scene.means);
    assert_ne!(once.sh, scene.sh);
    let length = |q: &[f32; 4]| q.iter().map(|x| x * x).sum::<f32>().sqrt();
    assert!((length(&once.rotations[0]) / length(&scene.rotations[0]) - 1.0).abs() < 0.05);
    let twice = coarse().read(&once);
    let near = |a: &[f32], b: &[f32]| {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-4 * a.abs().max(1.0))
    };
    assert!(near(once.log_scales.as_flattened(), twice.log_scales.as_flattened()));
    assert!(near(&once.logit_opacities, &twice.logit_opacities));
    assert!(near(&once.sh, &twice.sh));
    assert_eq!(RecordFormats::default().read(&scene), scene);
}

fn config(iterations: u32) -> TuneConfig {
    TuneConfig {
        iterations,
        pruning: Pruning::Never,
        display: DisplayTerm::Off,
        objective: Objective::Likeness,
        trains: Trains::All,
        keep: Keep::Last,
        pace: Pace::PUBLISHED,
    }
}

const TARGET: Target = Target::Likeness(Quality::likeness(60.0, 0.999));

fn tuned(tiny: &Tiny, start: &Gaussians, formats: RecordFormats, iterations: u32) -> Model {
    let setup = tiny.setup();
    let state = State::begin(Model::fresh(start));
    let mut tuner = Tuner::new(&setup, config(iterations), TARGET, 5, state).reading(formats);
    while !tuner.is_done() {
        tuner.step().unwrap();
    }
    tuner.state().model.clone()
}

#[test]
fn gradients_are_those_of_the_numbers_that_are_read_and_go_straight_through() {
    let tiny = tiny(200, 8, (40, 30));
    let through = tuned(&tiny, &tiny.dense, coarse(), 1);
    let of_read = tuned(&tiny, &coarse().read(&tiny.dense), RecordFormats::default(), 1);
    let exact = tuned(&tiny, &tiny.dense, RecordFormats::default(), 1);
    assert_eq!(through.adam, of_read.adam);
    assert_ne!(through.adam, exact.adam);
    // The step is taken from the parameters as they are, not from the numbers.
    let moved = |after: &Gaussians, before: &Gaussians| -> Vec<f32> {
        after.sh.iter().zip(&before.sh).map(|(a, b)| a - b).collect()
    };
    let step = moved(&of_read.scene, &coarse().read(&tiny.dense));
    for (a, b) in moved(&through.scene, &tiny.dense).iter().zip(step) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn a_fine_tune_that_counts_with_coarse_numbers_ends_better_than_rounding_does() {
    let tiny = tiny(300, 6, (48, 36));
    let setup = tiny.setup();
    let seen = |scene: &Gaussians| setup.see(scene, &tiny.split.train, None).quality.psnr_db;
    let rounded = seen(&coarse().read(&tiny.dense));
    let exact = tuned(&tiny, &tiny.dense, RecordFormats::default(), 80);
    let afterwards = seen(&coarse().read(&exact.scene));
    let through = tuned(&tiny, &tiny.dense, coarse(), 80);
    let with = seen(&coarse().read(&through.scene));
    assert!(with > rounded + 1.0 && with > afterwards + 0.3, "{with} {afterwards} {rounded}");
}

#[test]
fn it_goes_on_bit_for_bit() {
    let tiny = tiny(200, 8, (40, 30));
    let setup = tiny.setup();
    let tuner = |state| Tuner::new(&setup, config(9), TARGET, 5, state).reading(coarse());
    let mut whole = tuner(State::begin(Model::fresh(&tiny.dense)));
    while !whole.is_done() {
        whole.step().unwrap();
    }
    let mut first = tuner(State::begin(Model::fresh(&tiny.dense)));
    for _ in 0..4 {
        first.step().unwrap();
    }
    let mut second = tuner(first.state().clone());
    while !second.is_done() {
        second.step().unwrap();
    }
    assert_eq!(second.state(), whole.state());
}

/// The coefficients beyond the constant one, by Gaussian.
fn others(scene: &Gaussians) -> Vec<Vec<u32>> {
    let each = scene.sh_coefficients();
    let channels = |sh: &[f32]| {
        let others = sh.chunks(each).flat_map(|channel| &channel[1..]);
        others.map(|x| x.to_bits()).collect()
    };
    scene.sh.chunks(3 * each).map(channels).collect()
}

#[test]
fn a_codebook_has_so_many_colours_and_each_takes_the_nearest() {
    let dense = tiny(400, 8, (16, 16)).dense;
    let read = book(16).read(&dense);
    let entries: BTreeSet<Vec<u32>> = others(&read).into_iter().collect();
    assert!((2..=16).contains(&entries.len()), "{} entries", entries.len());
    let each = dense.sh_coefficients();
    for (a, b) in read.sh.chunks(each).zip(dense.sh.chunks(each)) {
        assert_eq!(a[0], b[0], "the constant coefficient is its own");
    }
    assert_eq!(Gaussians { sh: dense.sh.clone(), ..read.clone() }, dense);
    let square = |a: &[u32], b: &[u32]| -> f64 {
        let d = |(a, b): (&u32, &u32)| f64::from(f32::from_bits(*a) - f32::from_bits(*b)).powi(2);
        a.iter().zip(b).map(d).sum()
    };
    // Means of those who took an entry are not the entries that they took; nearly all still have
    // the nearest.
    let (own, shared) = (others(&dense), others(&read));
    let is_nearest = |(own, shared): (&Vec<u32>, &Vec<u32>)| {
        let here = square(own, shared);
        entries.iter().all(|entry| square(own, entry) >= here)
    };
    let nearest = own.iter().zip(&shared).filter(|pair| is_nearest(*pair)).count();
    assert!(nearest > 340, "{nearest} of 400");
    // More entries lose less, and with one for each nothing is lost.
    let error = |read: &Gaussians| -> f64 {
        own.iter().zip(&others(read)).map(|(a, b)| square(a, b)).sum()
    };
    let errors = [2, 16, 128, 1000].map(|n| error(&book(n).read(&dense)));
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
    assert_eq!(errors[3], 0.0);
}

#[test]
fn labels_do_not_depend_on_the_number_of_threads() {
    let dense = tiny(500, 8, (16, 16)).dense;
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| codebook::labels(&dense, 32))
    };
    assert_eq!(with(1), with(3));
    let flat = Gaussians { sh_degree: 0, sh: vec![0.5; 3 * dense.len()], ..dense };
    assert_eq!(codebook::labels(&flat, 32), [0; 0], "constant colours have no entries");
    assert_eq!(book(32).read(&flat), flat);
}

#[test]
fn a_codebook_that_is_trained_with_is_better_than_one_that_is_made_afterwards() {
    let tiny = tiny(300, 6, (48, 36));
    let setup = tiny.setup();
    let seen = |scene: &Gaussians| setup.see(scene, &tiny.split.train, None).quality.psnr_db;
    let made = seen(&book(4).read(&tiny.dense));
    let exact = tuned(&tiny, &tiny.dense, RecordFormats::default(), 120);
    let afterwards = seen(&book(4).read(&exact.scene));
    let state = State::begin(Model::fresh(&tiny.dense));
    let mut tuner = Tuner::new(&setup, config(120), TARGET, 5, state).reading(book(4));
    while !tuner.is_done() {
        tuner.step().unwrap();
    }
    let (model, check, _) = tuner.finish();
    let entries: BTreeSet<Vec<u32>> = others(&model.scene).into_iter().collect();
    assert!(entries.len() <= 4, "what it ends with is what is read");
    let found = setup.see(&model.scene, setup.gate_views(), None).quality.psnr_db;
    assert!((check.unwrap().seen.quality.psnr_db - found).abs() < 0.3, "as it was checked");
    let with = seen(&model.scene);
    assert!(with > made + 1.0 && with > afterwards + 0.3, "{with} {afterwards} {made}");
}

#[test]
fn it_goes_on_bit_for_bit_with_a_codebook() {
    let tiny = tiny(200, 8, (40, 30));
    let setup = tiny.setup();
    let steps = NonZeroU32::new(2).unwrap();
    let pruning = Pruning::Steps { score: Score::Dominance, goal: 150, steps, every: 20 };
    let config = TuneConfig { pruning, ..config(55) };
    let formats = RecordFormats { colour_rest: format("e4m3"), ..book(8) };
    let tuner = |state| Tuner::new(&setup, config, TARGET, 5, state).reading(formats);
    let mut whole = tuner(State::begin(Model::fresh(&tiny.dense)));
    while !whole.is_done() {
        whole.step().unwrap();
    }
    for stop in [10, 30, 52] {
        let mut first = tuner(State::begin(Model::fresh(&tiny.dense)));
        for _ in 0..stop {
            first.step().unwrap();
        }
        let mut second = tuner(first.state().clone());
        while !second.is_done() {
            second.step().unwrap();
        }
        assert_eq!(second.state(), whole.state(), "stopped after {stop}");
    }
    assert_eq!(whole.state().labels.len(), 150);
}

#[test]
fn a_model_that_is_pruned_below_the_entries_has_one_for_each() {
    let tiny = tiny(200, 8, (40, 30));
    let mut labels = codebook::labels(&tiny.dense, 160);
    let mut few = tiny.dense.clone();
    let kept: Vec<u32> = (0..200).rev().step_by(4).rev().collect();
    select(&mut few, &kept);
    labels = kept.iter().map(|&i| labels[i as usize]).collect();
    assert!(labels.iter().any(|&label| label >= 50), "numbers of entries that are gone");
    codebook::relabel(&few, &mut labels, 160);
    assert_eq!(labels, (0..50).collect::<Vec<u32>>());
    // Pruned below them between two looks for the nearest, and looked for again.
    let setup = tiny.setup();
    let steps = NonZeroU32::new(2).unwrap();
    let pruning = Pruning::Steps { score: Score::Dominance, goal: 120, steps, every: 20 };
    let config = TuneConfig { pruning, ..config(55) };
    let state = State::begin(Model::fresh(&tiny.dense));
    let mut tuner = Tuner::new(&setup, config, TARGET, 5, state).reading(book(160));
    let mut shared = Vec::new();
    while !tuner.is_done() {
        tuner.step().unwrap();
        let labels = &tuner.state().labels;
        shared.push(labels.len() - labels.iter().collect::<BTreeSet<_>>().len());
    }
    assert!(shared[10] > 10 && shared[30] > 10, "160, then 120 of 200 are left: {shared:?}");
    assert_eq!((shared[54], tuner.state().labels.len()), (0, 120));
    let state = tuner.state().clone();
    let (model, ..) = tuner.finish();
    assert_eq!(model.scene, state.model.scene, "each its own is what it is");
}
