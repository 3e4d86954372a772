//! Losses and metrics: the published vectors, naive twins, finite differences, hostile pictures.

mod loss;
mod pictures;
