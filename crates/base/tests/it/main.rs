//! Measures with units.

mod quantities;
