//! Are images, counters and gradients right?

mod dual;
mod foveated;
mod gradient_naive;
mod gradients;
mod lists;
mod naive;
mod reference;
mod trace;
mod twin;
