//! `--demo`: the generated scene, its views and its space.

use super::super::{Failure, demo_scene};
use powergs_scene::Camera;

/// Every how many-th of its 96 views.
const EVERY: usize = 6;
/// Image size, pixels.
const IMAGE: (u32, u32) = (160, 160);
/// Iterations of a fine-tune.
pub const ITERATIONS: u32 = 400;

/// The space: six models and 36 machines.
pub const SPACE: &str = include_str!("demo.toml");

/// The views.
pub fn views(size: Option<(u32, u32)>) -> Result<Vec<Camera>, Failure> {
    demo_scene::views(EVERY, size.unwrap_or(IMAGE))
}
