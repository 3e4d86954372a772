//! Losses and metrics: the published vectors, naive twins, finite differences, hostile pictures.

mod d22;
mod eccentricity;
mod flip;
mod hvsq;
mod loss;
mod lpips;
mod pictures;
