//! What runs say: conclusions as values, without a word of a page or a pixel of a chart.
//!
//! They are drawn from the [`Record`] of a run: every statistic of the catalogue over its frames.

pub mod bottleneck;
pub mod breakdown;
pub mod compare;
pub mod cost;
pub mod limits;
pub mod masters;
pub mod prices;
pub mod roofline;
pub mod sensitivity;
pub(crate) mod tile_load;
pub mod what_if;

pub use bottleneck::{Bottleneck, Limit};
pub use powergs_core::sim::statistics::{Key, Record};
pub use tile_load::{Picture, TileLoad};
pub use what_if::WhatIf;
