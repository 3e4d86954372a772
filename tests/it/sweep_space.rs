//! Sweep files and the design spaces that they span.

mod expr;
