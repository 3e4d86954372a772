//! Rendering and differentiating against the physical floor of this machine, in one run.
//!
//! `cargo bench --bench backward` prints the table of `evidence/performance.md`; words after `--`
//! pick the scenes whose names contain one of them. Trained scenes are skipped where
//! `../shared/data` is absent.

mod floor;
mod processor;
mod scenes;

use std::path::Path;

use powergs_sim::raster::train::{Gradients, Options, Tape, Which};
use powergs_sim::raster::{self, Detail, render};
use powergs_sim::scene::camera::edit;
use powergs_sim::scene::files::open_cameras;
use powergs_sim::scene::{OneFile, read};

use floor::{Cost, Now, Peaks, floor, wall};
use scenes::{Case, synthetic};

/// A row forward (8 cycles) and backward (15); parameters are read and gradients written, the
/// picture is written and its gradient read.
const BOTH: Cost = Cost { cycles_per_row: 23.0, crossings: 2 };

/// Repetitions of one measurement; the median is reported.
const ROUNDS: usize = 11;

/// A model and one of its cameras from `../shared/data`, at another image size.
fn trained(folder: &str, model: &str, view: usize, size: (u32, u32)) -> Option<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(folder);
    let bytes = std::fs::read(folder.join(model)).ok()?;
    let scene = read(&OneFile(&bytes), model, None).ok()?.gaussians;
    let file = open_cameras(&folder.join("cameras.json"), None, None).ok()?;
    let camera = edit::resized(&file.cameras[view], size.0, size.1);
    Some(Case { scene, camera })
}

/// Makes a scene, or nothing if its files are absent.
type Make = fn() -> Option<Case>;

/// All scenes, with their names in tables.
const CASES: [(&str, Make); 5] = [
    ("trained snowmiku 59k 791x593", || {
        trained("snowmiku-posed", "point_cloud.ply", 5, (791, 593))
    }),
    ("trained fox 38k 540x960", || trained("fox-posed", "point_cloud.ply", 5, (540, 960))),
    ("trained robot 250k 1920x1080", || {
        trained("playcanvas-playbot", "playbot_lod1_sh2.ply", 3, (1920, 1080))
    }),
    ("synthetic 100k 979x546", || Some(synthetic("truck", 100_000, (979, 546)))),
    ("synthetic 1M 1600x1064", || Some(synthetic("garden", 1_000_000, (1600, 1064)))),
];

/// Median times of the forward pass, the backward pass and both, ms.
struct Times {
    forward: f64,
    backward: f64,
    both: f64,
}

fn times(case: &Case, which: Which, now: Now) -> Times {
    let (mut tape, mut gradients) = (Tape::new(), Gradients::new());
    let options = Options::reference();
    let by_pixel = vec![[0.5, -0.25, 1.0]; (case.camera.width * case.camera.height) as usize];
    let mut all: Vec<[f64; 3]> = Vec::new();
    for _ in 0..=ROUNDS {
        let start = now();
        tape.forward(&case.scene, &case.camera, &options);
        let middle = now();
        tape.backward(&case.scene, &by_pixel, which, &mut gradients);
        let end = now();
        all.push([middle - start, end - middle, end - start].map(|t| t * 1e3));
    }
    all.remove(0);
    let median = |k: usize| {
        let mut times: Vec<f64> = all.iter().map(|t| t[k]).collect();
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    };
    Times { forward: median(0), backward: median(1), both: median(2) }
}

fn on_threads<T: Send>(n: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a thread pool").install(work)
}

/// One line of the table.
fn report(name: &str, case: &Case) {
    let (peaks, two, few) = on_threads(2, || {
        let few = times(case, Which::ColourAndOpacity, wall);
        (Peaks::measure(wall), times(case, Which::All, wall), few)
    });
    let (peak, one, few_one) = on_threads(1, || {
        let few = times(case, Which::ColourAndOpacity, processor::seconds);
        (Peaks::measure(processor::seconds), times(case, Which::All, processor::seconds), few)
    });
    let counted = raster::Options::reference(Detail::Counters);
    let rendered = render(&case.scene, &case.camera, &counted);
    let mut tape = Tape::new();
    tape.forward(&case.scene, &case.camera, &Options::reference());
    let tape_size = tape.bytes() as f64 / case.scene.bytes() as f64;
    println!("{name}: {} visible, tape {tape_size:.1} times the parameters", tape.splats().len());
    let parts = [("two threads", peaks, two, few), ("one, processor time", peak, one, few_one)];
    for (what, peaks, all, few) in parts {
        let floor = floor(&case.scene, &rendered, peaks, BOTH);
        println!(
            "  {what}: {:.2} GHz, {:.1} GB/s; floor {:.2} ms ({} rows, {:.1} MB); forward {:.1} \
             + backward {:.1} = {:.1} ms = {:.1}x; colour and opacity alone: backward {:.1} ms",
            peaks.clock_ghz,
            peaks.read_gb_s,
            floor.milliseconds,
            floor.rows,
            floor.bytes as f64 * 1e-6,
            all.forward,
            all.backward,
            all.both,
            all.both / floor.milliseconds,
            few.backward,
        );
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    for (name, make) in CASES {
        if !words.is_empty() && !words.iter().any(|word| name.contains(word.as_str())) {
            continue;
        }
        match make() {
            Some(case) => report(name, &case),
            None => println!("{name}: skipped: ../shared/data is absent"),
        }
    }
}
