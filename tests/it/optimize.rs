//! The optimiser as the user sees it.

pub mod command;
mod foveated_command;
mod own_campaign;
mod photos_command;
mod reprice_command;
// Tests of the crate use more of it.
#[allow(dead_code)]
#[path = "../../crates/optimize/tests/it/scenes.rs"]
mod scenes;
