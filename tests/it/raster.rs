//! Are images and counters right?

mod gradients;
mod naive;
pub mod reference;
pub mod support;
mod twin;
