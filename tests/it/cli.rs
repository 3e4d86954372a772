//! The command line: exit codes, output, and what happens around a command.

mod background;
mod characterise;
mod claims;
mod compare;
mod completions;
mod datapath;
pub mod explain;
mod memory;
mod output_file;
mod program;
mod replay;
mod run_folder;
mod validate;
mod vectors;
