//! Foveation: levels, models, pictures, frames, machines.

mod command;
mod frames;
mod levels;
mod model;
mod picture;
mod stream;
pub mod support;
