//! Replay of a 1080p frame with about a million visible splats: what the first machine of a
//! geometry costs (decode, bin, simulate), and what each further one does (simulate).
//!
//! `cargo bench --bench replay` prints medians on two threads; the simulation itself uses one.

mod scenes;

use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use powergs_sim::energy::Prices;
use powergs_sim::machine::Machine;
use powergs_sim::raster::{Detail, Options, render};
use powergs_sim::run::System;
use powergs_sim::sim::{Label, simulate};
use powergs_sim::trace::EncodedFrame;
use powergs_sim::workload::{FrameWorkload, bin};

use scenes::synthetic;

/// Gaussians of the scene; a bit more than a quarter of them are visible.
const POINTS: usize = 3_700_000;

fn median_ms<T>(rounds: usize, mut work: impl FnMut() -> T) -> f64 {
    drop(work());
    let mut times: Vec<f64> = (0..rounds)
        .map(|_| {
            let start = Instant::now();
            drop(work());
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[rounds / 2]
}

fn one_machine(workload: &FrameWorkload, machine: &Machine, prices: &Prices) -> u64 {
    let report = simulate(Label::default(), workload, machine, prices).expect("accounts close");
    report.timing().expect("the cycle model has a time").frame
}

fn replay(criterion: &mut Criterion) {
    let case = synthetic("garden", POINTS, (1920, 1080));
    let options = Options::reference(Detail::Counters);
    let frame = render(&case.scene, &case.camera, &options).into_frame(&case.camera, [0.0; 3]);
    drop(case.scene);
    let (splats, encode) =
        (frame.splats.len(), median_ms(5, || EncodedFrame::encode(&frame).expect("a valid frame")));
    let encoded = EncodedFrame::encode(&frame).expect("a valid frame");
    let loaded = System::named("gscore").unwrap_or_else(|e| panic!("{e}"));
    let (machine, prices) = (loaded.machine(), loaded.prices());
    let decode = median_ms(5, || encoded.decode().expect("a valid block"));
    let binning = median_ms(5, || bin(&frame, machine.tiles().geometry));
    let workload = bin(&frame, machine.tiles().geometry);
    let simulated = median_ms(9, || one_machine(&workload, machine, prices));
    println!(
        "{splats} visible splats, {} pairs, {} chunks: encode {encode:.0} ms; \
         decode {decode:.0} ms + bin {binning:.0} ms + simulate {simulated:.1} ms = {:.0} ms \
         for the first machine, \
         {simulated:.1} ms for each further one",
        workload.list.len(),
        workload.chunks.len(),
        decode + binning + simulated
    );
    let mut group = criterion.benchmark_group("replay");
    group.sample_size(10);
    group.bench_function("bin", |b| b.iter(|| bin(&frame, machine.tiles().geometry)));
    group.bench_function("simulate", |b| b.iter(|| one_machine(&workload, machine, prices)));
    group.finish();
}

criterion_group!(benches, replay);
criterion_main!(benches);
