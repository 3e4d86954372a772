//! What was wrong once, by what was wrong with it.

#[cfg(unix)]
mod again;
mod charts;
mod fovea;
#[cfg(unix)]
mod handout;
mod inputs;
mod optimiser;
mod prices;
mod scenes;
