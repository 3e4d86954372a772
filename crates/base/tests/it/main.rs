//! Measures with units, and files on bases.

mod layers;
mod quantities;
mod shell;
