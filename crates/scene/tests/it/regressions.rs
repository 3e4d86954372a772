//! What was once wrong.

mod coarse;
mod dialects;
mod foreign;
mod gltf;
