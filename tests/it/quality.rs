//! Losses and metrics: the published vectors, naive twins, finite differences, hostile pictures.

mod flip;
mod loss;
mod pictures;
