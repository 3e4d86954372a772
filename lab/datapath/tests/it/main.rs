//! Tests of the bit-exact model, one file per topic.

mod ccu;
mod ccu_hardware;
mod numbers;
mod sorting;
mod units;
mod vrc;
mod vru;

use powergs_testkit::verilator::Bench;

/// A test bench of `rtl/`; `None` without Verilator.
fn bench(name: &str, parameters: &[(&str, u32)]) -> Option<Bench> {
    Bench::build(env!("CARGO_TARGET_TMPDIR"), name, parameters)
}
