//! Configuration: quantities, machine files, energy tables, their documentation, the commands.

mod commands;
mod documentation;
mod energy;
mod hostile;
mod machines;
mod quantities;
mod typos;

use powergs_sim::config::embedded::{MACHINES, find};

/// The text of the default machine.
pub fn gscore() -> &'static str {
    find(MACHINES, "gscore").expect("the default machine")
}

/// `overlays` as `--set` gives them.
pub fn sets(overlays: &[&str]) -> Vec<String> {
    overlays.iter().map(|s| (*s).to_owned()).collect()
}
