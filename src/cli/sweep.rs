//! `sweep`: many designs on some traces, resumable and in parts.

pub mod args;
mod columns;
mod dry_run;
mod estimate;
mod files;
pub(super) mod finish;
mod folder;
mod meter;
mod opened;
mod output;
mod parts;
mod plan;
mod records;
mod run;
mod running;
mod search;
mod slurm;
mod state;
mod store;
mod summary;
mod traces;
mod window;
mod work;

pub use args::{Args, EXAMPLES};
pub use files::DiskFiles;
pub use opened::find_base;

use args::Command;

use super::{Context, Exit, Failure};

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    match &args.command {
        None => run::run(&args.sweep, context),
        Some(Command::Status(args)) => parts::status(args, context),
        Some(Command::Merge(args)) => parts::merge(args, context),
        Some(Command::Show(args)) => parts::show(args, context),
    }
}
