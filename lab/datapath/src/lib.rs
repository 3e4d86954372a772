//! The bit-exact model of the hardware in `rtl/`.
//!
//! Numbers are floating point of 8 to 16 bits ([`NumberFormat`]); every operation gives the bits
//! that the module of the same name in `rtl/` gives. Nothing here knows a clock: how many cycles
//! things take is stated in `rtl/README.md` and measured by co-simulation.

mod arithmetic;
pub mod ccu;
mod exponential;
pub mod vectors;
mod vrc;
mod vru;

pub use arithmetic::{Arithmetic, Exponential};
pub use powergs_base::number::{FormatError, NumberFormat, WideFormat};
pub use vrc::{Form, Outcome, Pixel, Reach, Record, TILE, Vrc};
pub use vru::{Entry, SUBTILES, TileRun, Vru};
