//! Parses the command line, dispatches, and turns the outcome into an exit code.

use powergs_lab::Cli;
use powergs_sim::cli::{startup, usage};

fn main() -> std::process::ExitCode {
    let cli: Cli = usage::parse();
    let run = |context: &_| powergs_lab::run(&cli, context);
    std::process::ExitCode::from(startup::start(&cli.global, Default::default(), run) as u8)
}
