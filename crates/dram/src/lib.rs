//! External memory as banks, rows and buses: what a stream of addresses costs.
//!
//! Three levels of one device ([`Device`], a file of `arch-configs/dram/`):
//!
//! | level | type | what it knows |
//! |---|---|---|
//! | banked | [`Banked`] | every command of every bank; event driven, no cycle is stepped |
//! | window | [`Windowed`] | counts per 2048 x 64 B of program order |
//! | flat | key `energy.flat` | energy per requested byte, no time |
//!
//! All times are in CK, the command clock of the device. `docs/dram.md` has the rules, the mappings
//! and how far the levels agree with public simulators.

pub mod address_trace;
pub mod banked;
mod commands;
pub mod device;
pub mod drive;
pub mod energy;
pub mod levels;
mod mapping;
pub mod stats;
mod windowed;

pub use banked::{AddressRange, Banked, Request};
pub use commands::{DramCommands, StageCommands};
pub use device::{Device, Energy};
pub use drive::{Drive, Mode, Run};
pub use energy::{CommandPrices, EnergyUse};
pub use mapping::{Decoder, Place};
pub use stats::{Latency, Stats};
pub use windowed::Windowed;
