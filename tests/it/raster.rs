//! Are images and counters right?

mod naive;
mod reference;
mod support;
mod twin;
