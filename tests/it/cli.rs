//! The command line: exit codes, output, and what happens around a command.

mod again;
mod background;
mod certificate;
mod compare;
mod completions;
pub mod explain;
mod memory;
mod output_file;
mod pack;
mod program;
mod replay;
mod run_folder;
mod train;
mod validate;
