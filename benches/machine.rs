//! One machine on a binned frame: what a sweep pays per machine and frame.
//!
//! `cargo bench --bench machine` times a made-up 1080p frame of 8,160 tiles and 3.5 million pairs
//! from a million Gaussians, on the machines that come with the program, on one thread. The second
//! frame has the same tiles and no Gaussians to convert: the difference is preprocessing.

mod made_up;

use criterion::{Criterion, criterion_group, criterion_main};
use made_up::frame;
use powergs_sim::config::embedded::MACHINES;
use powergs_sim::flow::tile_wise::{ResolvedUnits, replay};
use powergs_sim::machine::Machine;

fn machines(c: &mut Criterion) {
    for embedded in MACHINES {
        // The made-up frame has counts and no splats: lists are there for nothing.
        let sets = ["binning.impl=free".to_owned()];
        let machine = Machine::parse_with(embedded.text, &sets).expect("a good machine");
        if ResolvedUnits::new(&machine).vru.discipline.is_some() {
            continue;
        }
        for points in [1_000_000, 0] {
            let workload = frame(points, machine.tiles().geometry);
            let chunks = workload.chunks.len();
            let name = format!("{} {points} points {chunks} chunks", embedded.name);
            c.bench_function(&name, |b| b.iter(|| replay(&workload, &machine)));
        }
    }
}

criterion_group!(benches, machines);
criterion_main!(benches);
