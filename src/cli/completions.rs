//! `completions`: scripts for shells, which ask this program what can stand at a place of the
//! command line.
//!
//! The script that a shell loads holds no word of ours: at every TAB it runs the program with
//! `VARIABLE` set, so that machines, devices, sweeps and keys are those of the installed version.

mod bash;
mod values;

use clap::{Command, CommandFactory};
use clap_complete::env::{CompleteEnv, EnvCompleter, Fish, Shells, Zsh};

use super::{Cli, Context, Exit, Failure, OrExit, out};
use bash::Bash;

/// Set by the scripts when a shell wants completions.
const VARIABLE: &str = "POWERGS_SIM_COMPLETE";

/// The program's name in every shell.
const NAME: &str = "powergs-sim";

/// Shown under `completions --help`.
pub const EXAMPLES: &str = "\
Examples:
  mkdir -p ~/.local/share/bash-completion/completions
  powergs-sim completions bash \\
    > ~/.local/share/bash-completion/completions/powergs-sim
  powergs-sim completions zsh > \"${fpath[1]}/_powergs-sim\"
  powergs-sim completions fish > ~/.config/fish/completions/powergs-sim.fish

For this shell only: source <(powergs-sim completions bash)
Completed are commands, flags, their values, names of `arch list`, keys behind
--set, and files.";

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: Supported,
}

/// Shells with completions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Supported {
    /// Bourne-again shell
    Bash,
    /// Z shell
    Zsh,
    /// The friendly interactive shell
    Fish,
}

/// Prints the script.
pub fn run(args: &CompletionsArgs, _context: &Context) -> Result<Exit, Failure> {
    let shell: &dyn EnvCompleter = match args.shell {
        Supported::Bash => &Bash,
        Supported::Zsh => &Zsh,
        Supported::Fish => &Fish,
    };
    let mut script = Vec::new();
    shell
        .write_registration(VARIABLE, NAME, NAME, NAME, &mut script)
        .or_exit(Exit::Internal, "completions")?;
    out::write(|out| out.write_all(&script))?;
    Ok(Exit::Done)
}

/// Answers a shell that wants completions, and ends the program then; otherwise does nothing.
pub fn answer() {
    let shells = Shells(&[&Bash, &Zsh, &Fish]);
    CompleteEnv::with_factory(command).var(VARIABLE).shells(shells).complete();
}

/// The command line with what can stand at each place of it.
pub fn command() -> Command {
    values::known(Cli::command())
}
