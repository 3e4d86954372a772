//! Trace files: round trips, hostile bytes, the worked example of the documentation.

mod cli;
mod codec;
mod example;
mod hostile;
mod round_trip;
mod rules;
mod seal;
pub mod support;
mod transform;
