//! Published numbers beside ours: how far the simulator can be trusted.
//!
//! `tests/validation/published.csv` has one [`Row`] per published number that our knobs can
//! express. A row is measured on a machine (and, for a ratio, against another one) with a
//! [`Workload`] of `workloads.csv`: a synthetic scene that is made to match published statistics,
//! never to match a row. [`measure()`] renders every view once, bins it once per geometry, and
//! takes it through all machines that want it. [`judge()`] compares with the tolerance of the row
//! and with what came out the last time (`baseline.csv`).
//!
//! This module opens no file: the caller hands in the texts and the systems.

mod judge;
mod metric;
pub mod numbers;
mod row;
pub mod run;
mod totals;
mod workload;

pub use judge::{Judged, Verdict, judge};
pub use metric::Metric;
pub use numbers::{Baseline, Tables, TablesError};
pub use row::{MachineName, Origin, Row, Status, Tolerance};
pub use run::{Built, Measurements, measure};
pub use workload::Workload;

/// The rows that come with the program.
pub const PUBLISHED: &str = include_str!("../../../tests/validation/published.csv");
/// Their workloads.
pub const WORKLOADS: &str = include_str!("../../../tests/validation/workloads.csv");
/// What came out the last time.
pub const BASELINE: &str = include_str!("../../../tests/validation/baseline.csv");
