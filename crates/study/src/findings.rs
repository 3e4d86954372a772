//! What runs say: conclusions as values, without a word of a page or a pixel of a chart.
//!
//! All of them are made from [`RunSummary`], the typed means over the frames of a run.

pub mod bottleneck;
pub mod breakdown;
pub mod compare;
pub mod cost;
pub mod limits;
pub mod prices;
pub mod roofline;
pub mod sensitivity;
pub mod summary;
pub(crate) mod tile_load;
pub mod what_if;

pub use bottleneck::{Bottleneck, Limit};
pub use summary::RunSummary;
pub use tile_load::{Picture, TileLoad};
pub use what_if::WhatIf;
