//! What every key of a machine's files moves, one key at a time: elasticities, what a factor of two
//! does, and the keys that move nothing.

mod chart;
mod formats;
mod page;

pub use chart::charts;
pub use formats::{csv, elasticities_csv, json};
pub use page::document;
