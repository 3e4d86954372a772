//! The command line: exit codes, output, and what happens around a command.

mod program;
mod replay;
mod run_folder;
