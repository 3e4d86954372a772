//! The ground floor of `powergs-sim`: measures with units, TOML files with good errors, pictures in
//! memory.

pub mod config;
pub mod picture;
pub mod quantity;
