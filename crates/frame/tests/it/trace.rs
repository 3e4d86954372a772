//! Trace files: round trips, hostile bytes, the worked example of the documentation.

mod codec;
mod example;
mod hostile;
mod round_trip;
mod rules;
mod seal;
mod transform;
