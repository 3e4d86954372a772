//! Are images and counters right?

mod dual;
mod gradient_naive;
mod gradients;
mod naive;
pub mod reference;
pub mod support;
mod twin;
