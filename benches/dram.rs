//! Speed of the memory models: bursts per second of level `banked` and of level `window`, and their
//! ratio, measured in one run on one thread.
//!
//! `cargo bench --bench dram` makes the table of `docs/dram.md`. Every figure is the best of
//! several rounds: the machine may be shared.

use std::time::Instant;

use powergs_sim::config::embedded::{DRAM, find};
use powergs_sim::dram::drive::{Access, WindowDrive, banked};
use powergs_sim::dram::{Device, Mode};

// Tests use more of it.
#[allow(dead_code)]
#[path = "../crates/core/tests/it/dram/streams.rs"]
mod streams;

const ROUNDS: usize = 7;

/// Bursts per microsecond of the best round.
fn best(bursts: u64, mut work: impl FnMut()) -> f64 {
    let time = |()| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    let shortest = (0..ROUNDS).map(|_| ()).map(time).fold(f64::INFINITY, f64::min);
    bursts as f64 / shortest * 1e-6
}

fn measure(device: &Device, name: &str, mode: Mode) {
    let accesses: Vec<Access> = streams::stream(name);
    let bursts = banked(device, mode, accesses.iter().copied()).stats.total.bursts;
    let exact = best(bursts, || {
        std::hint::black_box(banked(device, mode, accesses.iter().copied()));
    });
    let counted = best(bursts, || {
        let mut drive = WindowDrive::new(device, mode);
        accesses.iter().for_each(|a| drive.take(*a));
        std::hint::black_box(drive.finish());
    });
    let ratio = counted / exact;
    println!("| {} | {name} | {exact:.1} | {counted:.0} | {ratio:.0}x |", device.name);
}

fn main() {
    println!("| device | stream | banked, M bursts/s | window, M bursts/s | ratio |");
    println!("|---|---|--:|--:|--:|");
    for device in ["lpddr4-3200-x16x8", "lpddr4-3200-x32x4", "lpddr5-6400-x16x4", "hbm2-8ch"] {
        let text = find(DRAM, device).expect("it comes with the program");
        let device = Device::parse(text).expect("it comes with the program");
        for name in ["seq_read", "copy1k", "gs_preproc", "gs_raster64", "rand64_read"] {
            measure(&device, name, Mode::Saturated);
        }
    }
}
