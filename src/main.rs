//! Answers shells that complete, parses the command line, dispatches, and turns the outcome into an
//! exit code.

use powergs_sim::cli::{completions, startup, usage};

fn main() -> std::process::ExitCode {
    completions::answer();
    std::process::ExitCode::from(startup::start(&usage::parse()) as u8)
}
