//! Does binning count what the rasteriser does, and what a direct count finds?

mod counts;
mod naive;
mod support;
mod tiles;
