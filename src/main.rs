//! Answers shells that complete, parses the command line, dispatches, and turns the outcome into an exit code.

use clap::Parser;
use powergs_sim::cli::{Cli, completions, startup};

fn main() -> std::process::ExitCode {
    completions::answer();
    std::process::ExitCode::from(startup::start(&Cli::parse()) as u8)
}
