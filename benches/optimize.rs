//! A fine-tuning iteration against its own forward and backward pass, and what the oracle costs.
//!
//! `cargo bench --bench optimize` prints, per scene, an iteration (render, loss with the display
//! term, backward, Adam) as a ratio to forward plus backward in the same run, and a single-frame
//! call of both oracles as a ratio to rendering the frame.

mod scenes;

use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use powergs_sim::cli::inputs::display as load_display;
use powergs_sim::optimize::oracle::{CycleOracle, PaperOracle, PowerOracle};
use powergs_sim::optimize::references::Reference;
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
use powergs_sim::scene::Camera;
use powergs_sim::sim::paper::UnitPrices;

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
        oracle: &oracle,
        screen: None,
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
    let [plain, paper, cycle] = oracle(case);
    println!(
        "{name}: forward + backward {both:.1} ms, iteration {step:.1} ms = {ratio:.2}x\n  \
         frame {plain:.2} ms; oracle: paper {paper:.2} ms = {:.2}x, gscore {cycle:.2} ms = {:.2}x",
        paper / plain,
        cycle / plain
    );
}

fn optimize(criterion: &mut Criterion) {
    let cases = [
        ("synthetic 31k 400x300", synthetic("demo", 31_000, (400, 300))),
        ("synthetic 100k 979x546", synthetic("outdoor-bounded", 100_000, (979, 546))),
    ];
    let mut group = criterion.benchmark_group("optimize");
    group.sample_size(10);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a thread pool");
    for (name, case) in &cases {
        pool.install(|| report(name, case));
        group.bench_function(*name, |b| b.iter(|| pool.install(|| oracle(case))));
    }
    group.finish();
}

criterion_group!(benches, optimize);
criterion_main!(benches);
