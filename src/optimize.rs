//! The PowerGS optimiser: the fewest watts at a given quality.

pub mod fit;
