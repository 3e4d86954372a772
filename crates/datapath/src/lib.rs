//! The bit-exact model of the hardware in `rtl/`.
//!
//! Numbers are floating point of 8 to 16 bits ([`NumberFormat`]); every operation gives the bits
//! that the module of the same name in `rtl/` gives. Nothing here knows a clock: how many cycles
//! things take is stated in `rtl/README.md` and measured by co-simulation.

mod arithmetic;
pub mod ccu;
mod exponential;
mod format;
pub mod vectors;
mod vrc;
mod vru;
mod wide;

pub use format::{FormatError, NumberFormat};
pub use vrc::{Form, Outcome, Pixel, Reach, Record, TILE, Vrc};
pub use vru::{Entry, SUBTILES, TileRun, Vru};
pub use wide::WideFormat;
