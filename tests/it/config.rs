//! Configuration files: their documentation, and the commands about them.

mod commands;
mod documentation;
mod tables;

use powergs_sim::config::embedded::{MACHINES, find};

/// The text of the default machine.
pub fn gscore() -> &'static str {
    find(MACHINES, "gscore").expect("the default machine")
}
