//! The laboratory: what the hardware in `rtl/` does on real work, bit for bit and gate for gate,
//! and how finished optimisations stand against what was published. A program of its own, so that
//! who only simulates carries none of it.

#![allow(clippy::missing_errors_doc)] // commands fail with `Failure`, which has the exit code

pub mod characterise;
pub mod chip;
pub mod claims;
mod core_work;
mod front_end;
mod picture;
pub mod render;
mod unit_work;
pub mod vectors;

use clap::{Parser, Subcommand};

use powergs_sim::cli::{Context, Exit, Failure, Global};

pub use core_work::{CorePixels, CoreSplat, CoreWork, TileWork, core_work, tile_work};
pub use front_end::{FrontEnd, render_hardware};
pub use picture::render_datapath;

/// The laboratory of powergs-sim: its units as gates and bit for bit.
#[derive(Debug, Parser)]
#[command(name = "powergs-lab", version, max_term_width = 80)]
pub struct Cli {
    /// Flags that every command takes.
    #[command(flatten)]
    pub global: Global,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Price what a unit does, from its gates and real work
    #[command(after_help = characterise::EXAMPLES)]
    Characterise(characterise::Args),
    /// Write real work of a unit, and what becomes of it, for a test bench of its RTL
    #[command(after_help = vectors::EXAMPLES)]
    Vectors(vectors::Args),
    /// Render views of a scene as the hardware draws them, beside f32
    #[command(after_help = render::EXAMPLES)]
    Render(render::Args),
    /// Run the cores of rtl/ beside the cycle model, on the same lists
    #[command(after_help = chip::EXAMPLES)]
    Chip(chip::Args),
    /// Write what each assumption of the cycle model is off by, from runs of rtl/
    #[command(after_help = chip::assumptions::EXAMPLES)]
    Assumptions(chip::assumptions::Args),
    /// Check the published claims on finished optimisations
    #[command(after_help = claims::command::EXAMPLES)]
    Claims(claims::command::Args),
}

/// Runs one command.
pub fn run(cli: &Cli, context: &Context) -> Result<Exit, Failure> {
    match &cli.command {
        Command::Characterise(args) => characterise::run(args, context),
        Command::Vectors(args) => vectors::run(args, context),
        Command::Render(args) => render::run(args, context),
        Command::Chip(args) => chip::run(args, context),
        Command::Assumptions(args) => chip::assumptions::run(args, context),
        Command::Claims(args) => claims::command::run(args, context),
    }
}
