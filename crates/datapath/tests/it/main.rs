//! Tests of the bit-exact model, one file per topic.

mod numbers;
mod units;
mod verilator;
mod vrc;
mod vru;
