//! The ground floor of `powergs-sim`: measures with units, number formats, TOML files with good
//! errors, pictures in memory.

pub mod budget;
pub mod build;
pub mod config;
pub mod format;
pub mod number;
pub mod picture;
pub mod quantity;
pub mod shell;

/// Version of the shape of `--json`, CSV and `run.toml`. Raised when a name changes its meaning or
/// goes away; new names alone do not raise it.
pub const SCHEMA_VERSION: u32 = 3;

pub use build::TOOL_VERSION;
