//! Adam against the formula in double precision, with gradients of real views.

use powergs_optimize::adam::{Adam, Group, Rates};
use powergs_optimize::prune;
use powergs_raster::train::{Gradients, Options, Tape, Which};
use powergs_scene::{Camera, Gaussians};

use super::scenes::tiny;

/// A scene of which each view sees a part, and gradients that change from step to step.
struct Course {
    scene: Gaussians,
    views: Vec<Camera>,
    tape: Tape,
    by_pixel: Vec<[f32; 3]>,
}

impl Course {
    fn new() -> Course {
        let tiny = tiny(60, 6, (24, 18));
        let mut scene = tiny.dense;
        // Seen by no view.
        scene.means[7] = [1e6, 1e6, 1e6];
        scene.log_scales[7] = [-9.0; 3];
        let by_pixel = vec![[0.0; 3]; 24 * 18];
        Course { scene, views: tiny.cameras, tape: Tape::new(), by_pixel }
    }

    /// Renders the view of a step, and makes up the gradient by its pixels.
    fn forward(&mut self, step: usize) {
        let camera = &self.views[step % self.views.len()];
        self.tape.forward(&self.scene, camera, &Options::reference());
        for (i, pixel) in self.by_pixel.iter_mut().enumerate() {
            let h = ((i + 1) * (2 * step + 3)) as u64;
            let h = h.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
            *pixel = [0.3, -0.2, 0.1].map(|w| w * (h as f32 / (1u64 << 24) as f32 - 0.4));
        }
    }

    fn gradients(&mut self) -> Gradients {
        let mut gradients = Gradients::new();
        self.tape.backward(&self.scene, &self.by_pixel, Which::All, &mut gradients);
        gradients
    }

    fn seen(&self) -> Vec<bool> {
        let mut seen = vec![false; self.scene.len()];
        self.tape.splats().iter().for_each(|splat| seen[splat.index as usize] = true);
        seen
    }

    fn step(&mut self, adam: &mut Adam, rates: &Rates) {
        let slopes = self.tape.slopes(&self.by_pixel, Which::All);
        adam.step(&mut self.scene, None, &slopes, rates).expect("finite gradients");
    }
}

const RATES: Rates = Rates {
    means: 1e-4,
    scales: 0.005,
    rotations: 0.001,
    opacities: 0.05,
    sh_dc: 0.0025,
    sh_rest: 0.000_125,
};

fn rate_of(group: Group, i: usize, coefficients: usize) -> f64 {
    match group {
        Group::Means => RATES.means,
        Group::Scales => RATES.scales,
        Group::Rotations => RATES.rotations,
        Group::Opacities => RATES.opacities,
        Group::Sh if i.is_multiple_of(coefficients) => RATES.sh_dc,
        Group::Sh => RATES.sh_rest,
    }
}

/// The rule in double precision: value, moments and steps of a parameter.
#[derive(Clone, Copy, Default)]
struct Exact {
    value: f64,
    first: f64,
    second: f64,
    steps: i32,
}

impl Exact {
    fn step(&mut self, slope: f64, rate: f64) {
        self.steps += 1;
        self.first = 0.9 * self.first + 0.1 * slope;
        self.second = 0.999 * self.second + 0.001 * slope * slope;
        let m = self.first / (1.0 - 0.9f64.powi(self.steps));
        let v = self.second / (1.0 - 0.999f64.powi(self.steps));
        self.value -= rate * m / (v.sqrt() + 1e-15);
    }
}

#[test]
fn fifty_steps_agree_with_double_precision_and_the_unseen_rest() {
    const STEPS: usize = 50;
    let mut course = Course::new();
    let mut adam = Adam::new(&course.scene);
    let points = course.scene.len();
    let coefficients = course.scene.sh_coefficients();
    let begin = |group: Group| -> Vec<Exact> {
        let values = group.of(&course.scene).iter();
        values.map(|v| Exact { value: f64::from(*v), ..Exact::default() }).collect()
    };
    let mut exact = Group::ALL.map(begin);
    let mut unseen = 0;
    for step in 0..STEPS {
        course.forward(step);
        let (gradients, seen) = (course.gradients(), course.seen());
        unseen += seen.iter().filter(|s| !**s).count();
        for ((group, slopes), exact) in Group::ALL.into_iter().zip(gradients.flat()).zip(&mut exact)
        {
            let width = slopes.len() / points;
            for (i, (slope, exact)) in slopes.iter().zip(exact).enumerate() {
                if seen[i / width] {
                    exact.step(f64::from(*slope), rate_of(group, i, coefficients));
                }
            }
        }
        course.step(&mut adam, &RATES);
    }
    assert!(unseen > STEPS, "hardly anything was out of sight: {unseen}");
    assert_eq!(adam.steps[7], 0);
    for (group, exact) in Group::ALL.into_iter().zip(&exact) {
        let width = exact.len() / points;
        for (i, (exact, p)) in exact.iter().zip(group.of(&course.scene)).enumerate() {
            assert_eq!(adam.steps[i / width] as i32, exact.steps, "{} {i}", group.name());
            // Fifty roundings of the value, and of steps of a few times the rate each.
            let rate = rate_of(group, i, coefficients);
            let tolerance = 50.0 * (exact.value.abs() * 6e-8 + rate * 1e-5);
            let off = (f64::from(*p) - exact.value).abs();
            assert!(off <= tolerance, "{} {i}: {p} is not {}", group.name(), exact.value);
        }
    }
}

#[test]
fn a_rate_of_zero_leaves_everything_alone() {
    let mut course = Course::new();
    let (before, mut adam) = (course.scene.clone(), Adam::new(&course.scene));
    course.forward(0);
    course.step(&mut adam, &RATES.colours_only());
    assert_ne!(course.scene.sh, before.sh);
    course.scene.sh.clone_from(&before.sh);
    assert_eq!(course.scene, before);
    assert!(adam.first.logit_opacities.iter().all(|m| *m == 0.0));
}

#[test]
fn a_parameter_without_gradient_does_not_move() {
    let mut course = Course::new();
    let (before, mut adam) = (course.scene.clone(), Adam::new(&course.scene));
    course.forward(0);
    course.by_pixel.fill([0.0; 3]);
    course.step(&mut adam, &RATES);
    assert_eq!(course.scene, before);
}

#[test]
fn a_bad_gradient_is_found_and_named() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let mut course = Course::new();
        course.forward(0);
        course.by_pixel.fill([bad; 3]);
        let gradients = course.gradients();
        let is_bad = |v: &f32| v.is_nan() || v.abs() > 1e18;
        let lists = gradients.flat();
        let mut adam = Adam::new(&course.scene);
        let slopes = course.tape.slopes(&course.by_pixel, Which::All);
        let found = adam.step(&mut course.scene, None, &slopes, &RATES).unwrap_err();
        let of = |gaussian: usize| {
            Group::ALL.into_iter().zip(lists).find_map(|(group, list)| {
                let width = list.len() / 60;
                let own = &list[gaussian * width..(gaussian + 1) * width];
                Some((group, own.iter().position(is_bad)?))
            })
        };
        assert_eq!(of(found.gaussian), Some((found.group, found.position)));
        assert!((0..found.gaussian).all(|gaussian| of(gaussian).is_none()), "not the first");
    }
}

#[test]
fn moments_follow_their_gaussians() {
    let mut course = Course::new();
    let mut adam = Adam::new(&course.scene);
    course.forward(0);
    course.step(&mut adam, &RATES);
    let mut pruned = course.scene;
    let (whole, moments) = (pruned.clone(), adam.clone());
    let kept = [0, 3, 4, 20, 39];
    prune::keep(&mut pruned, &mut adam, &kept, 1.0);
    assert_eq!(pruned.len(), 5);
    for (to, from) in kept.into_iter().map(|i| i as usize).enumerate() {
        for (now, old) in
            [(&pruned, &whole), (&adam.first, &moments.first), (&adam.second, &moments.second)]
        {
            assert_eq!(now.means[to], old.means[from]);
            assert_eq!(now.log_scales[to], old.log_scales[from]);
            assert_eq!(now.rotations[to], old.rotations[from]);
            assert_eq!(now.logit_opacities[to], old.logit_opacities[from]);
            assert_eq!(now.sh_of(to), old.sh_of(from));
        }
        assert_eq!(adam.steps[to], moments.steps[from]);
    }
    assert_eq!(adam.steps.len(), 5);
    assert!(adam.steps.contains(&1));
}

#[test]
fn the_opacity_cap_limits_and_forgets() {
    let mut course = Course::new();
    let mut adam = Adam::new(&course.scene);
    course.forward(0);
    course.step(&mut adam, &RATES);
    let mut pruned = course.scene;
    let kept: Vec<u32> = (0..60).collect();
    prune::keep(&mut pruned, &mut adam, &kept, 0.5);
    // The logit of one half is zero.
    assert!(pruned.logit_opacities.iter().all(|o| *o <= 0.0));
    assert!(pruned.logit_opacities.contains(&0.0), "nothing was above the cap");
    assert!(adam.first.logit_opacities.iter().all(|m| *m == 0.0));
    assert!(adam.first.means.iter().flatten().any(|m| *m != 0.0));
}
