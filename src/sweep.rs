//! Sweeps: one file states a question, a base machine and axes; what comes of it are designs.
//!
//! [`expr`] is the language of derived keys, constraints, conditions and filters.

pub mod expr;
pub mod journal;
pub mod measure;
pub mod metric;
pub mod outcome;
pub mod parquet;
pub mod table;
