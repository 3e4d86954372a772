//! How far the DRAM models `calibrated` and `bandwidth` are from `banked`, on random
//! machines: the table in `docs/dram.md`.
//!
//! ```console
//! $ cargo run --release -p powergs-core --example dram_models -- 200 traces/demo.bin
//! ```
//!
//! Machines are `gscore` with 1 to 8 CCUs and cores, 4 to 32 rendering units and three kinds of
//! sorters, as in the sweep `gscore-units`, and with buffers of a quarter to four times GSCore's
//! share of a CCU or core. Errors are those of the frame time and of the energy of a frame with the
//! device's prices, over all frames of a trace; pairs of machines whose times differ by at most 1 %
//! have no order. Times of computation are those of all machines on one thread.

use std::path::Path;
use std::time::Instant;

use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::{Change, RunError, Session, Subject, System, SystemSpec, TraceFile};

const MODELS: [&str; 3] = ["banked", "calibrated", "bandwidth"];

/// Machines that differ by more are listed.
const LISTED: f64 = 0.12;

/// A sequence of numbers that is the same in every run (xorshift).
struct Dice(u64);

impl Dice {
    fn pick<T: Copy>(&mut self, among: &[T]) -> T {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        among[((self.0 >> 11) % among.len() as u64) as usize]
    }
}

/// The changes of a random machine.
fn machine(dice: &mut Dice) -> Vec<String> {
    let (ccus, cores) = (dice.pick(&[1, 2, 4, 8]), dice.pick(&[1, 2, 4, 8]));
    let units = dice.pick(&[4, 8, 16, 32]);
    let (qsus, bsus) = dice.pick(&[(1, 1), (2, 1), (4, 2)]);
    let mut bytes = |quarter: u64, owners: u64| {
        format!("{} B", quarter * owners * dice.pick(&[1, 2, 4, 8, 16]))
    };
    vec![
        format!("ccu.units={ccus}"),
        format!("vru.cores={cores}"),
        format!("vru.units-per-core={units}"),
        format!("gsu.qsu-per-core={qsus}"),
        format!("gsu.bsu-per-core={bsus}"),
        format!("buffers.sorting.capacity={}", bytes(4096, cores)),
        format!("buffers.feature.capacity={}", bytes(8192, cores)),
        format!("buffers.pixel-out.capacity={}", bytes(1024, cores)),
        format!("buffers.gaussian-in.capacity={}", bytes(512, ccus)),
        format!("buffers.tile-list.capacity={}", bytes(2048, ccus)),
    ]
}

fn base(model: &str) -> Result<System, RunError> {
    let spec =
        SystemSpec { sets: vec![format!("dram.model={model}")], ..SystemSpec::named("gscore") };
    System::load(&spec, &EmbeddedFiles)
}

fn with(base: &System, sets: &[String]) -> Result<System, RunError> {
    let changes: Result<Vec<Change>, String> = sets.iter().map(|set| set.parse()).collect();
    base.with(&changes.map_err(RunError::Request)?)
}

/// Seconds and joules of all frames, by machine, and how long that took.
fn run(
    model: &str,
    machines: &[Vec<String>],
    trace: &Path,
) -> Result<(Vec<[f64; 2]>, f64), RunError> {
    let base = base(model)?;
    let systems: Result<Vec<System>, RunError> = machines.iter().map(|m| with(&base, m)).collect();
    let systems = systems?;
    let subjects: Vec<Subject> = systems.iter().map(Subject::of).collect();
    let mut frames = TraceFile::open(trace)?;
    let start = Instant::now();
    let folded = Session::new(&mut frames, &()).fold(
        &subjects,
        |_| [0.0; 2],
        |sums, view| {
            sums[0] += view.report.frame_time_s().unwrap_or(0.0);
            sums[1] += view.report.energy.total().0 * 1e-12;
        },
    )?;
    Ok((folded.states, start.elapsed().as_secs_f64()))
}

/// Mean and worst of the absolute errors, and the machine with the worst.
fn errors(all: &[[f64; 2]], real: &[[f64; 2]], which: usize) -> (f64, f64) {
    let of = |(a, r): (&[f64; 2], &[f64; 2])| (a[which] / r[which] - 1.0).abs();
    let errors = all.iter().zip(real).map(of);
    let (sum, worst) = errors.fold((0.0, 0.0_f64), |sum, e| (sum.0 + e, sum.1.max(e)));
    (sum / all.len() as f64, worst)
}

/// Kendall's tau-b of the times, over pairs that are more than 1 % apart.
fn tau(all: &[[f64; 2]], real: &[[f64; 2]]) -> f64 {
    let (mut order, mut pairs, mut untied) = (0.0, 0.0_f64, 0.0_f64);
    for i in 0..all.len() {
        for j in 0..i {
            let (a, r) = (all[i][0] - all[j][0], real[i][0] - real[j][0]);
            if (real[i][0] / real[j][0] - 1.0).abs() > 0.01 {
                pairs += 1.0;
                untied += f64::from(a != 0.0);
                order += if a == 0.0 { 0.0 } else { (a * r).signum() };
            }
        }
    }
    order / (pairs * untied).sqrt()
}

fn main() -> Result<(), RunError> {
    let mut args = std::env::args().skip(1);
    let count = args.next().and_then(|count| count.parse().ok()).unwrap_or(200);
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    let known = base("banked")?;
    let mut machines = Vec::new();
    while machines.len() < count {
        let sets = machine(&mut dice);
        if with(&known, &sets).is_ok() {
            machines.push(sets);
        }
    }
    println!("trace | model | time, mean and worst, % | tau-b | energy, mean and worst, % | s");
    for trace in args {
        let mut real = Vec::new();
        for model in MODELS {
            let (all, seconds) = run(model, &machines, Path::new(&trace))?;
            if real.is_empty() {
                println!("{trace} | {model} | - | - | - | {seconds:.2}");
                real = all;
                continue;
            }
            let (time, energy) = (errors(&all, &real, 0), errors(&all, &real, 1));
            println!(
                "{trace} | {model} | {:.1} / {:.1} | {:.3} | {:.1} / {:.1} | {seconds:.2}",
                time.0 * 100.0,
                time.1 * 100.0,
                tau(&all, &real),
                energy.0 * 100.0,
                energy.1 * 100.0
            );
            for ((a, r), sets) in all.iter().zip(&real).zip(&machines) {
                let error = a[0] / r[0] - 1.0;
                if model == "calibrated" && error.abs() > LISTED {
                    println!("  {:+.1} %: {}", error * 100.0, sets.join(" "));
                }
            }
        }
    }
    Ok(())
}
