//! Published numbers beside ours: how far the simulator can be trusted.
//!
//! `tests/validation/published.csv` has one [`Row`] per published number that our knobs can
//! express. Its [`Status`] says what it is good for: evidence, or something less. A row is measured
//! on a machine (and, for a ratio, against another one) with [`Workload`]s of `workloads.csv`:
//! synthetic scenes that are made to match published statistics. [`measure()`] renders every view
//! once, bins it once per geometry, and takes it through all machines that want it. [`judge()`]
//! compares with the tolerance of the row and with what came out the last time (`baseline.csv`).
//!
//! This module opens no file: the caller hands in the texts and the systems.

mod held;
mod judge;
mod ledger;
mod metric;
pub mod numbers;
mod row;
pub mod run;
mod totals;
mod workload;

pub use held::{HeldRows, headline, rows_of, stored_model};
pub use judge::{Judged, Verdict, judge};
pub use ledger::{Evidence, Family, LedgerRow, RowLedger, RowOff, RowStanding, definition};
pub use metric::{Block, Metric};
pub use numbers::{Baseline, Parts, Tables, TablesError};
pub use row::{Gap, MachineName, Row, Status, Tolerance};
pub use run::{Built, Measurements, measure};
pub use workload::Workload;

/// The rows that come with the program.
pub const PUBLISHED: &str = include_str!("../validation/published.csv");
/// Their workloads.
pub const WORKLOADS: &str = include_str!("../validation/workloads.csv");
/// What they are worth as evidence.
pub const LEDGER: &str = include_str!("../validation/ledger.csv");
/// What came out the last time.
pub const BASELINE: &str = include_str!("../validation/baseline.csv");
