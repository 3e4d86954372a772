//! Runs beside each other: tables, charts, files.

mod charts;
mod decision;
mod output;
mod page;

pub use charts::{breakdown, charts, steps as steps_chart};
pub use decision::{chart as decision_chart, table as decision_table};
pub use output::{
    compare_csv, compare_csv_of, decision_csv, decision_json, json, json_of, run_toml, run_toml_of,
};
pub use page::{Decided, caveats, document, document_of, note};
