//! Training from nothing: the published rules one by one, and a small scene.

use powergs_core::run::MemoryStore;
use powergs_optimize::adam::Adam;
use powergs_optimize::checkpoint::Checkpoints;
use powergs_optimize::references::Reference;
use powergs_optimize::train::densify::{Density, Observed, densify, reset_opacities};
use powergs_optimize::train::start::{around, scattered};
use powergs_optimize::train::{
    TrainInputs, TrainRules, TrainState, TrainStep, Trainer, nearest_three,
};
use powergs_optimize::tune::Model;
use powergs_raster::{Detail, Options, render};
use powergs_scene::camera::orbit::SceneBounds;
use powergs_scene::camera::views::OrbitRequest;
use powergs_scene::{Camera, Gaussians};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

#[test]
fn neighbours_are_the_nearest() {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    // Coarse places, so that some points are the same and many distances are equal.
    let mut place = || -> [f32; 3] { std::array::from_fn(|_| rng.random_range(-9..9) as f32) };
    for n in [0, 1, 2, 3, 9, 400] {
        let points: Vec<[f32; 3]> = (0..n).map(|_| place()).collect();
        let naive = |i: usize| {
            let square =
                |j: usize| -> f32 { (0..3).map(|k| (points[i][k] - points[j][k]).powi(2)).sum() };
            let mut all: Vec<f32> = (0..n).filter(|j| *j != i).map(square).collect();
            all.sort_by(f32::total_cmp);
            all.truncate(3);
            all.iter().sum::<f32>() / all.len().max(1) as f32
        };
        let wanted: Vec<f32> = (0..n).map(naive).collect();
        assert_eq!(nearest_three(&points), wanted, "{n} points");
    }
}

#[test]
fn points_become_gaussians() {
    let scene = around(&[[0.0; 3], [2.0, 0.0, 0.0], [2.0; 3]], &[[0.5; 3], [1.0; 3], [0.0; 3]]);
    // The first has neighbours at squared distances of 4 and 12.
    assert!((scene.log_scales[0][1] - 8.0_f32.sqrt().ln()).abs() < 1e-6);
    assert!((scene.logit_opacities[2] - (0.1_f32 / 0.9).ln()).abs() < 1e-6);
    assert_eq!((scene.sh_degree, scene.sh[0]), (0, 0.0));
    assert!((scene.sh[3] - 0.5 / 0.282_094_8).abs() < 1e-4);
    // Points in one place still have a size.
    assert!(
        (around(&[[1.0; 3]; 2], &[[0.5; 3]; 2]).log_scales[0][0] - 0.5 * 1e-7_f32.ln()).abs()
            < 1e-4
    );
}

#[test]
fn the_schedule_is_the_published_one() {
    let rules = TrainRules::published(30_000);
    let densified: Vec<u32> = (1..=30_000).filter(|i| rules.densifies(*i)).collect();
    assert_eq!((densified[0], densified[1]), (600, 700));
    assert_eq!((densified.last(), densified.len()), (Some(&14_900), 144));
    let resets = |white| -> Vec<u32> { (1..=30_000).filter(|i| rules.resets(*i, white)).collect() };
    assert_eq!(resets(false), [3000, 6000, 9000, 12_000]);
    assert_eq!(resets(true), [500, 3000, 6000, 9000, 12_000]);
    assert_eq!([999, 1000, 2999, 3000, 9000].map(|i| rules.degree(i)), [0, 1, 2, 3, 3]);
    let means = |i| rules.rates(i, 2.0).means;
    assert!((means(0) - 3.2e-4).abs() < 1e-12 && (means(30_000) - 3.2e-6).abs() < 1e-12);
    assert!((means(15_000) - 3.2e-5).abs() < 1e-12);
    assert!((rules.rates(7, 2.0).sh_rest - 1.25e-4).abs() < 1e-12);
    // A tenth of the iterations: a tenth of the intervals.
    let short = TrainRules::published(3000);
    let intervals = [short.sh_every, short.densify_from, short.densify_until, short.reset_every];
    assert_eq!(intervals, [100, 50, 1500, 300]);
    assert!(TrainRules::published(1).check().is_ok());
    let wrong = TrainRules { densify_slope: f64::NAN, ..rules };
    assert!(wrong.check().unwrap_err().to_string().starts_with("densify_slope NaN"));
}

/// A Gaussian of the restated rules.
#[derive(Clone, Debug, PartialEq)]
struct One {
    scene: Gaussians,
    first: Gaussians,
    second: Gaussians,
    steps: u32,
}

fn one(scene: &Gaussians, i: usize) -> Gaussians {
    Gaussians {
        means: vec![scene.means[i]],
        log_scales: vec![scene.log_scales[i]],
        rotations: vec![scene.rotations[i]],
        logit_opacities: vec![scene.logit_opacities[i]],
        sh_degree: scene.sh_degree,
        sh: scene.sh_of(i).to_vec(),
        antialiased: false,
    }
}

fn ones(model: &Model) -> Vec<One> {
    let Model { scene, adam: Adam { first, second, steps } } = model;
    let of = |i| One {
        scene: one(scene, i),
        first: one(first, i),
        second: one(second, i),
        steps: steps[i],
    };
    (0..scene.len()).map(of).collect()
}

/// Random parameters of `n` Gaussians.
fn random_scene(seed: u64, n: usize, degree: u8) -> Gaussians {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut scene = Gaussians { sh_degree: degree, ..Gaussians::default() };
    for _ in 0..n {
        scene.means.push(std::array::from_fn(|_| rng.random_range(-3.0..3.0f32)));
        scene.log_scales.push(std::array::from_fn(|_| rng.random_range(-5.0..-0.5f32)));
        scene.rotations.push(std::array::from_fn(|_| rng.random_range(-1.0..1.0f32)));
        scene.logit_opacities.push(rng.random_range(-6.0..6.0));
        for _ in 0..3 * scene.sh_coefficients() {
            scene.sh.push(rng.random_range(-0.7..0.7));
        }
    }
    scene
}

/// A model with moments that differ in every place.
fn moving(seed: u64, n: usize) -> (Model, Observed) {
    let mut model = Model::fresh(&random_scene(seed, n, 1));
    model.adam.first = random_scene(seed + 1, n, 1);
    model.adam.second = random_scene(seed + 2, n, 1);
    model.adam.steps = (0..n as u32).collect();
    let mut observed = Observed::new(n);
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    for i in 0..n {
        observed.views[i] = rng.random_range(0..4);
        observed.slopes[i] = observed.views[i] as f32 * rng.random_range(0.0..2.0);
        observed.radii[i] = rng.random_range(1.0..40.0);
    }
    (model, observed)
}

const DENSITY: Density = Density {
    slope: 1.0,
    split_scale: 0.1,
    prune_opacity: 0.1,
    prune_scale: Some(0.3),
    prune_radius: Some(35.0),
    most: 10_000,
    seed: 4,
};

#[test]
fn densification_follows_the_published_rules() {
    let (mut model, mut observed) = moving(11, 300);
    let (before, seen) = (ones(&model), observed.clone());
    let done = densify(&mut model, &mut observed, &DENSITY);
    let largest = |one: &One| one.scene.log_scales[0].map(f32::exp).into_iter().fold(0.0, f32::max);
    let mean = |i: usize| seen.slopes[i] / (seen.views[i] as f32).max(1.0);
    let is_hot = |i: usize| seen.views[i] > 0 && mean(i) >= 1.0;
    let goes = |one: &One, radius: f32| {
        let opacity = 1.0 / (1.0 + (-one.scene.logit_opacities[0]).exp());
        opacity < 0.1 || largest(one) > 0.3 || radius > 35.0
    };
    let still = |one: &One| {
        let zeros = Adam::new(&one.scene);
        One { first: zeros.first, second: zeros.second, ..one.clone() }
    };
    let all: Vec<usize> = (0..before.len()).collect();
    let clones: Vec<usize> =
        all.iter().copied().filter(|i| is_hot(*i) && largest(&before[*i]) <= 0.1).collect();
    let splits: Vec<usize> =
        all.iter().copied().filter(|i| is_hot(*i) && largest(&before[*i]) > 0.1).collect();
    let stay = all.iter().filter(|i| !splits.contains(i));
    let stay = stay.filter(|i| !goes(&before[**i], seen.radii[**i])).map(|i| before[*i].clone());
    let copies = clones.iter().map(|i| still(&before[*i])).filter(|one| !goes(one, 0.0));
    let after = ones(&model);
    let wanted: Vec<One> = stay.chain(copies).collect();
    assert_eq!(after[..wanted.len()], wanted);
    assert_eq!((done.cloned, done.split, done.is_capped), (clones.len(), splits.len(), false));
    assert_eq!(observed, Observed::new(after.len()));
    // Children: first ones, then second ones, smaller, near their parents.
    let children: Vec<One> = splits
        .iter()
        .cycle()
        .take(2 * splits.len())
        .map(|i| {
            let mut child = still(&before[*i]);
            child.scene.log_scales[0] = child.scene.log_scales[0].map(|s| s - 1.6_f32.ln());
            child
        })
        .filter(|child| !goes(child, 0.0))
        .collect();
    let got = &after[wanted.len()..];
    assert!(got.len() > 10 && got.len() == children.len(), "{} {}", got.len(), children.len());
    assert_eq!(before.len() + clones.len() + splits.len() - done.pruned, after.len());
    for (got, wanted) in got.iter().zip(&children) {
        let far: f32 = (0..3)
            .map(|k| (got.scene.means[0][k] - wanted.scene.means[0][k]).powi(2))
            .sum::<f32>()
            .sqrt();
        assert!(far > 0.0 && far < 6.0 * 1.6 * largest(wanted), "{far}");
        let mut same = got.clone();
        same.scene.means.clone_from(&wanted.scene.means);
        assert_eq!(same, *wanted);
    }
    // Another seed has other places, the same one the same.
    let places = |seed| {
        let (mut model, mut observed) = moving(11, 300);
        densify(&mut model, &mut observed, &Density { seed, ..DENSITY });
        model.scene.means
    };
    assert_eq!(places(4), model.scene.means);
    assert_ne!(places(5), model.scene.means);
}

#[test]
fn children_lie_as_their_parent_is_spread() {
    let scene = Gaussians {
        means: vec![[1.0, 2.0, 3.0]; 4000],
        log_scales: vec![[0.4_f32.ln(), 0.05_f32.ln(), 0.02_f32.ln()]; 4000],
        // A quarter turn about z: the long axis is y.
        rotations: vec![[1.0, 0.0, 0.0, 1.0]; 4000],
        logit_opacities: vec![0.0; 4000],
        sh_degree: 0,
        sh: vec![0.0; 12_000],
        antialiased: false,
    };
    let mut model = Model::fresh(&scene);
    let mut observed = Observed::new(4000);
    observed.views.fill(1);
    observed.slopes.fill(2.0);
    let rule = Density { prune_scale: None, prune_radius: None, ..DENSITY };
    assert_eq!(densify(&mut model, &mut observed, &rule).split, 4000);
    assert_eq!(model.scene.len(), 8000);
    for (axis, (mean, wanted)) in [(1.0, 0.05), (2.0, 0.4), (3.0, 0.02)].into_iter().enumerate() {
        let off = |m: &[f32; 3]| (f64::from(m[axis]) - mean).powi(2);
        let spread = (model.scene.means.iter().map(off).sum::<f64>() / 8000.0).sqrt();
        assert!((spread / wanted - 1.0).abs() < 0.04, "axis {axis}: {spread}, {wanted}");
    }
}

#[test]
fn a_cap_stops_what_adds_and_not_what_prunes() {
    let (mut model, mut observed) = moving(11, 300);
    let done = densify(&mut model, &mut observed, &Density { most: 300, ..DENSITY });
    assert_eq!((done.cloned, done.split, done.is_capped), (0, 0, true));
    assert_eq!(model.scene.len(), 300 - done.pruned);
    assert!(done.pruned > 0);
}

#[test]
fn a_reset_limits_opacities_and_forgets_their_moments() {
    let (mut model, _) = moving(3, 50);
    let before = model.clone();
    reset_opacities(&mut model);
    let most = (0.01_f32 / 0.99).ln();
    let wanted: Vec<f32> = before.scene.logit_opacities.iter().map(|o| o.min(most)).collect();
    let mut expected = before;
    expected.scene.logit_opacities = wanted;
    expected.adam.first.logit_opacities = vec![0.0; 50];
    expected.adam.second.logit_opacities = vec![0.0; 50];
    assert_eq!(model, expected);
}

/// A small scene in small pictures.
struct Small {
    cameras: Vec<Camera>,
    references: Vec<Reference>,
    train: Vec<usize>,
    held_out: Vec<usize>,
    rules: TrainRules,
    start: Gaussians,
}

fn small() -> Small {
    let mut rng = Pcg64Mcg::seed_from_u64(21);
    let mut scene = Gaussians::default();
    for _ in 0..150 {
        scene.means.push(std::array::from_fn(|_| rng.random_range(-1.0..1.0f32)));
        scene.log_scales.push(std::array::from_fn(|_| rng.random_range(-2.5..-1.2f32)));
        scene.rotations.push(std::array::from_fn(|_| rng.random_range(-1.0..1.0f32)));
        scene.logit_opacities.push(rng.random_range(0.0..4.0));
        scene.sh.extend::<[f32; 3]>(std::array::from_fn(|_| rng.random_range(-1.5..1.5)));
    }
    let orbit = |elevation: f64| {
        let request = OrbitRequest {
            views: 12,
            elevation_deg: Some(elevation),
            radius: Some(4.0),
            fov_deg: Some(40.0),
            up: glam::DVec3::Z,
            size: Some((48, 48)),
        };
        request.cameras(|| SceneBounds::of(&scene)).unwrap()
    };
    let cameras: Vec<Camera> = [orbit(15.0), orbit(50.0)].concat();
    let options = Options::reference(Detail::Image);
    let picture = |c: &Camera| Reference::new(&render(&scene, c, &options).picture);
    let references: Vec<Reference> = cameras.iter().map(picture).collect();
    let (held_out, train) = (0..cameras.len()).partition(|i| i.is_multiple_of(8));
    let (positions, colours) = scattered(&cameras, 300, 0.3, 9);
    let rules = TrainRules {
        densify_from: 60,
        densify_until: 200,
        densify_every: 20,
        reset_every: 150,
        sh_every: 80,
        // Few iterations need long steps.
        position_rate: 1e-3,
        ..TrainRules::published(300)
    };
    let start = around(&positions, &colours);
    Small { cameras, references, train, held_out, rules, start }
}

impl Small {
    fn inputs(&self) -> TrainInputs<'_> {
        TrainInputs {
            cameras: &self.cameras,
            references: &self.references,
            train: &self.train,
            held_out: &self.held_out,
            background: [0.0; 3],
            rules: &self.rules,
        }
    }

    fn threads<T: Send>(n: usize, work: impl FnOnce() -> T + Send) -> T {
        rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(work)
    }
}

fn to_end(trainer: &mut Trainer<'_>) -> Vec<TrainStep> {
    let mut steps = Vec::new();
    while !trainer.is_done() {
        steps.push(trainer.step().unwrap());
    }
    steps
}

#[test]
fn a_scene_is_learned_from_random_points() {
    let small = small();
    let mut trainer = Trainer::new(small.inputs(), TrainState::begin(&small.start));
    let before = trainer.held_out().unwrap();
    let steps = to_end(&mut trainer);
    let after = trainer.held_out().unwrap();
    let split: usize = steps.iter().filter_map(|s| s.densified).map(|d| d.split + d.cloned).sum();
    println!("{before:?} {after:?} {} Gaussians, {split} added", trainer.scene().len());
    assert!(after.psnr_db > before.psnr_db + 7.0, "{before:?} {after:?}");
    assert!(split > 100 && trainer.scene().len() > small.start.len());
    assert_eq!(trainer.scene().sh_degree, 3);
    let is_reset: Vec<u32> = steps.iter().filter(|s| s.is_reset).map(|s| s.iteration).collect();
    assert_eq!(is_reset, [150]);
}

#[test]
fn threads_and_interruptions_change_nothing() {
    let small = small();
    let begin = || Trainer::new(small.inputs(), TrainState::begin(&small.start));
    let whole = Small::threads(1, || {
        let mut trainer = begin();
        to_end(&mut trainer);
        trainer.state().clone()
    });
    // Interrupted between two densifications, when much has been seen and nothing is due.
    let store = MemoryStore::new();
    let print = small.inputs().fingerprint(&small.start);
    let checkpoints = Checkpoints::new(&store, print);
    Small::threads(2, || {
        let mut trainer = begin();
        for _ in 0..111 {
            trainer.step().unwrap();
        }
        checkpoints.save_training("train.ckpt", trainer.state()).unwrap();
    });
    let state = checkpoints.load_training("train.ckpt").unwrap().unwrap();
    assert_eq!((state.iteration, state.model.scene.sh_degree), (111, 1));
    let resumed = Small::threads(2, || {
        let mut trainer = Trainer::new(small.inputs(), state);
        to_end(&mut trainer);
        trainer.state().clone()
    });
    assert_eq!(resumed, whole);
    // A training by other rules, or from other points, is another one.
    let rules = TrainRules { seed: 1, ..small.rules.clone() };
    let other = TrainInputs { rules: &rules, ..small.inputs() }.fingerprint(&small.start);
    assert_ne!(other, print);
    let error = Checkpoints::new(&store, other).load_training("train.ckpt").unwrap_err();
    assert!(error.to_string().contains("other inputs or settings"), "{error}");
    let mut start = small.start.clone();
    start.means[7][0] += 1e-3;
    assert_ne!(small.inputs().fingerprint(&start), print);
    assert!(checkpoints.load_training("none.ckpt").unwrap().is_none());
    assert!(checkpoints.load().is_ok_and(|progress| progress.is_none()));
}

#[test]
fn a_training_stops_adding_at_its_cap() {
    let mut small = small();
    small.rules.max_points = small.start.len() as u64 + 20;
    let mut trainer = Trainer::new(small.inputs(), TrainState::begin(&small.start));
    to_end(&mut trainer);
    assert!(trainer.state().is_capped);
    assert!(trainer.scene().len() as u64 <= small.rules.max_points);
}

#[test]
fn a_model_that_is_pruned_away_is_an_error() {
    let mut small = small();
    small.rules.prune_opacity = 0.1;
    small.rules.opacity_rate = 0.0;
    small.start.logit_opacities.fill(-4.0);
    let mut trainer = Trainer::new(small.inputs(), TrainState::begin(&small.start));
    let error = loop {
        if let Err(error) = trainer.step() {
            break error;
        }
    };
    let text = error.to_string();
    assert!(text.starts_with("iteration 80: all Gaussians were pruned"), "{text}");
}
