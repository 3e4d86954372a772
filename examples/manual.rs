//! Manual pages of the program and of each of its commands, into a folder:
//! `cargo run --example manual -- man`.

use std::path::PathBuf;

use clap::CommandFactory;
use powergs_sim::cli::Cli;

fn main() -> std::io::Result<()> {
    let folder: PathBuf = std::env::args_os().nth(1).unwrap_or_else(|| "man".into()).into();
    std::fs::create_dir_all(&folder)?;
    clap_mangen::generate_to(Cli::command(), folder)
}
