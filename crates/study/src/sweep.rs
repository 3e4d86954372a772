//! Sweeps: one file states a question, a base machine and axes; what comes of it are designs.
//!
//! [`mod@file`] is the file as it is written, [`space`] what it spans: points, found by number and
//! never held all at once, each of which is a [`design`] or is left out for a reason. [`sample`]
//! chooses points beforehand, [`search`] as results come in. [`expr`] is the language of derived
//! keys, constraints, conditions and filters.

mod axis;
pub mod design;
pub mod docs;
pub mod expr;
pub mod file;
pub mod gathered;
pub mod key;
pub mod lattice;
mod library;
pub mod measure;
pub mod metric;
pub(crate) mod objective;
pub mod outcome;
pub mod parquet;
mod range;
mod record;
pub mod run;
pub mod sample;
pub mod search;
pub mod space;
pub mod table;
pub mod unit;

pub use design::{Design, Rejected};
pub use file::SweepFile;
pub use objective::{Goal, Objective};
pub use record::Record;
pub use space::{Point, Space};
