//! Speed of the gate simulator, as a ratio to a floor that is measured in the same run: the same
//! number of gates of two inputs each, one after the other in memory, with their toggles counted.
//!
//! `cargo bench -p powergs-gates` prints, for each committed netlist of the sorting units, a cycle
//! of 64 lanes with random inputs, its ratio to the floor, and lane-cycles a second, also for a
//! unit of 15,000 cells. One thread; the best of several rounds: the machine may be shared.

use std::hint::black_box;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use fearless_simd_macros::simd;
use powergs_gates::netlist::Netlist;
use powergs_gates::simulator::Simulator;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

#[path = "../../../benches/processor.rs"]
mod processor;

const ROUNDS: usize = 7;
/// Seconds of a round: processor time may be counted in ticks of 4 ms.
const ROUND: f64 = 0.2;

/// Seconds of processor time of a call in the best round.
fn best(mut work: impl FnMut()) -> f64 {
    let time = |_| {
        let (start, mut calls) = (processor::seconds(), 0u32);
        loop {
            (0..100).for_each(|_| work());
            calls += 100;
            let taken = processor::seconds() - start;
            if taken > ROUND {
                return taken / f64::from(calls);
            }
        }
    };
    (0..ROUNDS).map(time).fold(f64::INFINITY, f64::min)
}

#[simd]
fn gates_in_order<S: Simd>(_simd: S, a: &[u64], b: &[u64], out: &mut [u64], toggles: &mut [u64]) {
    for (((a, b), out), toggles) in a.iter().zip(b).zip(out).zip(toggles) {
        let value = !(a & b);
        *toggles += u64::from((value ^ *out).count_ones());
        *out = value;
    }
}

fn floor(gates: usize, random: &mut Pcg64Mcg) -> f64 {
    let mut words = || -> Vec<u64> { (0..gates).map(|_| random.next_u64()).collect() };
    let (a, b, mut out, mut toggles) = (words(), words(), words(), words());
    let level = Level::new();
    best(|| {
        dispatch!(level, simd => gates_in_order(simd, &a, &b, &mut out, &mut toggles));
        black_box((&mut out, &mut toggles));
    })
}

fn main() {
    println!("| netlist | cells | us a cycle | x floor | M lane-cycles/s | of 15,000 cells |");
    println!("|---|--:|--:|--:|--:|--:|");
    for name in ["qsu-nangate45", "qsu-asap7", "bsu-nangate45", "bsu-asap7"] {
        let path = format!("{}/../../rtl/netlists/{name}.gates", env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(&path).expect("a committed netlist");
        let netlist = Netlist::from_bytes(&path, &bytes).expect("a netlist");
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let inputs = netlist.parts().ports.iter().filter(|port| port.input);
        let inputs: Vec<(bool, u32)> = inputs
            .flat_map(|port| port.nets.iter().map(|net| (port.name == "rst_n", *net)))
            .filter(|(_, net)| *net != netlist.parts().clock)
            .collect();
        let mut simulator = Simulator::new(&netlist);
        let cycle = best(|| {
            for &(reset, net) in &inputs {
                simulator.set(net, if reset { !0 } else { random.next_u64() });
            }
            simulator.settle();
            simulator.clock();
        });
        let cells = netlist.parts().cells.len();
        let ratio = cycle / floor(cells, &mut random);
        let rate = 64e-6 / cycle;
        let scaled = rate * cells as f64 / 15e3;
        let us = cycle * 1e6;
        println!("| {name} | {cells} | {us:.1} | {ratio:.1} | {rate:.2} | {scaled:.2} |");
    }
}
