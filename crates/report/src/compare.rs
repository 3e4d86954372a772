//! Runs beside each other: tables, charts, files.

mod charts;
mod output;
mod page;

pub use charts::{breakdown, charts};
pub use output::{compare_csv, compare_csv_of, json, run_toml, run_toml_of};
pub use page::{document, document_of, note};
