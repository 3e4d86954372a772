//! What was once wrong, a test each, named after it.

#[cfg(unix)]
mod again;
#[cfg(unix)]
mod handout;
