//! Speed of the memory models: bursts per second of processor time of level `banked`, alone and
//! with the requests of a second master among those of the stream, and of level `window`, and the
//! ratio of the levels, measured in one run on one thread.
//!
//! `cargo bench --bench dram` makes the table of `docs/dram.md`. Every figure is the best of
//! several rounds: the machine may be shared.

use powergs_sim::config::embedded::{DRAM, find};
use powergs_sim::dram::drive::{Access, banked};
use powergs_sim::dram::{Device, Mode};

// Tests use more of it.
#[allow(dead_code)]
#[path = "../crates/dram/tests/it/streams.rs"]
mod streams;

mod processor;

const ROUNDS: usize = 5;

/// Runs of a round: processor time may be counted in ticks of 4 ms.
const RUNS: u32 = 8;

/// Bursts per microsecond of processor time in the best round.
fn best(bursts: u64, mut work: impl FnMut()) -> f64 {
    let time = |()| {
        let start = processor::seconds();
        (0..RUNS).for_each(|_| work());
        (processor::seconds() - start) / f64::from(RUNS)
    };
    let shortest = (0..ROUNDS).map(|_| ()).map(time).fold(f64::INFINITY, f64::min);
    bursts as f64 / shortest * 1e-6
}

/// A stream with a request of a second master behind every fourth: 256 bytes each, back to back in
/// a region of its own, a read and a write in turn.
fn with_master(accesses: &[Access]) -> Vec<Access> {
    const REGION: u64 = 0x2000_0000;
    let master = |number: u64| Access {
        write: number % 2 == 1,
        address: REGION + number % (1 << 18) * 256,
        bytes: 256,
    };
    let fours = accesses.chunks(4).zip(0..);
    fours.flat_map(|(four, number)| four.iter().copied().chain([master(number)])).collect()
}

fn measure(device: &Device, name: &str, mode: Mode) {
    let accesses: Vec<Access> = streams::stream(name);
    let run = |accesses: &[Access]| banked(device, mode, accesses.iter().copied());
    let bursts_of = |accesses: &[Access]| run(accesses).stats.total.bursts;
    let speed = |accesses: &[Access]| {
        best(bursts_of(accesses), || {
            std::hint::black_box(run(accesses));
        })
    };
    let (exact, both) = (speed(&accesses), speed(&with_master(&accesses)));
    let device = &device.name;
    println!("| {device} | {name} | {exact:.1} | {both:.1} |");
}

fn main() {
    println!("| device | stream | banked, M bursts/s | with a second master |");
    println!("|---|---|--:|--:|");
    for device in ["lpddr4-3200-x16x8", "lpddr4-3200-x32x4", "lpddr5-6400-x16x4", "hbm2-8ch"] {
        let text = find(DRAM, device).expect("it comes with the program");
        let device = Device::parse(text).expect("it comes with the program");
        for name in ["seq_read", "copy1k", "gs_preproc", "gs_raster64", "rand64_read"] {
            measure(&device, name, Mode::Saturated);
        }
    }
}
