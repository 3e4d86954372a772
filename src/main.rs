//! Answers shells that complete, parses the command line, dispatches, and turns the outcome into an
//! exit code.

use powergs_sim::cli::{self, Cli, completions, startup, usage};

fn main() -> std::process::ExitCode {
    completions::answer();
    let cli: Cli = usage::parse();
    let exit =
        startup::start(&cli.global, cli.command.drawing(), |context| cli::run(&cli, context));
    std::process::ExitCode::from(exit as u8)
}
