//! A fine-tuning iteration against its own forward and backward pass, and what the oracle costs.
//!
//! `cargo bench --bench optimize` prints, per scene, an iteration (render, loss with the display
//! term, backward, Adam) as a ratio to forward plus backward in the same run; the step of what a
//! view sees against one that writes all gradients and then goes through all parameters; and a
//! single-frame call of both oracles as a ratio to rendering the frame. Words after `--` pick the
//! scenes whose names contain one of them.

mod scenes;

use std::time::Instant;

use powergs_sim::cli::inputs::display as load_display;
use powergs_sim::optimize::adam::{Adam, Group, Rates};
use powergs_sim::optimize::oracle::{CycleOracle, PaperOracle, PowerOracle};
use powergs_sim::optimize::references::Reference;
use powergs_sim::optimize::renderer::Processor;
use powergs_sim::optimize::settings::Settings;
use powergs_sim::optimize::setup::Setup;
use powergs_sim::optimize::target::{Quality, Target};
use powergs_sim::optimize::tune::{
    DisplayTerm, Keep, Model, Objective, Pace, Pruning, State, Trains, TuneConfig, Tuner,
};
use powergs_sim::optimize::views::split;
use powergs_sim::raster::train::{self, Gradients, Tape, Which};
use powergs_sim::raster::{Detail, Options, render};
use powergs_sim::run::System;
use powergs_sim::scene::{Camera, Gaussians};
use powergs_sim::sim::paper::UnitPrices;
use rayon::prelude::*;

use scenes::{Case, synthetic};

/// Repetitions of one measurement; the median is reported.
const ROUNDS: usize = 15;

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn milliseconds(mut work: impl FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

fn settings() -> Settings {
    Settings {
        first_effort: 1.0,
        final_iterations: 1_000,
        interval: 1_000_000,
        rate_end: 1.0,
        ..Settings::DEFAULT
    }
}

/// Times of forward plus backward and of an iteration, done in turn.
fn iteration(case: &Case) -> (f64, f64, f64) {
    let views: Vec<Camera> = vec![case.camera.clone()];
    let picture = render(&case.scene, &case.camera, &Options::reference(Detail::Image)).picture;
    let references = vec![Reference::new(&picture)];
    let display = load_display("oled-powergs").expect("a display");
    let oracle = PaperOracle { prices: UnitPrices::PUBLISHED, fps: 60.0 };
    let (split, settings) = (split(&views, 0), settings());
    let setup = Setup {
        dense: &case.scene,
        cameras: &views,
        references: &references,
        split: &split,
        power_views: &views,
        background: [0.0; 3],
        display: &display,
        renderer: &Processor,
        oracle: &oracle,
        screens: None,
        lpips: None,
        settings: &settings,
    };
    let config = TuneConfig {
        iterations: 1_000,
        pruning: Pruning::Never,
        display: DisplayTerm::Fixed(0.1),
        objective: Objective::Likeness,
        trains: Trains::All,
        keep: Keep::Last,
        pace: Pace::RECOVERING,
    };
    let target = Target::Likeness(Quality::likeness(40.0, 0.9));
    let state = State::begin(Model::fresh(&case.scene));
    let mut tuner = Tuner::new(&setup, config, target, 0, state);
    let (mut tape, mut gradients) = (Tape::new(), Gradients::new());
    let by_pixel = vec![[1e-6f32; 3]; picture.pixels.len()];
    let options = train::Options::reference();
    let mut rows = Vec::new();
    for _ in 0..=ROUNDS {
        let both = milliseconds(|| {
            tape.forward(&case.scene, &case.camera, &options);
            tape.backward(&case.scene, &by_pixel, Which::All, &mut gradients);
        });
        let step = milliseconds(|| {
            tuner.step().expect("finite gradients");
        });
        rows.push([both, step, step / both]);
    }
    // The first round also checks the quality and finds its buffers.
    let of = |k: usize| median(rows[1..].iter().map(|r| r[k]).collect());
    (of(0), of(1), of(2))
}

/// Moments and the mean of all parameters, and the pass that goes through all of them: what a
/// step would be if it did not know what is seen.
struct Everything {
    first: Gaussians,
    second: Gaussians,
    mean: Gaussians,
}

fn lists(of: &mut Gaussians) -> [&mut [f32]; 5] {
    [
        of.means.as_flattened_mut(),
        of.log_scales.as_flattened_mut(),
        of.rotations.as_flattened_mut(),
        &mut of.logit_opacities,
        &mut of.sh,
    ]
}

impl Everything {
    fn new(scene: &Gaussians) -> Everything {
        let Adam { first, second, .. } = Adam::new(scene);
        Everything { first, second, mean: scene.clone() }
    }

    fn step(&mut self, scene: &mut Gaussians, gradients: &Gradients) {
        let moments = lists(&mut self.first).into_iter().zip(lists(&mut self.second));
        let values = lists(scene).into_iter().zip(lists(&mut self.mean));
        for ((values, mean), ((first, second), slopes)) in values.zip(moments.zip(gradients.flat()))
        {
            let part = 1 << 16;
            let moments = first.par_chunks_mut(part).zip(second.par_chunks_mut(part));
            let values = values.par_chunks_mut(part).zip(mean.par_chunks_mut(part));
            values.zip(moments).zip(slopes.par_chunks(part)).for_each(
                |(((p, mean), (m, v)), g)| {
                    for (((p, g), mean), (m, v)) in
                        p.iter_mut().zip(g).zip(mean).zip(m.iter_mut().zip(v))
                    {
                        *m = 0.9 * *m + 0.1 * g;
                        *v = 0.999 * *v + 0.001 * g * g;
                        *p -= 1e-9 * *m / (v.sqrt() + 1e-15);
                        *mean += 0.05 * (*p - *mean);
                    }
                },
            );
        }
    }
}

/// Times of finding the sums over pixels, which both have, of the step of what is seen, and of the
/// pass through everything, done in turn.
fn passes(case: &Case) -> [f64; 3] {
    let mut scene = case.scene.clone();
    let (mut adam, mut everything) = (Adam::new(&scene), Everything::new(&scene));
    let (mut tape, mut gradients) = (Tape::new(), Gradients::new());
    let by_pixel = vec![[1e-6f32; 3]; (case.camera.width * case.camera.height) as usize];
    // Long enough to do the work, too short to move what is seen.
    let rates = Rates::published(1.0).scaled(1e-9);
    let mut rows = Vec::new();
    for _ in 0..=ROUNDS {
        tape.forward(&scene, &case.camera, &train::Options::reference());
        let sums = milliseconds(|| {
            tape.slopes(&by_pixel, Which::All);
        });
        let seen = milliseconds(|| {
            let slopes = tape.slopes(&by_pixel, Which::All);
            adam.step(&mut scene, None, &slopes, &rates).expect("finite gradients");
        });
        tape.forward(&scene, &case.camera, &train::Options::reference());
        let all = milliseconds(|| {
            tape.backward(&scene, &by_pixel, Which::All, &mut gradients);
            everything.step(&mut scene, &gradients);
        });
        rows.push([sums, seen - sums, all - sums]);
    }
    assert!(Group::ALL.iter().all(|g| g.of(&scene).iter().all(|v| v.is_finite())));
    std::array::from_fn(|k| median(rows[1..].iter().map(|r| r[k]).collect()))
}

/// Times of rendering with counters, and of a call of both oracles.
fn oracle(case: &Case) -> [f64; 3] {
    let display = load_display("oled-powergs").expect("a display");
    let paper = PaperOracle { prices: UnitPrices::PUBLISHED, fps: 60.0 };
    let cycle = CycleOracle {
        system: System::named("gscore").expect("a machine"),
        fps: 60.0,
        memory: powergs_sim::budget::Budget::DEFAULT,
    };
    let views = [case.camera.clone()];
    let options = Options::reference(Detail::Counters);
    let mut rows = Vec::new();
    for _ in 0..ROUNDS {
        let ask = |oracle: &dyn PowerOracle| {
            let watts = oracle.watts(&case.scene, &views, [0.0; 3], &display);
            watts.expect("the accounts close");
        };
        rows.push([
            milliseconds(|| drop(render(&case.scene, &case.camera, &options))),
            milliseconds(|| ask(&paper)),
            milliseconds(|| ask(&cycle)),
        ]);
    }
    std::array::from_fn(|k| median(rows.iter().map(|r| r[k]).collect()))
}

fn report(name: &str, case: &Case) {
    let (both, step, ratio) = iteration(case);
    let [sums, seen, all] = passes(case);
    let [plain, paper, cycle] = oracle(case);
    println!(
        "{name}: forward + backward {both:.1} ms, iteration {step:.1} ms = {ratio:.2}x\n  \
         sums over pixels {sums:.1} ms, step of what is seen {seen:.1} ms, of everything \
         {all:.1} ms = {:.1}x\n  frame {plain:.2} ms; oracle: paper {paper:.2} ms = {:.2}x, \
         gscore {cycle:.2} ms = {:.2}x",
        all / seen,
        paper / plain,
        cycle / plain
    );
}

/// A scene: its name in tables, preset, Gaussians and image size.
const CASES: [(&str, &str, usize, (u32, u32)); 3] = [
    ("synthetic 31k 400x300", "demo", 31_000, (400, 300)),
    ("synthetic 100k 979x546", "truck", 100_000, (979, 546)),
    ("synthetic 1M 1200x667", "garden", 1_000_000, (1200, 667)),
];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a thread pool");
    for (name, preset, points, size) in CASES {
        if words.is_empty() || words.iter().any(|word| name.contains(word.as_str())) {
            let case = synthetic(preset, points, size);
            pool.install(|| report(name, &case));
        }
    }
}
