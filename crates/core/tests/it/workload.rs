//! Does binning count what the rasteriser does, and what a direct count finds?

mod binning;
mod cache;
mod contribution;
mod counts;
mod demand;
mod naive;
mod reuse;
mod sorting;
pub mod support;
mod tiles;
