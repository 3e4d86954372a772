//! What was once wrong, a test each, named after it.

#[cfg(unix)]
mod again;
mod charts;
#[cfg(unix)]
mod handout;
