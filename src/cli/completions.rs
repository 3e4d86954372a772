//! `completions`: scripts for shells, from the same definitions as the commands.

use clap::CommandFactory;
use clap_complete::{Shell, generate};

use super::{Cli, Context, Exit, Failure, out};

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell
    #[arg(value_enum)]
    pub shell: Supported,
}

/// Shells with completions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Supported {
    /// Bourne-again shell.
    Bash,
    /// Z shell.
    Zsh,
    /// The friendly interactive shell.
    Fish,
}

/// Prints the script.
pub fn run(args: &Args, _context: &Context) -> Result<Exit, Failure> {
    let shell = match args.shell {
        Supported::Bash => Shell::Bash,
        Supported::Zsh => Shell::Zsh,
        Supported::Fish => Shell::Fish,
    };
    let mut script = Vec::new();
    generate(shell, &mut Cli::command(), "powergs-sim", &mut script);
    out::write(|out| out.write_all(&script))?;
    Ok(Exit::Done)
}
