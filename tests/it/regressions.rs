//! What was once wrong in the program, one test for each, named after it.

mod optimiser;
