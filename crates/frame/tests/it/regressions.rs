//! What was wrong once, by what was wrong with it.

mod fovea;
