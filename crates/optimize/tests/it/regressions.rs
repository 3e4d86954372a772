//! What was once wrong, one test for each, named after it.

mod counted;
mod kept;
mod passed;
mod sizes;
