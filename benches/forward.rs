//! Forward rasterisation against the physical floor of this machine, in one run.
//!
//! `cargo bench --bench forward` prints, per scene, the times and their ratio to the floor of
//! `evidence/performance.md`. The trained scene is skipped where `../shared/data` is absent.

mod floor;
mod processor;
mod scenes;

use std::path::Path;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use powergs_sim::fovea::{Screen, ScreenGaze};
use powergs_sim::raster::{Canvas, Detail, Options, render, render_foveated};
use powergs_sim::scene::camera::edit;
use powergs_sim::scene::files::open_cameras;
use powergs_sim::scene::foveated::LevelPaint;
use powergs_sim::scene::{Foveated, Gaussians, OneFile, read};

use floor::{Cost, Now, Peaks, floor, wall};
use scenes::{Case, synthetic};

/// Evaluating and blending a row; parameters are read and the image is written.
const FORWARD: Cost = Cost { cycles_per_row: 8.0, crossings: 1 };

/// Repetitions of one measurement; the median is reported.
const ROUNDS: usize = 9;

fn median_ms(now: Now, mut work: impl FnMut()) -> f64 {
    work();
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let start = now();
            work();
            (now() - start) * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[ROUNDS / 2]
}

/// Median times of two kinds of work done in turn, so that both see the same machine.
fn paired_ms(mut a: impl FnMut(), mut b: impl FnMut()) -> (f64, f64, f64) {
    a();
    b();
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        a();
        let middle = Instant::now();
        b();
        let times = [(middle - start).as_secs_f64(), middle.elapsed().as_secs_f64()];
        pairs.push(times.map(|t| t * 1e3));
    }
    let median_of = |value: &dyn Fn(&[f64; 2]) -> f64| {
        let mut values: Vec<f64> = pairs.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values[ROUNDS / 2]
    };
    (median_of(&|p| p[0]), median_of(&|p| p[1]), median_of(&|p| p[1] / p[0]))
}

fn on_threads<T: Send>(n: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a thread pool").install(work)
}

/// All scenes, with their names in tables.
fn cases() -> Vec<(&'static str, Case)> {
    let mut cases: Vec<_> =
        trained().map(|case| ("trained robot 250k 1920x1080", case)).into_iter().collect();
    let small = synthetic("truck", 100_000, (979, 546));
    cases.push(("synthetic 100k 979x546", small));
    let large = synthetic("garden", 1_000_000, (1600, 1064));
    cases.push(("synthetic 1M 1600x1064", large));
    cases
}

/// The 250,000-Gaussian robot of `../shared/data` at 1920x1080.
fn trained() -> Option<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/playcanvas-playbot");
    let bytes = std::fs::read(folder.join("playbot_lod1_sh2.ply")).ok()?;
    let scene = read(&OneFile(&bytes), "playbot_lod1_sh2.ply", None).ok()?.gaussians;
    let file = open_cameras(&folder.join("cameras.json"), None, None).ok()?;
    let camera = edit::resized(&file.cameras[3], 1920, 1080);
    Some(Case { scene, camera })
}

/// One line of the table: times and ratios.
fn report(name: &str, case: &Case) {
    let counted = Options::reference(Detail::Counters);
    let image = Options::reference(Detail::Image);
    let scene = &case.scene;
    // As those who render many views do: each in the memory of the one before.
    let run = |now: Now, options: Options| {
        let mut canvas = Canvas::new();
        median_ms(now, || _ = canvas.render(scene, &case.camera, &options))
    };
    let (peaks, two, (plain, frame, extra)) = on_threads(2, || {
        let (mut plain, mut traced) = (Canvas::new(), Canvas::new());
        let paired = paired_ms(
            || _ = plain.render(scene, &case.camera, &image),
            || drop(traced.frame(scene, &case.camera, &counted)),
        );
        (Peaks::measure(wall), run(wall, counted), paired)
    });
    let one = on_threads(1, || run(wall, counted));
    let heaviest = Options::reference(Detail::Dominance);
    let dominance = on_threads(2, || run(wall, heaviest));
    let (peak, [alone, own, own_dominance]) = on_threads(1, || {
        let times = [image, counted, heaviest].map(|options| run(processor::seconds, options));
        (Peaks::measure(processor::seconds), times)
    });
    let rendered = render(scene, &case.camera, &counted);
    let floor_of_one = floor(scene, &rendered, peak, FORWARD).milliseconds;
    let floor = floor(scene, &rendered, peaks, FORWARD);
    println!(
        "{}: {} visible, clock {:.2} GHz, DRAM {:.1} GB/s\n  \
         floor {:.2} ms ({} blending rows, {:.1} MB); image {plain:.1} ms; \
         counters {two:.1} ms = {:.1}x floor; with dominance {dominance:.1} ms = {:.1}x\n  \
         one thread {one:.1} ms: second core {:.2}x; extraction {frame:.1} ms = {:.2}x the image",
        name,
        rendered.splats.len(),
        peaks.clock_ghz,
        peaks.read_gb_s,
        floor.milliseconds,
        floor.rows,
        floor.bytes as f64 * 1e-6,
        two / floor.milliseconds,
        dominance / floor.milliseconds,
        one / two,
        extra,
    );
    println!(
        "  one, processor time: {:.2} GHz, {:.1} GB/s; floor {floor_of_one:.2} ms; image \
         {alone:.1} ms; counters {own:.1} ms = {:.1}x floor; with dominance {own_dominance:.1} ms \
         = {:.1}x",
        peak.clock_ghz,
        peak.read_gb_s,
        own / floor_of_one,
        own_dominance / floor_of_one,
    );
}

/// A model whose levels each keep a share of the one before, by a fixed dice.
fn model(scene: &Gaussians, kept_of_ten: usize) -> Foveated {
    let highest = |i: usize| {
        let mut dice = i.wrapping_mul(0x9e37_79b9) >> 4;
        let stays = |_: &u8| {
            dice = dice.wrapping_mul(0x5851_f42d) >> 3 ^ dice;
            dice % 10 < kept_of_ten
        };
        (1..4).take_while(stays).count() as u8
    };
    let n = scene.sh_coefficients();
    let paint = |i: usize| {
        let sh = scene.sh_of(i);
        let dc = [sh[0], sh[n], sh[2 * n]];
        LevelPaint { dc, logit_opacity: scene.logit_opacities[i] }
    };
    Foveated {
        base: scene.clone(),
        highest: (0..scene.len()).map(highest).collect(),
        paints: (0..scene.len()).map(|i| [paint(i); 3]).collect(),
    }
}

/// Foveated over plain, on two threads: with whole levels, and with levels of half the one before.
fn report_foveated(name: &str, case: &Case) {
    let gaze = ScreenGaze { point: [0.5, 0.5], screen: Screen::PUBLISHED };
    for (kept, what) in [(10, "whole levels"), (5, "levels of half")] {
        let model = model(&case.scene, kept);
        for detail in [Detail::Image, Detail::Counters] {
            let options = Options::reference(detail);
            let foveated = || {
                drop(render_foveated(&model, &case.camera, &gaze, &options).expect("a gaze"));
            };
            let plain = || drop(render(&case.scene, &case.camera, &options));
            let (plain, own, ratio) = on_threads(2, || paired_ms(plain, foveated));
            println!(
                "  {name}, {what}, {detail:?}: plain {plain:.1} ms, foveated {own:.1} ms = \
                 {ratio:.2}x"
            );
        }
    }
}

fn forward(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("forward");
    group.sample_size(10);
    for (name, case) in cases() {
        report(name, &case);
        report_foveated(name, &case);
        let (mut canvas, options) = (Canvas::new(), Options::reference(Detail::Counters));
        group.bench_function(name, |b| {
            b.iter(|| canvas.render(&case.scene, &case.camera, &options).counters);
        });
    }
    group.finish();
}

criterion_group!(benches, forward);
criterion_main!(benches);
