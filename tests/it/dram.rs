//! The memory alone: against a public simulator, against its own rules, and as a command.

mod acceptance;
mod checker;
mod command;
mod device;
mod energy;
mod knobs;
mod laws;
mod mapping;
pub mod streams;
mod traces;

use powergs_sim::config::embedded::{DRAM, find};
use powergs_sim::dram::Device;

/// A device that comes with the program, with `key=value` overlays.
fn device(name: &str, sets: &[&str]) -> Device {
    let text = find(DRAM, name).unwrap_or_else(|| panic!("no device {name}"));
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    Device::parse_with(text, &sets).unwrap_or_else(|e| panic!("{name}: {e}"))
}
