//! Sweep files and the design spaces that they span.

mod examples;
mod expr;
mod file;
mod mistakes;
mod sample;
mod search;
mod space;
