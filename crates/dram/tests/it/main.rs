//! The memory alone: against a public simulator, against its own rules.

mod acceptance;
mod checker;
mod device;
mod energy;
mod exact;
mod knobs;
mod laws;
mod mapping;
mod streams;
mod traces;

use powergs_base::config::embedded::{DRAM, find};
use powergs_dram::Device;

/// A device that comes with the program, with `key=value` overlays.
fn device(name: &str, sets: &[&str]) -> Device {
    let text = find(DRAM, name).unwrap_or_else(|| panic!("no device {name}"));
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    Device::parse_with(text, &sets).unwrap_or_else(|e| panic!("{name}: {e}"))
}
