//! Reports: every format from hand-made runs.

pub mod builder;
mod charts;
