//! Machine files and energy tables: what they mean, and what is refused.

mod energy;
mod hostile;
mod machines;
mod typos;

use powergs_base::config::embedded::{MACHINES, find};

/// The text of the default machine.
pub fn gscore() -> &'static str {
    find(MACHINES, "gscore").expect("the default machine")
}

/// `overlays` as `--set` gives them.
pub fn sets(overlays: &[&str]) -> Vec<String> {
    overlays.iter().map(|s| (*s).to_owned()).collect()
}
