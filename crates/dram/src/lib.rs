//! External memory as banks, rows and buses: what a stream of addresses costs.
//!
//! A device ([`Device`], a file of `arch-configs/dram/`) is simulated with every command of every
//! bank ([`Banked`]), event driven: no cycle is stepped.
//!
//! All times are in CK, the command clock of the device. `docs/dram.md` has the rules, the mappings
//! and how far it agrees with public simulators.

pub mod address_trace;
pub mod banked;
mod commands;
pub mod device;
pub mod drive;
pub mod energy;
mod mapping;
pub mod stats;
pub mod stream;

pub use banked::{AddressRange, Banked, Rank, Request};
pub use commands::{DramCommands, StageCommands};
pub use device::{Device, Energy};
pub use drive::{Drive, Mode, Run};
pub use energy::{CommandPrices, EnergyUse};
pub use mapping::{Decoder, Place};
pub use stats::{Latency, Stats};
