//! Parses the command line, dispatches, and turns the outcome into an exit code.

use clap::Parser;
use powergs_sim::cli::{Cli, startup};

fn main() -> std::process::ExitCode {
    std::process::ExitCode::from(startup::start(&Cli::parse()) as u8)
}
