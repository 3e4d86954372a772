//! Mapped netlists of the units in `rtl/`: what their gates do, and what a toggle of each costs.
//!
//! ```text
//! Yosys JSON ─► yosys ─┐
//! Liberty ──► liberty ─┴─► price ─► Netlist ─► simulator ─► toggles ─► energy
//!                                   (file)
//! ```
//!
//! A [`Netlist`](netlist::Netlist) carries everything that simulation and pricing need, so that
//! who has one needs neither a library nor a tool. There is no layout behind any of it: loads are
//! pins and the library's wire-load model, and the clock is ideal.

pub mod characterise;
pub mod committed;
pub mod energy;
pub mod function;
pub mod liberty;
pub mod netlist;
pub mod price;
pub mod simulator;
pub mod slew;
pub mod yosys;
