//! What a sweep pays per design: making it, timing it on a binned frame, reading its record.
//!
//! `cargo bench --bench sweep`. The frame is that of `machine.rs`; `two threads` over `one thread`
//! is what a second core brings.

mod made_up;

use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use made_up::frame;
use powergs_sim::flow::FrameTask;
use powergs_sim::kernel::Memo;
use powergs_sim::machine::Machine;
use powergs_sim::run::files::EmbeddedFiles;
use powergs_sim::run::store::journal::{Index, append, parse};
use powergs_sim::sim::time;
use powergs_sim::sweep::outcome::{Outcome, means};
use powergs_sim::sweep::{Record, Space, SweepFile};
use rayon::prelude::*;

const SWEEP: &str = r#"
question = "How long does a design take?"
base = "gscore"
set = { "dram.model" = "bandwidth" }
axes = [
  { key = "ccu.units", values = [1, 2, 4, 8] },
  { key = "vru.cores", values = [1, 2, 4] },
  { key = "vru.units-per-core", values = [8, 16, 32] },
  { key = "dram.channels", values = [4, 8, 16] },
  { key = "dram.latency", values = ["50 ns", "100 ns", "200 ns"] },
]
"#;

fn space() -> Space {
    let file = SweepFile::parse(SWEEP).expect("a sweep file");
    Space::new(&file, Arc::new(EmbeddedFiles)).expect("a space")
}

fn designs(c: &mut Criterion) {
    let space = space();
    let points = space.lattice().points();
    let mut group = c.benchmark_group("design");
    group.throughput(Throughput::Elements(points));
    group.bench_function("made", |b| {
        b.iter(|| (0..points).filter(|&p| space.design(p).is_ok()).count())
    });
    let machines: Vec<Machine> =
        (0..points).filter_map(|p| Some(space.design(p).ok()?.machine)).collect();
    let workload = frame(1_000_000, machines[0].tiles().geometry);
    let one = |machine: &Machine| {
        let memo = Memo::default();
        let timed = time(&FrameTask::first(machine, &workload, &memo)).expect("closed accounts");
        timed.outcome.timing.frame
    };
    group.sample_size(10);
    group.throughput(Throughput::Elements(machines.len() as u64));
    for (name, threads) in [("timed, one thread", 1), ("timed, two threads", 2)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        group.bench_function(name, |b| {
            b.iter(|| pool.install(|| machines.par_iter().map(one).sum::<u64>()))
        });
    }
    group.finish();
}

fn records(c: &mut Criterion) {
    const RECORDS: u128 = 10_000;
    let outcome =
        Outcome { samples: vec![[1.0 / 3.0; 3]; 10], means: vec![Some(0.1); means().len()] };
    let mut text = Vec::new();
    for key in 0..RECORDS {
        append(&mut text, key, &Record::Ok(outcome.clone()).text()).expect("memory");
    }
    let mut group = c.benchmark_group("journal");
    group.throughput(Throughput::Elements(RECORDS as u64));
    let read = || {
        let mut index = Index::default();
        index.read(0, text.as_slice(), 0).expect("memory");
        index
    };
    group.bench_function("indexed", |b| b.iter(|| read().len()));
    let index = read();
    group.bench_function("parsed", |b| {
        b.iter(|| {
            (0..RECORDS)
                .filter_map(|key| {
                    let place = index.place(key)?;
                    let line = &text[place.offset as usize..][..place.length as usize];
                    Record::parse(parse(line)?.1)
                })
                .count()
        })
    });
    group.finish();
}

criterion_group!(benches, designs, records);
criterion_main!(benches);
