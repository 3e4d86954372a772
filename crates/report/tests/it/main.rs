//! Reports: every format from hand-made runs.

pub mod builder;
mod charts;
mod compare;
mod compare_opposites;
mod document;
mod formats;
mod foveated;
pub mod foveated_run;
mod json;
mod limits;
mod machine;
mod regressions;
mod results;
mod statistics;
mod text;
mod timeline;
mod validation;
