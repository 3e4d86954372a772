//! What was once wrong: a test for each, named after what was wrong.

mod calibrated;
mod inputs;
mod prices;
