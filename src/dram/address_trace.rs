//! Address traces.
