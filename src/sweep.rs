//! Sweeps: one file states a question, a base machine and axes; what comes of it are designs.
//!
//! [`expr`] is the language of derived keys, constraints, conditions and filters.

pub mod expr;
pub mod measure;
