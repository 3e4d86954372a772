//! Eccentricity maps, levels of tiles, gaze streams.

mod levels;
mod stream;
