//! The generated scene of `optimize --demo` and `codesign --demo`.

use super::{Exit, Failure};
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

/// Every `every`-th of its 96 views, of this many pixels.
pub fn views(every: usize, (width, height): (u32, u32)) -> Result<Vec<Camera>, Failure> {
    let views = cameras(preset()?).into_iter().step_by(every);
    Ok(views.map(|c| edit::resized(&c, width, height)).collect())
}
