//! Reports: every format from hand-made runs.

pub mod builder;
mod charts;
mod compare;
mod formats;
mod json;
mod scale;
mod statistics;
mod text;
mod timeline;
