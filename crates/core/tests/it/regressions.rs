//! What was once wrong: a test for each, named after what was wrong.

mod inputs;
mod prices;
