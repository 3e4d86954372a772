//! What was once wrong, one test for each, named after it.

mod kept;
mod sizes;
