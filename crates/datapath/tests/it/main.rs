//! Tests of the bit-exact model, one file per topic.

mod ccu;
mod ccu_hardware;
mod numbers;
mod units;
mod verilator;
mod vrc;
mod vru;
