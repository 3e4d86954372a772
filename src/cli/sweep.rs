//! `sweep`: many designs on some traces, resumable and in parts.

pub mod args;
pub mod confirm;
mod dry_run;
mod finish;
mod meter;
mod parts;
mod run;
mod show;
mod slurm;

pub use args::{EXAMPLES, SweepCommandArgs};

use args::Command;

use super::{Context, Exit, Failure};

/// Runs the command.
pub fn run(args: &SweepCommandArgs, context: &Context) -> Result<Exit, Failure> {
    match &args.command {
        None => run::run(&args.sweep, context),
        Some(Command::Status(args)) => parts::status(args, context),
        Some(Command::Merge(args)) => parts::merge(args, context),
        Some(Command::Show(args)) => show::show(args, context),
    }
}
