//! Measures with units, and files on bases.

mod layers;
mod quantities;
mod sha256;
mod shell;
