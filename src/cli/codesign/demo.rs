//! `--demo`: the generated scene, its views and its space.

use super::super::{Exit, Failure};
use powergs_scene::camera::edit;
use powergs_scene::synth::{Preset, cameras, generate};
use powergs_scene::{Camera, Gaussians};

/// The preset: a toy before black.
const PRESET: &str = "lego";
/// Gaussians, and the seed.
const MODEL: (usize, u64) = (6_000, 1);
/// Gaussians are drawn this many times as large as the preset makes them: generated scenes have
/// several layers of everything, and with these overlaps pruning would cost no quality.
const SIZE: f32 = 0.4;
/// Every how many-th of its 96 views.
const EVERY: usize = 6;
/// Image size, pixels.
const IMAGE: (u32, u32) = (160, 160);
/// Iterations of a fine-tune.
pub const ITERATIONS: u32 = 400;

/// The space: six models and 36 machines.
pub const SPACE: &str = include_str!("demo.toml");

fn preset() -> Result<&'static Preset, Failure> {
    let gone = || Failure::new(Exit::Internal, "the demonstration scene is gone");
    Preset::named(PRESET).ok_or_else(gone)
}

/// The dense model.
pub fn model() -> Result<Gaussians, Failure> {
    let mut model = generate(preset()?, MODEL.0, MODEL.1);
    model.log_scales.iter_mut().flatten().for_each(|s| *s += SIZE.ln());
    Ok(model)
}

/// The views.
pub fn views(size: Option<(u32, u32)>) -> Result<Vec<Camera>, Failure> {
    let (width, height) = size.unwrap_or(IMAGE);
    let views = cameras(preset()?).into_iter().step_by(EVERY);
    Ok(views.map(|c| edit::resized(&c, width, height)).collect())
}
