//! Are images and counters right?

mod naive;
pub mod reference;
pub mod support;
mod twin;
