//! Runs beside each other: tables, charts, files.

mod charts;
mod output;
mod text;

pub use charts::charts;
pub use output::{compare_csv, json, run_toml};
pub use text::{markdown, note, terminal};
