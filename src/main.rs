//! Parses the command line, dispatches, and turns the outcome into an exit code.

use clap::Parser;
use powergs_sim::cli::{Cli, Context, Exit, run};

fn main() -> std::process::ExitCode {
    let cli = Cli::parse();
    let context = Context { global: cli.global.clone(), cancelled: Default::default() };
    let exit = run(&cli, &context).unwrap_or_else(|failure| {
        eprintln!("error: {failure}");
        failure.exit
    });
    std::process::ExitCode::from(exit as u8)
}

const _: () = assert!(Exit::Interrupted as u8 == 130);
