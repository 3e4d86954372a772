//! The culling and conversion unit: what `rtl/ccu.sv` makes of Gaussians, bit for bit.
//!
//! Three data-flow graphs of floating-point operations ([`programs`]) cull, project and colour; a
//! schedule ([`schedule`]) folds each of them over a few operators, and [`emit`] writes it down for
//! `rtl/`. Box tests and the part of a record that differs from tile to tile are whole numbers
//! ([`tiles`]).
//!
//! Geometry has a wide number format, because whole-pixel steps begin at 1,024 in FP16 and squares
//! of covariances overflow; what leaves the unit has the narrow format of the other units.

mod binding;
pub mod emit;
pub mod graph;
pub mod programs;
pub mod schedule;

mod special;
pub mod tiles;
mod unit;

pub use special::{reciprocal_table, root_table};
pub use unit::{Ccu, Converted, Gaussian, Projected, Settings, Verdict, camera};
